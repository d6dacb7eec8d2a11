// SPDX-License-Identifier: Apache-2.0
#include "lucarium/services/dealt_rows/dealt_rows.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <vector>

#include "device_fixture.h"
#include "lucarium/compute/schedule/scheduler.h"

const lucarium::EmbeddedSources& test_services_kernels();

using namespace lucarium;
using namespace lucarium::test;

namespace {

constexpr const char* noting = "test_services/dealt_rows/note_rows";

/// What work-items 0 to `items` take of `count` rows.
std::vector<uint32_t> dealt(uint32_t items, uint32_t count, uint32_t columns) {
  const auto rows = test_buffer<uint32_t>(items);
  run_kernel(make_program(*test_device(), test_services_kernels(), {noting}, {}), "note_rows", items, 1,
             [&](PassBuilder& pass) { pass.arg("rows", rows).arg("count", count).arg("columns", columns); });
  return rows.download();
}

}  // namespace

TEST_CASE("each row is dealt to one work-item, and none to those behind the last") {
  for (const uint32_t columns : {1u, 2u, 4u, 8u, 16u})
    for (const uint32_t count : {1u, 2u, 3u, 7u, 16u, 17u, 40u, 160u, 1001u}) {
      std::vector<uint32_t> rows = dealt(count + 20, count, columns);
      INFO(count, " rows, ", columns, " columns");
      for (uint32_t i = count; i < rows.size(); ++i) CHECK(rows[i] >= count);
      rows.resize(count);
      std::sort(rows.begin(), rows.end());
      for (uint32_t i = 0; i < count; ++i) CHECK(rows[i] == i);
    }
}

TEST_CASE("work that lies side by side is shared by all parts of a pass") {
  // As many parts as columns: each has as many rows of any run, one more or less. With one column the order stays.
  const uint32_t count = 160;
  for (const uint32_t columns : {1u, 2u, 4u, 8u, 16u}) {
    const std::vector<uint32_t> rows = dealt(count, count, columns);
    CHECK(std::is_sorted(rows.begin(), rows.end()) == (columns == 1));
    for (uint32_t parts = 1; parts <= columns; parts *= 2)
      for (const auto& [begin, end] : std::vector<std::pair<uint32_t, uint32_t>>{{0, 80}, {80, 160}, {37, 91}}) {
        std::vector<uint32_t> found(parts);
        for (uint32_t i = 0; i < count; ++i)
          if (rows[i] >= begin && rows[i] < end) ++found[i * parts / count];
        INFO(columns, " columns, ", parts, " parts, rows ", begin, " to ", end);
        for (const uint32_t rows_of_part : found) {
          CHECK(rows_of_part + 1 >= (end - begin) / parts);
          CHECK(rows_of_part <= (end - begin) / parts + 1);
        }
      }
  }
}

TEST_CASE("passes of dealt rows take each row once, in as many columns as threads") {
  const std::shared_ptr<Device> device = test_device();
  const uint32_t threads = device->info().compute_units, columns = dealt_columns(*device);
  CHECK(columns <= 16);
  if (device->info().type == DeviceType::cpu) {
    CHECK(columns >= std::min(threads, 16u));
    CHECK(columns < std::max(2 * threads, 2u));
  }
  KernelScheduler scheduler(device);
  const Program program = make_program(*device, test_services_kernels(), {noting}, {});
  for (const uint32_t rows : {1u, 5u, 160u})
    for (const bool in_slices : {false, true}) {
      TypedBuffer<uint32_t> times(*device, "test", "times", rows);
      times.fill_zero();
      ScheduleRecorder recorder = scheduler.record("dealt rows", "test");
      PassBuilder pass = recorder.pass("note rows", program, in_slices ? "note_rows_of_slices" : "note_own_rows");
      deal_rows(pass, rows, *device);
      pass.arg("times", times);
      if (in_slices) pass.slice(7).arg("count", rows);
      Schedule schedule = recorder.compile();
      scheduler.run(schedule);
      scheduler.finish();
      CHECK(times.download() == std::vector<uint32_t>(rows, 1));
    }
}
