// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "bundle_exchange/specular/chain_tracer.h"
#include "lucarium/services/bundles/direction_sequence.h"

namespace lucarium::bundle {

/// What texel sides with specular lobes (mirrors, glass, metals, coats) send towards the two directions of a bundle,
/// found by rays: chains of some texel sides per direction, chosen at random by how much their specular lobes reflect.
class SideChains {
 public:
  struct Options {
    float share = 1;        ///< probability of a chain of a texel side that reflects everything
    bool punctual = false;  ///< there are punctual lights
    int max_bounces = -1;
    bool only_punctual = false;  ///< no chains: the texel sides' own reflection of punctual lights
  };
  /// Texel sides with specular lobes, and roughly how much they reflect of light from everywhere.
  struct List {
    std::vector<uint32_t> sides;
    std::vector<float> reflectance;
  };
  struct Lists {
    List traced;  ///< mirrors, what transmits, and lobes narrower than `history_alpha`
    List glossy;  ///< the rest
  };
  static Lists specular_sides(const SurfaceAtlas& atlas, float history_alpha);
  /// `list` must not be empty.
  SideChains(Device& device, KernelScheduler& scheduler, const Program& program, const SceneBuffers& scene,
             const Intersector& intersector, const SurfaceAtlas& atlas, const SideMeans& means, const List& list,
             const Options& options);

  /// Renews what listed texel sides send, for the exchange along `direction`; false when cancelled. `lit`: with what
  /// their chains find of lights.
  bool find(const BundleDirection& direction, uint32_t seed, bool lit);
  void warm_up();
  /// Per listed texel side, Channels::reflected() float4: what find() has added to what it sends.
  const TypedBuffer<float4>& contribution() const { return tracer_.contribution(); }
  uint32_t count() const { return count_; }  ///< texel sides of the list
  uint64_t rays() const { return tracer_.chains().rays(); }
  void reset_count() { tracer_.chains().reset_count(); }

  static size_t estimate_bytes(size_t sides, const Channels& channels);

 private:
  void record(const SceneBuffers& scene, const SurfaceAtlas& atlas, const SideMeans& means);
  KernelScheduler* scheduler_;
  Program program_;
  Options options_;
  uint32_t count_;
  Primitives primitives_;
  TypedBuffer<uint32_t> list_, size_;
  TypedBuffer<float> probabilities_;
  ChainTracer tracer_;
  Schedule begin_, apply_;
  Variable<float4> omega_;
  Variable<ChainSettings> settings_;
};

}  // namespace lucarium::bundle
