// SPDX-License-Identifier: Apache-2.0
// What a pass costs on the host when a schedule is replayed, beside the same kernels in a bare loop of
// clEnqueueNDRangeKernel; what overlap gains; what recording costs. "items" are passes.
#include <benchmark/benchmark.h>

#include "lucarium/compute/device/cl_handle.h"
#include "lucarium/compute/program/source_library.h"
#include "lucarium/compute/schedule/scheduler.h"

const lucarium::EmbeddedSources& lucarium_bench_kernels();

namespace {

using namespace lucarium;

constexpr uint32_t element_count = 64;

const std::shared_ptr<Device>& device() {
  static const std::shared_ptr<Device> opened = Device::open();
  return opened;
}

const Program& program() {
  static const Program built = [] {
    SourceLibrary library;
    library.add(lucarium_bench_kernels());
    ProgramSpec spec;
    spec.name = "scheduler_bench";
    spec.files = {"bench/scheduler_bench.cl"};
    return Program(*device(), library, spec);
  }();
  return built;
}

TypedBuffer<uint32_t> make_buffer() { return {*device(), "bench", "buffer", std::vector<uint32_t>(element_count, 1)}; }

Schedule tiny_chain(KernelScheduler& scheduler, int passes) {
  const auto target = make_buffer(), source = make_buffer();
  ScheduleRecorder recorder = scheduler.record("chain", "bench");
  for (int i = 0; i < passes; ++i) {
    recorder.pass("tiny", program(), "tiny")
        .global(element_count)
        .local(64)
        .arg("target", target)
        .arg("source", source)
        .arg("factor", 3u)
        .arg("count", element_count);
  }
  return recorder.compile();
}

/// One kernel object per pass, arguments set once: the least that OpenCL allows.
void raw_loop(benchmark::State& state, bool events) {
  const int passes = static_cast<int>(state.range(0));
  const auto target = make_buffer(), source = make_buffer();
  std::vector<ClKernel> kernels;
  const cl_mem target_memory = target.handle(), source_memory = source.handle();
  const cl_uint factor = 3, count = element_count;
  for (int i = 0; i < passes; ++i) {
    const cl_kernel kernel = clCreateKernel(program().handle(), "tiny", nullptr);
    clSetKernelArg(kernel, 0, sizeof(cl_mem), &target_memory);
    clSetKernelArg(kernel, 1, sizeof(cl_mem), &source_memory);
    clSetKernelArg(kernel, 2, sizeof(cl_uint), &factor);
    clSetKernelArg(kernel, 3, sizeof(cl_uint), &count);
    kernels.emplace_back(kernel);
  }
  const size_t size = element_count;
  std::vector<cl_event> made(kernels.size());
  for (auto _ : state) {
    for (size_t i = 0; i < kernels.size(); ++i) {
      clEnqueueNDRangeKernel(device()->queue(), kernels[i].get(), 1, nullptr, &size, &size, 0, nullptr,
                             events ? &made[i] : nullptr);
    }
    clFlush(device()->queue());
    clFinish(device()->queue());
    if (events) {
      for (const cl_event event : made) clReleaseEvent(event);
    }
  }
  state.SetItemsProcessed(state.iterations() * passes);
}

void raw(benchmark::State& state) { raw_loop(state, false); }
void raw_with_events(benchmark::State& state) { raw_loop(state, true); }

void replay(benchmark::State& state, const SchedulerOptions& options) {
  KernelScheduler scheduler(device(), options);
  const int passes = static_cast<int>(state.range(0));
  Schedule schedule = tiny_chain(scheduler, passes);
  for (int i = 0; i < 3; ++i) scheduler.run(schedule);
  scheduler.finish();
  for (auto _ : state) {
    scheduler.run(schedule);
    scheduler.finish();
  }
  state.SetItemsProcessed(state.iterations() * passes);
}

void replay_in_order(benchmark::State& state) { replay(state, {QueueMode::in_order, false, false}); }
void replay_profiled(benchmark::State& state) { replay(state, {QueueMode::in_order, true, false}); }
void replay_overlap(benchmark::State& state) { replay(state, {QueueMode::overlap, false, false}); }

/// Chains of single-group passes that are independent of each other.
void independent_chains(benchmark::State& state, QueueMode mode) {
  KernelScheduler scheduler(device(), {mode, false, false});
  ScheduleRecorder recorder = scheduler.record("chains", "bench");
  const std::vector<TypedBuffer<uint32_t>> targets = {make_buffer(), make_buffer()};
  for (int i = 0; i < 10; ++i) {
    for (const auto& target : targets) {
      recorder.pass("narrow", program(), "narrow")
          .global(element_count)
          .local(64)
          .arg("target", target)
          .arg("rounds", 20000u);
    }
  }
  Schedule schedule = recorder.compile();
  for (auto _ : state) {
    scheduler.run(schedule);
    scheduler.finish();
  }
  state.SetItemsProcessed(state.iterations() * 20);
}

void narrow_in_order(benchmark::State& state) { independent_chains(state, QueueMode::in_order); }
void narrow_overlap(benchmark::State& state) { independent_chains(state, QueueMode::overlap); }
void narrow_automatic(benchmark::State& state) { independent_chains(state, QueueMode::automatic); }

/// Records and compiles passes of 14 buffers each.
void record_and_compile(benchmark::State& state) {
  const int passes = static_cast<int>(state.range(0));
  const bool compile = state.range(1) != 0;
  std::vector<TypedBuffer<uint32_t>> buffers;
  std::vector<std::string> names = {"out"};
  for (int i = 0; i < 13; ++i) names.push_back("b" + std::to_string(i));
  for (size_t i = 0; i < names.size(); ++i) buffers.push_back(make_buffer());
  for (auto _ : state) {
    ScheduleRecorder recorder(*device(), "recorded", "bench");
    for (int i = 0; i < passes; ++i) {
      PassBuilder pass = recorder.pass("pass", program(), "many_buffers");
      pass.global(element_count);
      for (size_t b = 0; b < names.size(); ++b) pass.arg(names[b], buffers[b]);
    }
    if (compile) benchmark::DoNotOptimize(recorder.compile().pass_count());
  }
  state.SetItemsProcessed(state.iterations() * passes);
}

BENCHMARK(raw)->Arg(100)->UseRealTime();
BENCHMARK(raw_with_events)->Arg(100)->UseRealTime();
BENCHMARK(replay_in_order)->Arg(100)->UseRealTime();
BENCHMARK(replay_profiled)->Arg(100)->UseRealTime();
BENCHMARK(replay_overlap)->Arg(100)->UseRealTime();
BENCHMARK(narrow_in_order)->UseRealTime();
BENCHMARK(narrow_overlap)->UseRealTime();
BENCHMARK(narrow_automatic)->UseRealTime();
BENCHMARK(record_and_compile)->Args({100, 0})->Args({100, 1})->ArgNames({"passes", "compile"})->UseRealTime();

}  // namespace
