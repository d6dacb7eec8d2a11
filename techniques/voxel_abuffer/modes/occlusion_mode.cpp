// SPDX-License-Identifier: Apache-2.0
#include "voxel_abuffer/modes/occlusion_mode.h"

#include "lucarium/base/seed.h"
#include "lucarium/compute/device/remedies.h"
#include "lucarium/services/ray_ends.h"
#include "voxel_abuffer/base/name.h"

const lucarium::EmbeddedSources& voxel_abuffer_kernels();

namespace lucarium::abuffer {
OcclusionMode::OcclusionMode(const ModeContext& context, uint32_t samples, std::function<float()> radius)
    : scheduler_(&context.scheduler),
      samples_(samples),
      radius_(std::move(radius)),
      gbuffer_(context.scheduler.device(), context.scheduler, context.scene, context.primary, context.frame,
               technique_name),
      sums_(context.scheduler, context.pixels(), {"ambient_occlusion"}, samples),
      count_(context.scheduler.device(), technique_name, "pixels", std::vector<uint32_t>{context.pixels()}) {
  record(context);
}

void OcclusionMode::record(const ModeContext& context) {
  const uint32_t pixels = context.pixels();
  const Program program = make_program(scheduler_->device(), voxel_abuffer_kernels(), {"voxel_abuffer/modes/occlusion"},
                                       ray_end_defines(context.intersector));
  ScheduleRecorder recorder = scheduler_->record("occlusion", technique_name);
  sample_index_ = recorder.variable("sample_index", 0u);
  seed_ = recorder.variable("seed", 0u);
  reach_ = recorder.variable("reach", 0.f);
  const BufferRef rays = recorder.transient<Ray>("occlusion rays", pixels, remedies::lower_size);
  const BufferRef ends =
      transient_ray_ends(recorder, context.intersector, "ends of occlusion rays", pixels, remedies::lower_size);
  const BufferRef occluded = recorder.transient<uint32_t>("occluded", pixels, remedies::lower_size);
  PassBuilder begin = recorder.pass("begin occlusion rays", program, "begin_occlusion_rays");
  context.scene.bind(begin);
  begin.global(pixels)
      .arg("points", gbuffer_.points())
      .arg("count", pixels)
      .arg("sample_index", sample_index_)
      .arg("seed", seed_)
      .arg("reach", reach_)
      .arg_if_present("ends", ends)
      .arg("rays", rays);
  context.intersector.record_any(recorder, "occlusion rays", {rays, count_, 0, pixels, ends}, occluded);
  recorder.pass("add open rays", program, "add_open_rays")
      .global(pixels)
      .arg("count", pixels)
      .arg("occluded", occluded)
      .arg("pass", sums_.pass(0));
  sample_ = recorder.compile();
}

bool OcclusionMode::pass() {
  if (!sums_.begin() || !gbuffer_.render(passes_)) return false;
  sample_.set(seed_, frame_seed_);
  for (uint32_t s = 0; s < samples_; ++s) {
    sample_.set(sample_index_, passes_ * samples_ + s);
    if (scheduler_->run(sample_) == RunResult::cancelled) return false;
  }
  sums_.commit();
  ++passes_;
  return true;
}

void OcclusionMode::restart(const Frame& frame, uint64_t seed) {
  gbuffer_.set_frame(frame);
  frame_seed_ = kernel_seed(seed);
  sample_.set(reach_, radius_());
  sums_.clear();
  passes_ = 0;
}

void OcclusionMode::warm_up() {
  gbuffer_.warm_up();
  sums_.warm_up();
  scheduler_->warm_up(sample_);
}

std::map<std::string, double> OcclusionMode::counters() const {
  return {{"occlusion_rays", static_cast<double>(count_.download()[0]) * passes_ * samples_}};
}

size_t OcclusionMode::estimate_bytes(size_t width, size_t height, bool ray_ends) {
  const size_t pixels = width * height;
  return GBuffer::estimate_bytes(static_cast<uint32_t>(width), static_cast<uint32_t>(height), ray_ends) +
         PassSums::estimate_bytes(pixels, 1) +
         pixels * (sizeof(Ray) + (ray_ends ? sizeof(RayEnds) : 0) + sizeof(uint32_t));
}

}  // namespace lucarium::abuffer
