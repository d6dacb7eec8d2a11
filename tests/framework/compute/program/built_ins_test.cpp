// SPDX-License-Identifier: Apache-2.0
// Declarations of OpenCL C's functions that stand in for the driver's.
#include "lucarium/compute/program/built_ins.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <map>
#include <optional>
#include <set>

#include "../compute_fixture.h"
#include "lucarium/base/files/atomic_file.h"
#include "lucarium/base/files/embedded_files.h"
#include "lucarium/compute/program/source_library.h"

const lucarium::EmbeddedSources& lucarium_kernels();

using namespace lucarium;
using namespace lucarium::test;
namespace fs = std::filesystem;

namespace {

/// The header of PoCL 3.1, where Debian has it.
const fs::path driver_header = "/usr/share/pocl/include/opencl-c.h";

std::vector<std::string> parts_of(const std::string& text, char separator) {
  std::vector<std::string> parts(1);
  for (const char c : text) {
    if (c == separator)
      parts.emplace_back();
    else
      parts.back() += c;
  }
  return parts;
}

/// A parameter without its own name: "volatile __global int *p" is "volatile __global int*".
std::string plain_parameter(const std::string& text) {
  std::vector<std::string> words;
  for (const std::string& word : parts_of(text, ' '))
    if (!word.empty()) words.push_back(word);
  const bool is_pointer = text.find('*') != std::string::npos;
  if (!is_pointer) return words.empty() ? "" : words.front();
  std::string plain;
  for (const std::string& word : words) {
    plain += (plain.empty() || word[0] == '*' ? "" : " ") + word.substr(0, word.find('*'));
    if (word.find('*') != std::string::npos) return plain + '*';
  }
  return plain;
}

struct Declared {
  std::string name, signature;
  std::vector<std::string> types;  // the result's and the parameters'
};

/// Of a line "RESULT ATTRIBUTES NAME(PARAMETERS);", where attributes begin with `mark`.
std::optional<Declared> declaration_in(const std::string& line, const std::string& mark,
                                       const std::map<std::string, std::string>& attributes) {
  const size_t begin = line.find(' ' + mark), open = line.find('('), close = line.rfind(");");
  if (begin == std::string::npos || open == std::string::npos || close == std::string::npos) return std::nullopt;
  const size_t name = line.rfind(' ', open) + 1;
  Declared result;
  result.name = line.substr(name, open - name);
  result.types.push_back(line.substr(0, begin));
  for (const std::string& parameter : parts_of(line.substr(open + 1, close - open - 1), ','))
    result.types.push_back(plain_parameter(parameter));
  const std::string words = line.substr(begin + 1, name - begin - 2);
  const auto attribute = attributes.find(words);
  result.signature = (attribute == attributes.end() ? words : attribute->second) + ' ' + result.name;
  for (const std::string& type : result.types) result.signature += ' ' + type;
  return result;
}

bool is_half(const std::string& type) {
  return type.starts_with("half") || (type.find(" half") != std::string::npos && !type.ends_with(" half*"));
}

/// Whether OpenCL C 1.2 without half and without products of integers has it: no pointers without an address space.
bool is_of_our_language(const Declared& declared) {
  if (declared.name.empty() || (declared.name == "dot" && declared.types[0].ends_with("int"))) return false;
  if (declared.name == "prefetch" && declared.types[1].ends_with(" half*")) return false;
  return std::none_of(declared.types.begin(), declared.types.end(), [](const std::string& type) {
    const bool has_space = type.find("__") != std::string::npos;
    return is_half(type) || (type.ends_with('*') && !has_space);
  });
}

/// What `out` becomes where the driver's own declarations are used, and where ours are.
std::array<std::vector<uint32_t>, 2> both_ways(const std::string& text) {
  std::array<std::vector<uint32_t>, 2> results;
  for (const bool own : {false, true}) {
    const std::string source = (own ? "" : "// printf\n") + text;
    REQUIRE(declare_built_ins(source).has_value() == own);
    const EmbeddedSources sources = {{"functions.cl", source}};
    SourceLibrary library;
    library.add(sources);
    const Program program(*test_device(), library, {"functions", {"functions.cl"}});
    CHECK(program.declares_built_ins() == (own && can_declare_built_ins(test_device()->info())));
    results[own] = launch(program, "functions", 32, 8);
  }
  return results;
}

}  // namespace

