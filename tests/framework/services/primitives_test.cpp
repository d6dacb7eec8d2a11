// SPDX-License-Identifier: Apache-2.0
#include "lucarium/services/primitives/primitives.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "bvh/triangle_soups.h"
#include "lucarium/compute/schedule/scheduler.h"
#include "test_support.h"

using namespace lucarium;
using namespace lucarium::test;

namespace {

struct Fixture {
  std::shared_ptr<Device> device = Device::open();
  KernelScheduler scheduler{device};
  Primitives primitives{*device};

  template <class T>
  TypedBuffer<T> buffer(const std::vector<T>& values) {
    return TypedBuffer<T>(*device, "test", "values", values);
  }
  template <class Record>
  void run(Record&& record) {
    ScheduleRecorder recorder = scheduler.record("primitives", "test");
    record(recorder);
    Schedule schedule = recorder.compile();
    scheduler.run(schedule);
    scheduler.finish();
  }
};

/// Empty, single, around the chunk borders (4096, 8192), several chunks, and random sizes.
std::vector<uint32_t> sizes() {
  std::vector<uint32_t> result = {0, 1, 2, 4095, 4096, 4097, 8191, 8192, 8193, 100000};
  Random random(1);
  for (int i = 0; i < (full_run() ? 50 : 5); ++i) result.push_back(random.below(60000));
  return result;
}

std::vector<uint32_t> random_values(uint32_t count, uint32_t seed, uint32_t end) {
  std::vector<uint32_t> values(count);
  Random random(seed);
  for (uint32_t& value : values) value = random.below(end);
  return values;
}

}  // namespace

TEST_CASE_FIXTURE(Fixture, "exclusive scan") {
  for (const uint32_t count : sizes()) {
    CAPTURE(count);
    const std::vector<uint32_t> values = random_values(count, count, 40000);
    std::vector<uint32_t> expected(count);
    std::exclusive_scan(values.begin(), values.end(), expected.begin(), 0u);
    const TypedBuffer<uint32_t> in = buffer(values), out = buffer(std::vector<uint32_t>(count + 1, 5)),
                                total = buffer(std::vector<uint32_t>{0});
    run([&](ScheduleRecorder& recorder) { primitives.record_exclusive_scan(recorder, "scan", in, out, total, count); });
    const uint32_t sum = std::accumulate(values.begin(), values.end(), 0u);
    CHECK(out.download(0, count) == expected);
    CHECK(out.download()[count] == 5);
    CHECK(total.download()[0] == sum);
    // In place.
    run([&](ScheduleRecorder& recorder) { primitives.record_exclusive_scan(recorder, "scan", in, in, total, count); });
    CHECK(in.download(0, count) == expected);
  }
}

TEST_CASE_FIXTURE(Fixture, "exclusive scan of a counted part, whose total replaces the count") {
  const std::vector<uint32_t> values = random_values(20000, 3, 1000);
  for (const uint32_t count : {0u, 1u, 4096u, 10000u, 20000u, 30000u}) {
    CAPTURE(count);
    const uint32_t counted = std::min(count, 20000u);
    std::vector<uint32_t> expected = values;
    std::exclusive_scan(values.begin(), values.begin() + counted, expected.begin(), 0u);
    const TypedBuffer<uint32_t> data = buffer(values), counter = buffer(std::vector<uint32_t>{count});
    run([&](ScheduleRecorder& recorder) {
      primitives.record_exclusive_scan(recorder, "scan", data, data, counter, counter, 0, 20000);
    });
    CHECK(data.download() == expected);
    CHECK(counter.download()[0] == std::accumulate(values.begin(), values.begin() + counted, 0u));
  }
}

TEST_CASE_FIXTURE(Fixture, "compact") {
  for (const uint32_t capacity : sizes())
    for (const uint32_t count : {capacity, capacity / 2, capacity + 7}) {
      CAPTURE(capacity);
      CAPTURE(count);
      const std::vector<uint32_t> flags = random_values(capacity, capacity + 1, 3);
      std::vector<uint32_t> expected;
      for (uint32_t i = 0; i < std::min(count, capacity); ++i)
        if (flags[i]) expected.push_back(i);
      const TypedBuffer<uint32_t> in = buffer(flags), out = buffer(std::vector<uint32_t>(capacity + 1, 9)),
                                  counters = buffer(std::vector<uint32_t>{8, count, 7});
      run([&](ScheduleRecorder& recorder) {
        primitives.record_compact(recorder, "compact", in, out, counters, 0, counters, 1, capacity);
      });
      const auto found = static_cast<uint32_t>(expected.size());
      CHECK(counters.download() == std::vector<uint32_t>{found, count, 7});
      CHECK(out.download(0, found) == expected);
      CHECK(out.download()[found] == 9);
    }
}

