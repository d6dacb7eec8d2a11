// SPDX-License-Identifier: Apache-2.0
#include "lucarium/compute/program/program.h"

#include <doctest/doctest.h>

#include <bit>
#include <cmath>

#include "compute_fixture.h"
#include "lucarium/compute/program/built_program.h"
#include "lucarium/compute/program/identifiers.h"
#include "lucarium/compute/program/source_library.h"

using namespace lucarium;
using namespace lucarium::test;

namespace {

Program build(const std::string& text, std::map<std::string, std::string> defines = {}, bool mad_enable = true) {
  const EmbeddedSources sources = {{"probe/main.cl", text},
                                   {"probe/wrong.clh", "float twice(float x) {\n  return 2 * y;\n}\n"}};
  SourceLibrary library;
  library.add(sources);
  return Program(*test_device(), library, {"probe", {"probe/main.cl"}, std::move(defines), mad_enable});
}

/// Checks what the compiler says of every kind of argument.
void check_signature(const Program& program) {
  CHECK(program.kernel_names() == std::vector<std::string>{"other", "scale"});
  const KernelSignature& signature = program.signature("scale");
  REQUIRE(signature.arguments.size() == 7);
  const char* names[] = {"in", "out", "table", "probe", "n", "scratch", "ids"};
  const char* types[] = {"float4*", "uint*", "float*", "Probe", "uint", "float*", "uint*"};
  using enum ArgumentAccess;
  const ArgumentAccess accesses[] = {read, read_write, read, value, value, local, read};
  for (size_t i = 0; i < 7; ++i) {
    CHECK(signature.arguments[i].name == names[i]);
    CHECK(signature.arguments[i].type == types[i]);
    CHECK(signature.arguments[i].access == accesses[i]);
  }
  CHECK(signature.required_work_group_size[0] == 8);
  CHECK(signature.required_work_group_size[1] == 1);
  CHECK(program.signature("other").required_work_group_size[0] == 0);
}

}  // namespace

TEST_CASE("a kernel's signature comes from the compiler, and from the cache the second time") {
  const TemporaryFolder folder;
  DeviceOptions options;
  options.cache_dir = folder.path();
  const EmbeddedSources sources = {
      {"probe/scale.cl",
       "typedef struct Probe { float offset; int pad; } Probe;\n"
       "typedef uint Id;\n"
       "kernel __attribute__((reqd_work_group_size(8, 1, 1)))\n"
       "void scale(const global float4* restrict in, volatile global uint* out, constant float* table, Probe probe,\n"
       "           const uint n, local float* scratch, global const uint* ids) {\n"
       "  const uint i = get_global_id(0);\n"
       "  if (i < n) out[i] = (uint)(in[i].x * FACTOR * table[0] + probe.offset) + ids[i];\n"
       "}\n"
       "kernel void other(global int* values) { values[get_global_id(0)] = 1; }\n"}};
  SourceLibrary library;
  library.add(sources);
  for (const bool cached : {false, true}) {
    CAPTURE(cached);
    const auto device = Device::open(options);  // which has no program yet
    const Program program(*device, library, {"probe", {"probe/scale.cl"}, {{"FACTOR", "2.0f"}}});
    CHECK(program.from_cache() == cached);
    CHECK(program.build_seconds() > 0);
    check_signature(program);
    const Error error = error_of([&] { program.signature("scal"); });
    CHECK(std::string(error.what()) == "program probe has no kernel 'scal'; did you mean 'scale'?");
  }
}

TEST_CASE("a compile error names the real file and line, and keeps the whole log") {
  const Error error = error_of(
      [] { build("#define A 1\n\n#include \"probe/wrong.clh\"\nkernel void k(global uint* v) { v[0] = z; }\n"); });
  CHECK(error.error_class() == ErrorClass::device);
  const std::string message = error.what();
  CHECK(has(message, "program probe does not compile: probe/wrong.clh:2:14: "));
  CHECK(has(message, "'y'"));
  CHECK(!has(message, "\n"));
  CHECK(has(error.details(), "probe/main.cl:4:"));
}

TEST_CASE("defines pass any value, and an empty one is 1") {
  const Program program =
      build("kernel void k(global uint* v) { v[get_global_id(0)] = SUM(FLAG, 4) + (sizeof(TEXT) == 10); }",
            {{"FLAG", ""}, {"SUM(a, b)", "((a) + (b))"}, {"TEXT", "\"a b 'c' d\""}});
  CHECK(launch(program, "k", 1, 1) == std::vector<uint32_t>{6});
  CHECK(error_of([] { build("", {{"A", "1\n2"}}); }).error_class() == ErrorClass::internal);
}

TEST_CASE("what differs by defines that its sources do not name is one program") {
  const std::map<std::string, std::string> all = {{"BOTH", "1"}, {"OF_OTHER(x)", "x"}, {"OTHER", "OF_OTHER(2)"}};
  const auto text = [](const std::string& sources, const std::map<std::string, std::string>& defines) {
    return program_text({"probe", {}, defines}, sources).source;
  };
  CHECK(named_defines(all, "int a = BOTH2 + MY_BOTH;").size() == 1);  // the value of OTHER names OF_OTHER
  CHECK(named_defines(all, "int a = OTHER;").size() == 2);
  CHECK(named_defines(all, "#ifdef BOTH\nint a = OTHER;\n#endif") == all);
  CHECK(named_defines({{"USE_GRID", ""}}, "#define USE(x) USE_##x\nint a = USE(GRID);").size() == 1);
  CHECK(named_defines({{"USE_GRID", ""}}, "#define USE(x) USE_##x\nint a = USE(GRIDS);").empty());
  CHECK(text("int a;", {{"A", "1"}}) == text("int a;", {}));
  CHECK(text("int a = A;", {{"A", "1"}}) != text("int a = A;", {{"A", "2"}}));
}

TEST_CASE("without mad_enable products and sums round one by one") {
  const char* text =
      "kernel void k(global uint* v) { const float a = as_float(v[0] + 0x3f800800u); v[0] = as_uint(a * a - 1.0f); }";
  const float a = std::bit_cast<float>(0x3f800800u);
  volatile float product = a * a;
  const uint32_t separate = std::bit_cast<uint32_t>(product - 1.0f);
  const uint32_t fused = std::bit_cast<uint32_t>(std::fma(a, a, -1.0f));
  REQUIRE(separate != fused);
  CHECK(launch(build(text, {}, false), "k", 1, 1) == std::vector<uint32_t>{separate});
}

TEST_CASE("a program without kernels is an error") {
  CHECK(has(error_of([] { build("float f(float x) { return x; }"); }).what(), "program probe has no kernels"));
}

TEST_CASE("child: compile vectors of 64 bytes as for a processor without AVX-512" * doctest::skip()) {
  DeviceOptions options;
  options.use_cache = false;
  const auto device = Device::open(options);
  const EmbeddedSources sources = {
      {"probe/wide.cl",
       "#ifdef __x86_64__\n#define OLD __attribute__((target(\"no-avx512f\"), noinline))\n#else\n#define OLD\n#endif\n"
       "OLD float16 twice(float16 x) { return x + x; }\n"
       "OLD void store(global float* out, float x) { out[0] = twice((float16)(x)).s7; }\n"
       "kernel void wide(global float* out, float x) { store(out, x); }\n"}};
  SourceLibrary library;
  library.add(sources);
  CHECK(Program(*device, library, {"probe", {"probe/wide.cl"}, {}}).kernel_names().size() == 1);
}

// clang's "31 warnings generated." at the first compile of the BVH, also with --quiet.
TEST_CASE("vectors of 64 bytes compile without a word on processors without AVX-512") {
  const ProgramResult result = run_case("child: compile vectors of 64 bytes as for a processor without AVX-512");
  CAPTURE(result.out);
  CHECK(result.exit_code == 0);
  CHECK(result.err == "");
}