TEST_CASE("each function is declared with the overloads of the driver's own header") {
  if (!fs::exists(driver_header)) return skip("PoCL's header opencl-c.h");
  std::map<std::string, std::set<std::string>> theirs, ours;
  std::string names;
  for (const std::string& line : parts_of(read_file(driver_header), '\n')) {
    const auto declared = declaration_in(line, "__ovld", {});
    if (!declared || !is_of_our_language(*declared) || !declare_built_ins(declared->name)) continue;
    theirs[declared->name].insert(declared->signature);
    names += declared->name + ' ';
  }
  const std::map<std::string, std::string> attributes = {{"LUCARIUM_PLAIN", "__ovld"},
                                                         {"LUCARIUM_CONST", "__ovld __cnfn"},
                                                         {"LUCARIUM_PURE", "__ovld __purefn"},
                                                         {"LUCARIUM_CONVERGENT", "__ovld __conv"}};
  for (const std::string& line : parts_of(declare_built_ins(names).value_or(""), '\n'))
    if (const auto declared = declaration_in(line, "LUCARIUM_", attributes))
      ours[declared->name].insert(declared->signature);
  CHECK(theirs.size() > 700);
  for (const auto& [name, signatures] : theirs) {
    INFO(name);
    CHECK(ours[name] == signatures);
  }
  CHECK(ours.size() == theirs.size());
}

TEST_CASE("what a source does not name is not declared, and what is not known here is left to the driver") {
  CHECK(has(declare_built_ins("y = fma(a, b, c);").value(), " fma(float8, float8, float8);"));
  CHECK(!has(declare_built_ins("y = fma(a, b, c);").value(), "mad("));
  CHECK(has(declare_built_ins("#define WIDE(name) name##4\nWIDE(vload)").value(), " vload4("));
  for (const char* unknown : {"printf", "native_sin", "fract", "shuffle", "read_imagef", "work_group_all", "half_sqrt"})
    CHECK(!declare_built_ins(fmt::format("x = {}(y);", unknown)));
  CHECK(declare_built_ins("half_of_it = my_printf + fractions;"));
}

TEST_CASE("the framework's kernels need no more than what is known here") {
  for (const auto& [name, text] : lucarium_kernels()) {
    INFO(name);
    CHECK(declare_built_ins(text));
  }
}

TEST_CASE("kernels compute the same with either declarations") {
  const auto results = both_ways(
      "kernel void functions(global uint* out) {\n"
      "  const uint i = get_global_id(0) + 8 * get_local_id(0);\n"
      "  const float x = 0.37f * i + 0.1f;\n"
      "  const float4 v = (float4)(x, -x, 1 / x, sqrt(x));\n"
      "  const int8 n = convert_int8_rtn((float8)(v, 3 * v));\n"
      "  const float y = dot(normalize(v.xyz), cross(v.xyz, v.zwx)) + mix(sin(x), exp2(-x), 0.3f) + fmax(v, 0.5f).y;\n"
      "  uint words[4];\n"
      "  vstore4(as_uint4(mad(v, y, rsqrt(fabs(v)))), 0, words);\n"
      "  const float z = pow(x, 0.7f) + atan2(y, x) + clamp(y, 0.1f, 0.2f) + select(x, y, isless(x, y));\n"
      "  barrier(CLK_LOCAL_MEM_FENCE);\n"
      "  atomic_xchg(out + get_global_id(0), as_uint(z) ^ (uint)(n.s3 + max(n, 2).s5) ^ mul_hi(i, 0x9e3779b9u) ^ "
      "popcount(i) ^ words[i % 4]);\n"
      "}\n");
  CHECK(results[0] == results[1]);
}

TEST_CASE("what compiles only with the driver's own declarations is compiled with them") {
  const EmbeddedSources sources = {{"pasted.cl",
                                    "#define PASTE(a, b) a##b\n"
                                    "kernel void pasted(global uint* out) {\n"
                                    "  float whole;\n"
                                    "  const float part = PASTE(fra, ct)(get_global_id(0) + 0.25f, &whole);\n"
                                    "  out[get_global_id(0)] = 100 * part + (uint)whole;\n"
                                    "}\n"}};
  REQUIRE(declare_built_ins(sources.begin()->second));
  SourceLibrary library;
  library.add(sources);
  const Program program(*test_device(), library, {"pasted", {"pasted.cl"}});
  CHECK_FALSE(program.declares_built_ins());
  CHECK(launch(program, "pasted", 3, 1) == std::vector<uint32_t>{25, 26, 27});
}
