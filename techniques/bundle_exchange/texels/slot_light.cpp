// SPDX-License-Identifier: Apache-2.0
#include "bundle_exchange/texels/slot_light.h"

#include <algorithm>

#include "bundle_exchange/base/bundle_program.h"
#include "lucarium/base/seed.h"

namespace lucarium::bundle {
namespace {

constexpr uint32_t kChunk = 65536;  // shadow rays of an iteration: about 20 ms
const char* const kFewerTexels = "lower texels";

}  // namespace

SlotLight::SlotLight(Device& device, KernelScheduler& scheduler, const Program& program, const SceneBuffers& scene,
                     const Intersector& intersector, const SurfaceAtlas& atlas, const SlotOpenness& openness,
                     uint32_t kinds)
    : scheduler_(&scheduler),
      none_(kinds == 0),
      slots_(atlas.info().texel_count),
      chunk_(std::min(kChunk, slots_)),
      samples_(device, "bundle_exchange", "light at slots", chunk_, kFewerTexels),
      light_samples_(device, "bundle_exchange", "direct light of slots", slots_, kFewerTexels) {
  ScheduleRecorder sample = scheduler_->record("sample light at slots", "bundle_exchange");
  first_ = sample.variable("first", 0u);
  round_ = sample.variable("round", 0u);
  sample_seed_ = sample.variable("seed", 0u);
  const auto bind_points = [&](PassBuilder& pass) {
    pass.arg("atlas_info", atlas.info())
        .arg("atlas_samples", atlas.samples())
        .arg("levels", openness.points())
        .arg("first", first_)
        .arg("slots", slots_)
        .arg("turn", round_);
  };
  const LightAtPoints light(device, scene, intersector, program, chunk_, bind_points, "bundle_exchange", kFewerTexels);
  light.record_samples(
      sample, round_, sample_seed_, [&](PassBuilder& pass) { pass.arg("sums", samples_); }, kinds);
  sample_ = sample.compile();
  ScheduleRecorder scatter = scheduler_->record("light slots", "bundle_exchange");
  scatter_first_ = scatter.variable("first", 0u);
  scatter_count_ = scatter.variable("count", chunk_);
  scatter_round_ = scatter.variable("round", 0u);
  scatter.pass("light slots", program, "scatter_samples")
      .global(chunk_)
      .arg("first", scatter_first_)
      .arg("count", scatter_count_)
      .arg("turn", scatter_round_)
      .arg("levels", openness.points())
      .arg("samples", samples_)
      .arg("light_samples", light_samples_);
  scatter_ = scatter.compile();
}

size_t SlotLight::estimate_bytes(size_t slots) {
  const size_t chunk = std::min<size_t>(slots, kChunk);
  return chunk * sizeof(float4) + slots * sizeof(float4) + LightAtPoints::estimate_bytes(chunk);
}

bool SlotLight::sample() {
  const uint32_t first = static_cast<uint32_t>(position_ % slots_);
  sample_.set(first_, first);
  sample_.set(round_, static_cast<uint32_t>(position_ / slots_));
  // Points of different runs share their numbers in the buffer, so that each run has a seed of its own.
  sample_.set(sample_seed_, mixed_seed(seed_, first));
  pending_ = 0;
  if (scheduler_->run(sample_) == RunResult::cancelled) return false;
  pending_ = std::min(chunk_, slots_ - first);
  return true;
}

void SlotLight::commit() {
  scatter_.set(scatter_first_, static_cast<uint32_t>(position_ % slots_));
  scatter_.set(scatter_count_, pending_);
  scatter_.set(scatter_round_, static_cast<uint32_t>(position_ / slots_));
  scheduler_->run_to_end(scatter_);
  position_ += pending_;
  pending_ = 0;
}

void SlotLight::reset(uint32_t seed) {
  light_samples_.fill_zero();
  seed_ = seed;
  position_ = 0;
  pending_ = 0;
}

void SlotLight::warm_up() {
  scheduler_->warm_up(sample_);
  scheduler_->warm_up(scatter_);
}

}  // namespace lucarium::bundle