TEST_CASE_FIXTURE(Fixture, "reduce") {
  for (const uint32_t count : sizes()) {
    CAPTURE(count);
    const std::vector<uint32_t> values = random_values(count, count + 2, 0xffffffffu);
    std::vector<float> floats(count);
    Random random(count);
    for (float& value : floats) value = random.uniform(-1, 1) * std::exp(random.uniform(-10, 10));
    const TypedBuffer<uint32_t> in = buffer(values), sum = buffer(std::vector<uint32_t>{1});
    const TypedBuffer<float> in_float = buffer(floats), least = buffer(std::vector<float>{1}),
                             largest = buffer(std::vector<float>{1}), float_total = buffer(std::vector<float>{1});
    run([&](ScheduleRecorder& recorder) {
      using enum Primitives::Reduction;
      primitives.record_reduce(recorder, "sum", sum_uint, in, sum, count);
      primitives.record_reduce(recorder, "min", min_float, in_float, least, count);
      primitives.record_reduce(recorder, "max", max_float, in_float, largest, count);
      primitives.record_reduce(recorder, "float sum", sum_float, in_float, float_total, count);
    });
    CHECK(sum.download()[0] == std::accumulate(values.begin(), values.end(), 0u));
    const float infinity = INFINITY;
    CHECK(least.download()[0] == (count ? *std::min_element(floats.begin(), floats.end()) : infinity));
    CHECK(largest.download()[0] == (count ? *std::max_element(floats.begin(), floats.end()) : -infinity));
    // Compensation keeps the error near one rounding per chunk, however many elements cancel.
    const double exact = std::accumulate(floats.begin(), floats.end(), 0.0);
    double magnitude = 0;
    for (const float value : floats) magnitude += std::abs(double{value});
    const double chunks = 1 + count / 4096.0;
    CHECK(std::abs(double{float_total.download()[0]} - exact) <=
          6e-8 * chunks * magnitude / std::max(1.0, chunks) + 1e-30);
  }
}

TEST_CASE_FIXTURE(Fixture, "sums, minima and maxima of values that are not finite") {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const TypedBuffer<float> in = buffer(std::vector<float>{3, nan, -2, INFINITY}), least = buffer(std::vector<float>{0}),
                           largest = buffer(std::vector<float>{0}), sum = buffer(std::vector<float>{0}),
                           infinite = buffer(std::vector<float>{0}),
                           in_infinite = buffer(std::vector<float>{1, INFINITY});
  run([&](ScheduleRecorder& recorder) {
    using enum Primitives::Reduction;
    primitives.record_reduce(recorder, "min", min_float, in, least, 4);
    primitives.record_reduce(recorder, "max", max_float, in, largest, 4);
    primitives.record_reduce(recorder, "sum", sum_float, in, sum, 4);
    primitives.record_reduce(recorder, "infinite", sum_float, in_infinite, infinite, 2);
  });
  CHECK(least.download()[0] == -2);
  CHECK(largest.download()[0] == INFINITY);
  CHECK(std::isnan(sum.download()[0]));
  CHECK(infinite.download()[0] == INFINITY);
}

TEST_CASE_FIXTURE(Fixture, "stable radix sort") {
  for (const uint32_t count : sizes())
    for (const int bits : {32, 20, 8, 3, 0}) {
      CAPTURE(count);
      CAPTURE(bits);
      const std::vector<uint32_t> keys = random_values(count, count + 5, bits == 20 ? 50 : 0xffffffffu);
      std::vector<uint32_t> order(count);
      std::iota(order.begin(), order.end(), 0u);
      std::vector<uint32_t> expected = order;
      const uint32_t mask = bits == 32 ? 0xffffffffu : (1u << bits) - 1;
      std::stable_sort(expected.begin(), expected.end(),
                       [&](uint32_t a, uint32_t b) { return (keys[a] & mask) < (keys[b] & mask); });
      const TypedBuffer<uint32_t> key_buffer = buffer(keys), value_buffer = buffer(order);
      run([&](ScheduleRecorder& recorder) {
        primitives.record_sort_pairs(recorder, "sort", key_buffer, value_buffer, count, bits);
      });
      const std::vector<uint32_t> sorted = value_buffer.download(), sorted_keys = key_buffer.download();
      CHECK(sorted == expected);
      bool keys_follow = true;
      for (uint32_t i = 0; i < count; ++i) keys_follow &= sorted_keys[i] == keys[expected[i]];
      CHECK(keys_follow);
    }
}
