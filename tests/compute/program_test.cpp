// SPDX-License-Identifier: Apache-2.0
#include "lucarium/compute/program.h"

#include <doctest/doctest.h>

#include <cstdlib>
#include <fstream>

#include "lucarium/base/error.h"
#include "lucarium/compute/buffer.h"
#include "test_support.h"

using namespace lucarium;

namespace {

const EmbeddedSources sources = {
    {"probe/scale.cl",
     "#include \"probe/types.h\"\n"
     "/* #include \"nowhere.h\" */\n"
     "kernel __attribute__((reqd_work_group_size(8, 1, 1)))\n"
     "void scale(const global float4* restrict in, volatile global uint* out, constant float* table, Probe probe,\n"
     "           const uint n, local float* scratch) {\n"
     "  const uint i = get_global_id(0);\n"
     "  if (i < n) out[i] = (uint)(in[i].x * FACTOR * table[0] + probe.offset);\n"
     "}\n"
     "kernel void other(global int* values) { values[get_global_id(0)] = 1; }\n"},
    {"probe/types.h",
     "#ifndef TYPES_H\n#define TYPES_H\n#include \"probe/base.h\"\ntypedef struct Probe { float offset; int pad; } "
     "Probe;\n#endif\n"},
    {"probe/base.h", "#pragma once\n#define UNUSED 1\n"},
};

std::shared_ptr<Device> device() {
  static const auto instance = Device::open();
  return instance;
}

SourceLibrary library() {
  SourceLibrary result;
  result.add(sources);
  return result;
}

}  // namespace

TEST_CASE("a kernel's signature comes from the compiler") {
  const Program program(*device(), library(), {"probe", {"probe/scale.cl"}, {{"FACTOR", "2.0f"}}});
  CHECK(program.kernel_names() == std::vector<std::string>{"other", "scale"});
  const KernelSignature& signature = program.signature("scale");
  REQUIRE(signature.arguments.size() == 6);
  const char* names[] = {"in", "out", "table", "probe", "n", "scratch"};
  const char* types[] = {"float4*", "uint*", "float*", "Probe", "uint", "float*"};
  const ArgumentAccess accesses[] = {ArgumentAccess::read,  ArgumentAccess::read_write, ArgumentAccess::read,
                                     ArgumentAccess::value, ArgumentAccess::value,      ArgumentAccess::local};
  for (size_t i = 0; i < 6; ++i) {
    CHECK(signature.arguments[i].name == names[i]);
    CHECK(signature.arguments[i].type == types[i]);
    CHECK(signature.arguments[i].access == accesses[i]);
  }
  CHECK(signature.required_work_group_size[0] == 8);
  CHECK(program.signature("other").required_work_group_size[0] == 0);
  CHECK_THROWS_WITH_AS(program.signature("scal"), "program probe has no kernel 'scal'; did you mean 'scale'?", Error);
}
