// SPDX-License-Identifier: Apache-2.0
// Elements per second of the primitives.
#include <benchmark/benchmark.h>

#include <random>

#include "lucarium/compute/schedule/scheduler.h"
#include "lucarium/services/primitives/primitives.h"

namespace {

using namespace lucarium;

struct Bench {
  std::shared_ptr<Device> device = Device::open();
  KernelScheduler scheduler{device};
};

Bench& bench() {
  static Bench instance;
  return instance;
}

void sort_pairs(benchmark::State& state) {
  Device& device = *bench().device;
  const auto count = static_cast<uint32_t>(state.range(0));
  std::vector<uint32_t> keys(count);
  std::mt19937 engine(1);
  for (uint32_t& key : keys) key = static_cast<uint32_t>(engine());
  const TypedBuffer<uint32_t> key_buffer(device, "bench", "keys", keys), values(device, "bench", "values", keys);
  ScheduleRecorder recorder = bench().scheduler.record("sort", "bench");
  Primitives(device).record_sort_pairs(recorder, "sort", key_buffer, values, count);
  Schedule schedule = recorder.compile();
  for (auto _ : state) {
    bench().scheduler.run(schedule);
    bench().scheduler.finish();
  }
  state.SetItemsProcessed(state.iterations() * count);
}
BENCHMARK(sort_pairs)->Arg(1 << 22)->Unit(benchmark::kMillisecond)->UseRealTime();

void exclusive_scan(benchmark::State& state) {
  Device& device = *bench().device;
  const auto count = static_cast<uint32_t>(state.range(0));
  const TypedBuffer<uint32_t> in(device, "bench", "in", std::vector<uint32_t>(count, 1)),
      out(device, "bench", "out", count), total(device, "bench", "total", 1);
  ScheduleRecorder recorder = bench().scheduler.record("scan", "bench");
  Primitives(device).record_exclusive_scan(recorder, "scan", in, out, total, count);
  Schedule schedule = recorder.compile();
  for (auto _ : state) {
    bench().scheduler.run(schedule);
    bench().scheduler.finish();
  }
  state.SetItemsProcessed(state.iterations() * count);
}
BENCHMARK(exclusive_scan)->Arg(1 << 22)->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace
