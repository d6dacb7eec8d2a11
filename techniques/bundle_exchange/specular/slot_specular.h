// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <memory>

#include "bundle_exchange/senders/slot_ring.h"
#include "bundle_exchange/specular/slot_hops.h"

namespace lucarium::bundle {

/// What slots send by their specular lobes, direction by direction: narrow lobes and glass by rays (SlotHops), wide
/// ones by rays too or by what the last directions have brought (SlotRing).
class SlotSpecular {
 public:
  /// `punctual`: there are point, spot or directional lights; `by_area` as in SlotRing::Options.
  SlotSpecular(Device& device, KernelScheduler& scheduler, const Program& program, const SceneBuffers& scene,
               const Intersector& intersector, const SurfaceAtlas& atlas, const SlotMeans& means,
               const Parameters& parameters, bool punctual, int max_bounces, bool by_area);

  /// Whether the parameters ask for a ring; the least GGX width of lobes that bundles meet often enough (without a
  /// ring: those of pixels).
  static bool uses_ring(const Parameters& parameters) { return parameters.glossy_window > 0; }
  static float alpha_least(const Parameters& parameters);
  /// Whether some slot reflects directions, which then must be independent of each other.
  bool has_ring() const { return ring_ != nullptr; }

  /// The next batch; a batch that was cancelled may be begun again.
  void begin_batch(const DirectionSequence& sequence, uint64_t first, uint32_t count);
  /// Before direction i of the batch is exchanged; false when cancelled, and may be done again. `lit`: chains find
  /// lights.
  bool send(const BundleDirection& direction, uint32_t i, uint32_t seed, bool lit);
  /// After it.
  void receive(uint32_t i);
  void commit();
  void reset();
  void warm_up();
  uint64_t rays() const { return (hops_ ? hops_->rays() : 0) + (light_ ? light_->rays() : 0); }
  static size_t estimate_bytes(size_t slots, const Channels& channels, const Parameters& parameters);

 private:
  std::unique_ptr<SlotHops> hops_, light_;  ///< chains; light samples of slots of the ring
  std::unique_ptr<SlotRing> ring_;
};

}  // namespace lucarium::bundle
