// SPDX-License-Identifier: Apache-2.0
#include "lucarium/services/ray_shares/ray_shares.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <vector>

#include "device_fixture.h"
#include "lucarium/compute/schedule/scheduler.h"
#include "lucarium/shared/ray_shares.h"

const lucarium::EmbeddedSources& test_services_kernels();

using namespace lucarium;
using namespace lucarium::test;

namespace {

/// Rays of a slice, between two looks at the cancel flag.
uint32_t slice_size() { return (1u << 15) * std::max(1u, test_device()->info().compute_units); }

struct Traced {
  std::vector<uint32_t> times, items;  ///< per ray: how often, by which work-item
};

/// Of a batch with room for `capacity` rays, of which `count` are there by the counter.
Traced trace_shares(uint32_t capacity, uint32_t count) {
  const std::shared_ptr<Device> device = test_device();
  KernelScheduler scheduler(device);
  const Program program = make_program(*device, test_services_kernels(), {"test_services/ray_shares/note_shares"}, {});
  const uint32_t room = std::max({1u, capacity, count});
  TypedBuffer<uint32_t> times(*device, "test", "times", room), items(*device, "test", "items", room);
  TypedBuffer<uint32_t> counter(*device, "test", "counter", std::vector<uint32_t>{7, count});
  times.fill_zero();
  items.fill_zero();
  ScheduleRecorder recorder = scheduler.record("ray shares", "test");
  PassBuilder pass = recorder.pass("note shares", program, "note_shares");
  trace_by_shares(pass, {.rays = {}, .counter = counter, .counter_index = 1, .capacity = capacity, .ends = {}},
                  *device);
  pass.arg("times", times).arg("items", items);
  Schedule schedule = recorder.compile();
  scheduler.run(schedule);
  scheduler.finish();
  return {times.download(), items.download()};
}

}  // namespace

TEST_CASE("each ray of a batch is in one share, and none behind the last") {
  const uint32_t slice = slice_size();
  for (const uint32_t capacity : {0u, 1u, 255u, 256u, 257u, 4096u, 57600u, slice, slice + 1, slice * 5 / 2})
    for (const uint32_t count : {0u, 1u, capacity / 9, capacity / 3, capacity * 2 / 3, capacity, capacity + 1000}) {
      const Traced traced = trace_shares(capacity, count);
      uint32_t wrong = 0;
      for (uint32_t i = 0; i < traced.times.size(); ++i)
        wrong += traced.times[i] != (i < std::min(count, capacity) ? 1u : 0u);
      INFO("room for ", capacity, ", ", count, " rays");
      CHECK(wrong == 0);
    }
}

TEST_CASE("few rays are shared by all parts of a pass") {
  const uint32_t slice = slice_size(), share = LUCARIUM_RAYS_PER_SHARE;
  for (const uint32_t capacity : {57600u, slice, slice * 5 / 2})
    for (const uint32_t count :
         {4 * share, 8 * share, 16 * share, 24 * share + 100, capacity / 3, slice + 40 * share, capacity * 2 / 3}) {
      if (count > capacity) continue;
      const Traced traced = trace_shares(capacity, count);
      // Look at the last slice with rays: the quarters of its work-items have a quarter of them each, a share and a
      // half more or less, since columns differ by a work-item in length.
      const uint32_t begin = (count - 1) / slice * slice,
                     width = (std::min(capacity - begin, slice) + share - 1) / share;
      uint32_t rays[4] = {};
      for (uint32_t i = begin; i < count; ++i) ++rays[(traced.items[i] - begin / share) * 4 / width];
      for (const uint32_t quarter : rays) {
        INFO("room for ", capacity, ", ", count, " rays");
        CHECK(quarter + 3 * share / 2 >= (count - begin) / 4);
        CHECK(quarter <= (count - begin) / 4 + 3 * share / 2);
      }
    }
}
