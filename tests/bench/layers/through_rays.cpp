// SPDX-License-Identifier: Apache-2.0
#include "through_rays.h"

#include <cstring>

#include "lucarium/compute/program/source_library.h"

const lucarium::EmbeddedSources& lucarium_layer_bench_kernels();

namespace lucarium::bench {

ThroughRays::ThroughRays(KernelScheduler& scheduler, const Intersector& intersector,
                         const TypedBuffer<LayeredView>& views, uint32_t pixels)
    : scheduler_(&scheduler) {
  Device& device = scheduler.device();
  SourceLibrary library;
  library.add(lucarium_layer_bench_kernels());
  const Program program(device, library, {.name = "bench/rays", .files = {"bench/layers/rays.cl"}});
  for (int i = 0; i < 2; ++i) {
    rays_[i] = TypedBuffer<Ray>(device, "bench", "rays", pixels);
    counter_[i] = TypedBuffer<uint32_t>(device, "bench", "counter", 1);
  }
  hits_ = TypedBuffer<Hit>(device, "bench", "hits", pixels);
  found_ = TypedBuffer<uint32_t>(device, "bench", "found", 1);
  ScheduleRecorder start = scheduler.record("first rays", "bench");
  view_ = start.variable("view", 0u);
  start.pass("first rays", program, "first_rays")
      .global(pixels)
      .local(64)
      .arg("views", views)
      .arg("view_index", view_)
      .arg("far_depth", 1e30f)
      .arg("rays", rays_[0])
      .arg("counter", counter_[0]);
  start.fill_zero("found", found_);
  first_ = start.compile();
  for (int from = 0; from < 2; ++from) {
    ScheduleRecorder recorder = scheduler.record("next rays", "bench");
    intersector.record_closest(recorder, "closest", {rays_[from], counter_[from], 0, pixels}, hits_);
    recorder.fill_zero("next counter", counter_[1 - from]);
    recorder.pass("next rays", program, "next_rays")
        .global(pixels / 1024 + 1)
        .local(1)
        .arg("rays", rays_[from])
        .arg("hits", hits_)
        .arg("counter", counter_[from])
        .arg("next", rays_[1 - from])
        .arg("next_counter", counter_[1 - from])
        .arg("found", found_);
    recorder.read_back("remaining", counter_[1 - from],
                       [this](std::span<const std::byte> bytes) { std::memcpy(&remaining_, bytes.data(), 4); });
    next_[from] = recorder.compile();
  }
}

uint32_t ThroughRays::trace(uint32_t view) {
  first_.set(view_, view);
  scheduler_->run(first_);
  int from = 0;
  do {
    scheduler_->run(next_[from]);
    from = 1 - from;
  } while (remaining_ > 0);
  scheduler_->finish();
  return found_.download()[0];
}

}  // namespace lucarium::bench
