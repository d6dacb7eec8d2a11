// SPDX-License-Identifier: Apache-2.0
#include "lucarium/services/eye_light/eye_light.h"

#include "lucarium/compute/device/remedies.h"

namespace lucarium {

EyeLight::EyeLight(Device& device, KernelScheduler& scheduler, const SceneBuffers& scene,
                   const Intersector& intersector, const Frame& frame, const std::string& owner, uint32_t light_kinds,
                   uint32_t light_samples, bool first_surface)
    : scheduler_(&scheduler),
      light_kinds_(light_kinds),
      light_samples_(light_samples),
      seed_(frame.seed),
      gbuffer_(device, scheduler, scene, intersector, frame, owner, first_surface),
      direct_light_(device, scheduler, scene, intersector, owner, light_kinds),
      sums_(device, owner, size_t{frame.width} * frame.height, {"emission", "direct"}),
      sample_(device, owner, "sample of direct light", size_t{frame.width} * frame.height, remedies::lower_size),
      deviations_(device, owner, "deviations of samples", size_t{frame.width} * frame.height, remedies::lower_size) {
  const Program program(device, SourceLibrary(),
                        {"services/eye_light", {"lucarium/services/eye_light/add_eye_light.cl"}, {}});
  ScheduleRecorder clearing = scheduler.record("begin sample of eye light", owner);
  clearing.fill_zero("clear sample of direct light", sample_);
  clear_ = clearing.compile();
  const uint32_t pixels = frame.width * frame.height;
  ScheduleRecorder adding = scheduler.record("add eye light", owner);
  adding.pass("add eye light", program, "add_eye_light")
      .global(pixels)
      .arg("points", points())
      .arg("count", pixels)
      .arg("direct_sample", sample_)
      .arg("emission", sums_["emission"])
      .arg("direct", sums_["direct"])
      .arg("deviations", deviations_);
  commit_ = adding.compile();
}

bool EyeLight::sample(uint32_t index) {
  scheduler_->run_to_end(clear_);
  for (uint32_t s = 0; light_kinds_ != 0 && s < light_samples_; ++s)
    if (!direct_light_.accumulate_radiance(points(), sample_, index * light_samples_ + s, seed_)) return false;
  return true;
}

void EyeLight::commit() { scheduler_->run_to_end(commit_); }

void EyeLight::set_frame(const Frame& frame) {
  seed_ = frame.seed;
  gbuffer_.set_frame(frame);
  clear();
}

void EyeLight::clear() {
  scheduler_->finish();
  sums_.clear();
}

void EyeLight::warm_up() {
  gbuffer_.warm_up();
  scheduler_->warm_up(clear_);
  if (light_kinds_ != 0) direct_light_.warm_up(points(), sample_);
  scheduler_->warm_up(commit_);
}

size_t EyeLight::estimate_bytes(uint32_t width, uint32_t height) {
  const size_t pixels = size_t{width} * height;
  return GBuffer::estimate_bytes(width, height) + DirectLight::estimate_bytes(pixels) +
         LayerSums::estimate_bytes(pixels, 2) + pixels * (sizeof(float4) + sizeof(float));
}

}  // namespace lucarium
