// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "bundle_exchange/senders/slot_means.h"
#include "bundle_exchange/shared/hop.h"
#include "lucarium/services/intersector.h"
#include "lucarium/services/primitives/primitives.h"
#include "lucarium/services/surface_atlas/surface_atlas.h"

namespace lucarium::bundle {

/// Longest chain that is followed.
inline constexpr uint32_t kMostHops = 64;

/// Follows chains of specular vertices by rays until none is left, and adds up the light that each finds for its target
/// (hops.cl). The caller begins the chains: at most one per target.
class HopTracer {
 public:
  struct Options {
    uint32_t targets = 0;
    uint32_t gains = 1;     ///< float4 per target
    bool punctual = false;  ///< there are punctual lights
    std::string what;       ///< for names of passes and memory
  };
  HopTracer(Device& device, KernelScheduler& scheduler, const Program& program, const SceneBuffers& scene,
            const Intersector& intersector, const SurfaceAtlas& atlas, const TypedBuffer<float4>& diffuse,
            const Options& options);

  /// What begins chains fills: gain and hops by target; rays, and queue (their targets), `active` of them.
  const TypedBuffer<Hop>& hops() const { return hops_; }
  const TypedBuffer<Ray>& first_rays() const { return rays_; }
  const TypedBuffer<uint32_t>& queue() const { return queue_; }
  const TypedBuffer<uint32_t>& active() const { return active_; }
  /// Records the pass pair that tells whether shadow rays which begin chains are free, and adds their light.
  void record_punctual(ScheduleRecorder& recorder, const Variable<HopSettings>& settings, const BufferRef& shadow_rays,
                       const BufferRef& shadow_light) const;
  /// Follows all chains to their ends; false when cancelled.
  bool follow(const HopSettings& settings);
  void warm_up();
  const TypedBuffer<float4>& gain() const { return gain_; }
  uint64_t rays() const { return rays_traced_; }  ///< segments of chains since the last reset_count()
  void reset_count() { rays_traced_ = 0; }
  static size_t estimate_bytes(size_t targets, size_t gains);

 private:
  void record(const SceneBuffers& scene, const SurfaceAtlas& atlas, const TypedBuffer<float4>& diffuse);
  KernelScheduler* scheduler_;
  Program program_;
  const Intersector* intersector_;
  Primitives primitives_;
  Options options_;
  TypedBuffer<float4> gain_;
  TypedBuffer<Hop> hops_;
  TypedBuffer<Ray> rays_;
  TypedBuffer<uint32_t> queue_, active_, counts_;
  Schedule follow_;
  Variable<HopSettings> settings_;
  uint32_t segment_[2] = {0, 0};  ///< read back after every segment: chains that took part, and that go on
  uint64_t rays_traced_ = 0;
};

}  // namespace lucarium::bundle
