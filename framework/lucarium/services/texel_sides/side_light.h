// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>

#include "lucarium/services/light_at_points/light_at_points.h"
#include "lucarium/services/surface_atlas/surface_atlas.h"
#include "lucarium/services/texel_sides/side_accessibility.h"

namespace lucarium {

/// Direct irradiance of every texel side by light samples, of all lights or of some kinds (LUCARIUM_LIGHT_* bits; 0:
/// none): the mean over the texel side by accessibility, at one random point after the other. A run of texel sides gets
/// one more sample per iteration, so that iterations stay short.
class SideLight {
 public:
  /// `owner` pays for the memory; `remedy` is what a message about too little of it advises. `fill`: halves in which no
  /// point lies get the light of their neighbours (fill_halves.cl), for who knows nothing better; else they get none.
  SideLight(Device& device, KernelScheduler& scheduler, const SceneBuffers& scene, const Intersector& intersector,
            const SurfaceAtlas& atlas, const SideAccessibility& accessibility, uint32_t kinds, const std::string& owner,
            const std::string& remedy, bool fill = false);

  /// Samples the next run of texel sides; false when cancelled. commit() then adds it; without it nothing has changed.
  bool sample();
  void commit();
  void reset(uint32_t seed);
  void warm_up();
  /// Whether every texel side has samples enough to begin with: what is missing in them, all directions would send.
  bool complete() const { return none_ || position_ >= sides_ * uint64_t{kFirstSamples}; }
  /// Whether more samples are of no use.
  bool exhausted() const { return none_ || position_ >= sides_ * uint64_t{kSamples}; }
  /// Runs of texel sides in an iteration: many while the exchange waits, then one.
  uint32_t runs() const {
    const uint64_t all = sides_ * uint64_t{kFirstSamples} / chunk_;
    return complete() ? 1 : static_cast<uint32_t>(std::clamp<uint64_t>(all / kIterations, 4, 16));
  }

  /// Texel sides of a run, at most.
  uint32_t run_length() const { return none_ ? 0 : chunk_; }

  /// Per texel side, of its halves (SideAccessibility::halves()): xyz sum of irradiance [lx], w of the samples, by
  /// accessibility.
  const TypedBuffer<float4>& light_samples() const { return light_samples_; }
  static size_t estimate_bytes(size_t sides, uint32_t halves = 1);

 private:
  static constexpr uint32_t kFirstSamples = 64, kSamples = 1024;
  static constexpr uint32_t kIterations = 8;  ///< that only light texel sides; a run is about 20 ms
  KernelScheduler* scheduler_;
  bool none_;  ///< there is nothing to sample
  uint32_t sides_, chunk_;
  TypedBuffer<float4> samples_, light_samples_;
  Schedule sample_, scatter_;
  Variable<uint32_t> first_, round_, sample_seed_, scatter_first_, scatter_count_, scatter_round_;
  uint64_t position_ = 0;  ///< texel sides sampled so far, all rounds
  uint32_t pending_ = 0;   ///< texel sides of the run that waits for commit()
  uint32_t seed_ = 1;
};

}  // namespace lucarium
