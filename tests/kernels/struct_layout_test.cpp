// SPDX-License-Identifier: Apache-2.0
// Host and device read the same structs (kernels/shared/*.h): the device's sizes and offsets must be the host's.
#include <doctest/doctest.h>

#include <cstddef>

#include "kernel_fixture.h"
#include "lucarium/shared/camera.h"
#include "lucarium/shared/gbuffer.h"
#include "lucarium/shared/ray.h"
#include "lucarium/shared/surface_point.h"
#include "struct_fields.clh"

using namespace lucarium;

TEST_CASE("the device lays out shared structs as the host does") {
  struct Size {
    const char* name;
    size_t bytes;
  };
  struct Field {
    const char *owner, *name;
    size_t offset, bytes;
  };
  const std::vector<Size> sizes = {
#define SIZE(S) {#S, sizeof(S)},
      LUCARIUM_SHARED_STRUCTS(SIZE)};
  const std::vector<Field> fields = {
#define FIELD(S, f) {#S, #f, offsetof(S, f), sizeof(S::f)},
      LUCARIUM_SHARED_FIELDS(FIELD)};

  const auto device_sizes = test::test_buffer<uint>(sizes.size());
  const auto device_fields = test::test_buffer<uint>(2 * fields.size());
  test::run_kernel(test::kernel_program("struct_layout"), "report_layout", 1, 1, [&](PassBuilder& pass) {
    pass.arg("sizes", device_sizes).arg("fields", device_fields);
  });
  const std::vector<uint> got_sizes = device_sizes.download(), got_fields = device_fields.download();
  for (size_t i = 0; i < sizes.size(); ++i) {
    CAPTURE(sizes[i].name);
    CHECK(got_sizes[i] == sizes[i].bytes);
    // The list of fields is complete: they fill the struct.
    size_t filled = 0;
    for (const Field& field : fields) {
      if (std::string(field.owner) == sizes[i].name) filled += field.bytes;
    }
    CHECK(filled == sizes[i].bytes);
  }
  for (size_t i = 0; i < fields.size(); ++i) {
    CAPTURE(fields[i].owner);
    CAPTURE(fields[i].name);
    CHECK(got_fields[2 * i] == fields[i].offset);
    CHECK(got_fields[2 * i + 1] == fields[i].bytes);
  }
}
