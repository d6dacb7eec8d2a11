// SPDX-License-Identifier: Apache-2.0
#include "bidirectional_vpl/eye/pixel_filter.h"

#include "bidirectional_vpl/base/slices.h"
#include "lucarium/compute/device/remedies.h"

const lucarium::EmbeddedSources& bidirectional_vpl_kernels();

namespace lucarium::bidirectional {

PixelFilter::PixelFilter(Device& device, KernelScheduler& scheduler, const SceneBuffers& scene,
                         const Intersector& intersector, const Frame& frame, const Plan& plan,
                         const TypedBuffer<float4>& sums, const std::string& owner)
    : scheduler_(scheduler),
      frame_(frame),
      side_(plan.settings.interleave),
      surfaces_(device, scheduler, scene, intersector, frame, owner),
      program_(make_program(device, bidirectional_vpl_kernels(), {"bidirectional_vpl/eye/filter_pixels"}, {})),
      filtered_(device, owner, "filtered light", plan.settings.pixels, remedies::lower_size) {
  ScheduleRecorder recorder = scheduler_.record("filter pixels", owner);
  frame_variable_ = recorder.variable("frame", frame_);
  recorder.pass("filter pixels", program_, "filter_pixels")
      .global(plan.settings.pixels)
      .slice(kSlice)
      .arg("frame", frame_variable_)
      .arg("points", surfaces_.points())
      .arg("side", side_)
      .arg("sums", sums)
      .arg("filtered", filtered_);
  filter_ = recorder.compile();
}

bool PixelFilter::find_surfaces() {
  if (!found_) found_ = surfaces_.render(0);
  return found_;
}

void PixelFilter::apply(uint64_t iterations) {
  shows_ = iterations < uint64_t{side_} * side_;
  if (!shows_) return;
  filter_.set(frame_variable_, frame_);
  scheduler_.run_to_end(filter_);
  scheduler_.finish();
}

void PixelFilter::set_frame(const Frame& frame) {
  frame_ = frame;
  surfaces_.set_frame(frame);
  found_ = shows_ = false;
}

void PixelFilter::warm_up() {
  surfaces_.warm_up();
  scheduler_.warm_up(filter_);
}

size_t PixelFilter::estimate_bytes(const Plan& plan, bool ray_ends) {
  return GBuffer::estimate_bytes(plan.settings.pixels, 1, ray_ends) + plan.settings.pixels * sizeof(float4);
}

}  // namespace lucarium::bidirectional
