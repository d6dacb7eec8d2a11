// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "bundle_exchange/shared/slots.h"
#include "lucarium/services/intersector.h"
#include "lucarium/services/primitives/primitives.h"
#include "lucarium/services/surface_atlas/surface_atlas.h"

namespace lucarium::bundle {

/// What of every slot lies hidden inside other solids: where surfaces pass through each other (columns that stand in
/// floors), texels are partly, or all, where no light ever comes and nothing looks. Such parts must not count, or the
/// texel would be too dark where it is seen. Found by up to 16 rays from each of its random points, some slots at a
/// time.
class SlotExposure {
 public:
  SlotExposure(Device& device, KernelScheduler& scheduler, const Program& program, const SceneBuffers& scene,
               const Intersector& intersector, const SurfaceAtlas& atlas);

  /// Traces the rays of the next slots; false when cancelled, and nothing has changed.
  bool advance();
  /// What of the slots has been done [1]; what follows holds when all has.
  double progress() const { return static_cast<double>(next_) / slots_; }
  bool complete() const { return next_ == slots_; }

  /// Per slot: x the share of its area that light can reach; y which share of its rays that end at backs of
  /// single-sided surfaces leaves from there, and therefore counts.
  const TypedBuffer<float2>& shares() const { return shares_; }
  /// Per slot, a bit for each of its points that no light can reach.
  const TypedBuffer<uint32_t>& hidden() const { return hidden_; }
  static size_t estimate_bytes(size_t slots);

 private:
  void record(const Program& program, const SceneBuffers& scene, const Intersector& intersector,
              const SurfaceAtlas& atlas);
  KernelScheduler* scheduler_;
  Primitives primitives_;
  uint32_t slots_, chunk_;
  TypedBuffer<float2> shares_;
  TypedBuffer<uint32_t> hidden_;
  Schedule measure_;
  Variable<uint32_t> first_, count_, points_;
  uint32_t next_ = 0;  ///< slots done
};

}  // namespace lucarium::bundle
