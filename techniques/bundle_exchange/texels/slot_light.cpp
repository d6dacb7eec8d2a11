// SPDX-License-Identifier: Apache-2.0
#include "bundle_exchange/texels/slot_light.h"

#include <algorithm>

#include "bundle_exchange/bundle_program.h"
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
      points_(device, "bundle_exchange", "slots to light", chunk_, kFewerTexels),
      samples_(device, "bundle_exchange", "light at slots", chunk_, kFewerTexels),
      light_samples_(device, "bundle_exchange", "direct light of slots", slots_, kFewerTexels),
      direct_light_(device, scheduler, scene, intersector, "bundle_exchange", kinds) {
  record(program, scene, atlas, openness);
}

size_t SlotLight::estimate_bytes(size_t slots) {
  const size_t chunk = std::min<size_t>(slots, kChunk);
  return chunk * (sizeof(SurfacePoint) + sizeof(float4)) + slots * sizeof(float4) + DirectLight::estimate_bytes(chunk);
}

void SlotLight::record(const Program& program, const SceneBuffers& scene, const SurfaceAtlas& atlas,
                       const SlotOpenness& openness) {
  ScheduleRecorder gather = scheduler_->record("take slots", "bundle_exchange");
  gather_first_ = gather.variable("first", 0u);
  gather_count_ = gather.variable("count", chunk_);
  gather_round_ = gather.variable("round", 0u);
  PassBuilder take = surface_pass(gather, "take slots", program, "gather_points", scene, atlas);
  take.global(chunk_)
      .arg("levels", openness.points())
      .arg("first", gather_first_)
      .arg("count", gather_count_)
      .arg("turn", gather_round_)
      .arg("points", points_)
      .arg("samples", samples_);
  gather_ = gather.compile();
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

bool SlotLight::sample() {
  const uint32_t first = static_cast<uint32_t>(position_ % slots_);
  const uint32_t count = std::min(chunk_, slots_ - first);
  const uint32_t round = static_cast<uint32_t>(position_ / slots_);
  gather_.set(gather_first_, first);
  gather_.set(gather_count_, count);
  gather_.set(gather_round_, round);
  pending_ = 0;
  if (scheduler_->run(gather_) == RunResult::cancelled) return false;
  // Points of different runs share their numbers in the buffer, so that each run has a seed of its own.
  const uint32_t seed = mixed_seed(seed_, first);
  if (!direct_light_.accumulate_irradiance(points_, samples_, round, seed)) return false;
  pending_ = count;
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
  scheduler_->warm_up(gather_);
  direct_light_.warm_up(points_, samples_);
  scheduler_->warm_up(scatter_);
}

}  // namespace lucarium::bundle
