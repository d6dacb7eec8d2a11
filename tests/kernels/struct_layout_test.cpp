// SPDX-License-Identifier: Apache-2.0
// Host and device read the same structs (kernels/lucarium/shared/*.h): sizes and offsets of every field must agree. The
// test reads the headers themselves, so that no list of structs or fields has to be kept: the host's layout follows
// from the field types' size and alignment in C++ (the dialect allows only types for which that is the whole rule) and
// from the sizes that the headers assert; the device's is asked from the device.
#include <doctest/doctest.h>

#include <algorithm>
#include <regex>
#include <sstream>

#include "kernel_fixture.h"
#include "lucarium/compute/program/source_library.h"
#include "lucarium/shared/camera.h"
#include "lucarium/shared/gbuffer.h"

const lucarium::EmbeddedSources& lucarium_kernels();

using namespace lucarium;

namespace {

struct Type {
  size_t bytes, alignment;
};

struct Field {
  std::string name, type;
  size_t offset, bytes;
};

struct Struct {
  std::string name, header;
  std::vector<Field> fields;
  size_t asserted_bytes;
};

template <class T>
Type type_of() {
  return {sizeof(T), alignof(T)};
}

size_t round_up(size_t value, size_t multiple) { return (value + multiple - 1) / multiple * multiple; }

/// The types of the dialect, and one after the other the structs.
std::map<std::string, Type>& types() {
  static std::map<std::string, Type> known = {
      {"float", type_of<float>()},   {"int", type_of<int>()},       {"uint", type_of<uint>()},
      {"float2", type_of<float2>()}, {"float4", type_of<float4>()}, {"int2", type_of<int2>()},
      {"int4", type_of<int4>()},     {"uint2", type_of<uint2>()},   {"uint4", type_of<uint4>()}};
  return known;
}

Struct parse_struct(const std::string& name, const std::string& header, const std::string& body, size_t asserted) {
  Struct result{name, header, {}, asserted};
  size_t offset = 0, alignment = 1;
  static const std::regex declaration(R"((\w+)\s+([\w\s,]+);)");
  for (std::sregex_iterator i(body.begin(), body.end(), declaration), end; i != end; ++i) {
    const std::string type = (*i)[1];
    REQUIRE_MESSAGE(types().count(type) == 1,
                    "type " << type << " in " << name << " is neither of the dialect nor of a header before it");
    std::stringstream names((*i)[2]);
    for (std::string field; std::getline(names, field, ',');) {
      field.erase(std::remove_if(field.begin(), field.end(), ::isspace), field.end());
      offset = round_up(offset, types()[type].alignment);
      result.fields.push_back({field, type, offset, types()[type].bytes});
      offset += types()[type].bytes;
      alignment = std::max(alignment, types()[type].alignment);
    }
  }
  types()[name] = {round_up(offset, alignment), alignment};
  return result;
}

/// Every struct of every shared header, in alphabetical order of the headers.
std::vector<Struct> shared_structs() {
  std::vector<Struct> list;
  static const std::regex comment("//[^\n]*"),
      block(R"(\bLUCARIUM_STRUCT_BEGIN\((\w+)\)([^]*?)LUCARIUM_STRUCT_END\((\w+), (\d+)\))");
  for (const auto& [name, text] : lucarium_kernels()) {
    if (name.rfind("lucarium/shared/", 0) != 0 || name == "lucarium/shared/dialect.h") continue;
    const std::string code = std::regex_replace(std::string(text), comment, "");
    for (std::sregex_iterator i(code.begin(), code.end(), block), end; i != end; ++i) {
      REQUIRE((*i)[1] == (*i)[3]);
      list.push_back(parse_struct((*i)[1], name, (*i)[2], std::stoul((*i)[4])));
    }
  }
  return list;
}

/// A kernel that reports size, then offset and size of each field, struct by struct.
std::string report_kernel(const std::vector<Struct>& structs) {
  std::string source, body;
  for (const auto& [name, text] : lucarium_kernels()) {
    if (name.rfind("lucarium/shared/", 0) == 0) source += "#include \"" + name + "\"\n";
  }
  for (const Struct& s : structs) {
    body += "  *out++ = sizeof(" + s.name + ");\n";
    for (const Field& f : s.fields) {
      body += "  *out++ = __builtin_offsetof(" + s.name + ", " + f.name + ");\n";
      body += "  *out++ = sizeof(((" + s.name + "*)0)->" + f.name + ");\n";
    }
  }
  return source + "kernel void report(global uint* out) {\n" + body + "}\n";
}

}  // namespace

TEST_CASE("the device lays out shared structs as the host does") {
  const std::vector<Struct> structs = shared_structs();
  CHECK(structs.size() >= 15);
  size_t count = 0;
  for (const Struct& s : structs) count += 1 + 2 * s.fields.size();

  const std::string source = report_kernel(structs);
  const EmbeddedSources table = {{"test_kernels/report_layout.cl", source}};
  SourceLibrary library;
  library.add(table);
  ProgramSpec spec;
  spec.name = "report_layout";
  spec.files = {"test_kernels/report_layout.cl"};
  const Program program(*test::test_device(), library, spec);
  const auto out = test::test_buffer<uint>(count);
  test::run_kernel(program, "report", 1, 1, [&](PassBuilder& pass) { pass.arg("out", out); });

  const std::vector<uint> device = out.download();
  size_t next = 0;
  for (const Struct& s : structs) {
    CAPTURE(s.name);
    CHECK(s.asserted_bytes == types()[s.name].bytes);
    CHECK(device[next++] == s.asserted_bytes);
    for (const Field& f : s.fields) {
      CAPTURE(f.name);
      CHECK(device[next++] == f.offset);
      CHECK(device[next++] == f.bytes);
    }
  }
}

TEST_CASE("the layout rule of the test is the compiler's") {
  shared_structs();
  CHECK(types()["Frame"].bytes == sizeof(Frame));
  CHECK(types()["Frame"].alignment == alignof(Frame));
  CHECK(types()["GBufferPoint"].bytes == sizeof(GBufferPoint));
  for (const Struct& s : shared_structs()) {
    if (s.name != "Frame") continue;
    for (const Field& f : s.fields) {
      if (f.name == "max_bounces") CHECK(f.offset == offsetof(Frame, max_bounces));
      if (f.name == "camera") CHECK(f.offset == offsetof(Frame, camera));
      if (f.name == "width") CHECK(f.offset == offsetof(Frame, width));
    }
  }
}
