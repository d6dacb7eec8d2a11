// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>

#include "bundle_exchange/texels/slot_openness.h"
#include "lucarium/services/light_at_points/light_at_points.h"
#include "lucarium/services/surface_atlas/surface_atlas.h"

namespace lucarium::bundle {

/// Direct irradiance of every slot by light samples, of all lights or of some kinds (LUCARIUM_LIGHT_* bits; 0: none):
/// the mean over the slot by openness, at one random point after the other. A run of slots gets one more sample per
/// iteration, so that iterations stay short.
class SlotLight {
 public:
  SlotLight(Device& device, KernelScheduler& scheduler, const Program& program, const SceneBuffers& scene,
            const Intersector& intersector, const SurfaceAtlas& atlas, const SlotOpenness& openness, uint32_t kinds);

  /// Samples the next run of slots; false when cancelled. commit() then adds it; without it nothing has changed.
  bool sample();
  void commit();
  void reset(uint32_t seed);
  void warm_up();
  /// Whether every slot has samples enough to begin with: what is missing in them, all directions would send.
  bool complete() const { return none_ || position_ >= slots_ * uint64_t{kFirstSamples}; }
  /// Whether there is no more to be gained.
  bool exhausted() const { return none_ || position_ >= slots_ * uint64_t{kSamples}; }
  /// Runs of slots in an iteration: many while the exchange waits, then one.
  uint32_t runs() const {
    const uint64_t all = slots_ * uint64_t{kFirstSamples} / chunk_;
    return complete() ? 1 : static_cast<uint32_t>(std::clamp<uint64_t>(all / kIterations, 4, 16));
  }

  /// Per slot: xyz sum of irradiance [lx], w of the samples, by openness.
  const TypedBuffer<float4>& light_samples() const { return light_samples_; }
  static size_t estimate_bytes(size_t slots);

 private:
  static constexpr uint32_t kFirstSamples = 64, kSamples = 1024;
  static constexpr uint32_t kIterations = 8;  ///< that only light slots; a run is about 20 ms
  KernelScheduler* scheduler_;
  bool none_;  ///< there is nothing to sample
  uint32_t slots_, chunk_;
  TypedBuffer<float4> samples_, light_samples_;
  Schedule sample_, scatter_;
  Variable<uint32_t> first_, round_, sample_seed_, scatter_first_, scatter_count_, scatter_round_;
  uint64_t position_ = 0;  ///< slots sampled so far, all rounds
  uint32_t pending_ = 0;   ///< slots of the run that waits for commit()
  uint32_t seed_ = 1;
};

}  // namespace lucarium::bundle
