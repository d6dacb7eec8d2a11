// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>

#include "lucarium/compute/schedule/scheduler.h"
#include "lucarium/services/interior_surfaces/interior_walks.h"
#include "lucarium/services/primitives/primitives.h"
#include "lucarium/services/surface_atlas/surface_atlas.h"

namespace lucarium {

/// Interior part of every texel side of an atlas (interior_walks.h). Where surfaces pass through each other, texels lie
/// partly or wholly inside a solid, invisible and without light. Such parts must not count, or the texel would be
/// too dark where it is seen. Measured by up to 16 walks from each random point of a texel side, some texel sides at a
/// time.
class TexelInterior {
 public:
  /// One step: a ray that meets a front sees something that may send light. So do the rays of bundles, one by one, and
  /// what they count must agree with what is measured here.
  static constexpr InteriorRule kSeenFromTexels{.steps = 1};

  /// `atlas` has SurfaceAtlasOptions::samples of 1 to 32. `owner` pays for the memory; `remedy` is what a message about
  /// too little of it advises. All must outlive this.
  TexelInterior(Device& device, KernelScheduler& scheduler, const SceneBuffers& scene, const Intersector& intersector,
                const SurfaceAtlas& atlas, const std::string& owner, const char* remedy,
                const InteriorRule& rule = kSeenFromTexels);

  /// Follows the walks of the next texel sides; false when cancelled, and nothing has changed.
  bool advance();
  double progress() const { return static_cast<double>(next_) / sides_; }  ///< [1]
  /// What follows holds then.
  bool complete() const { return next_ == sides_; }

  /// Per texel side: x the share of its area that light can reach; y which share of its rays that end at backs of
  /// single-sided surfaces leaves from there, and therefore counts.
  const TypedBuffer<float2>& shares() const { return shares_; }
  /// Per texel side, a bit for each of its points that no light can reach.
  const TypedBuffer<uint32_t>& hidden() const { return hidden_; }
  /// Device memory while it measures, and what stays of it [bytes].
  static size_t estimate_bytes(size_t sides, size_t samples);
  static size_t held_bytes(size_t sides);

 private:
  void record(const SurfaceAtlas& atlas, const std::string& owner);
  KernelScheduler* scheduler_;
  Primitives primitives_;
  InteriorWalks walks_;
  Program program_;
  uint32_t sides_, samples_, chunk_;
  TypedBuffer<float2> shares_;
  TypedBuffer<uint32_t> hidden_;
  Schedule measure_;
  Variable<uint32_t> first_, count_, points_;
  uint32_t next_ = 0;  ///< texel sides done
};

}  // namespace lucarium
