// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "bundle_exchange/senders/side_means.h"
#include "bundle_exchange/shared/contribution_layout.h"
#include "lucarium/services/specular_chains/specular_chains.h"
#include "lucarium/services/surface_atlas/surface_atlas.h"

namespace lucarium::bundle {

/// Specular chains that look up the diffuse light of texel sides, and the light that they find for their targets
/// (advance_chains.cl). `diffuse`: of their `halves`.
class ChainTracer {
 public:
  struct Options {
    uint32_t targets = 0;
    uint32_t contributions = 1;          ///< float4 per target
    uint32_t layout = CONTRIBUTION_ONE;  ///< CONTRIBUTION_*: which of them light is added to
    bool punctual = false;               ///< there are punctual lights
    std::string what;                    ///< for names of passes and memory
  };
  ChainTracer(Device& device, KernelScheduler& scheduler, const Program& program, const SceneBuffers& scene,
              const Intersector& intersector, const SurfaceAtlas& atlas, const TypedBuffer<float4>& diffuse,
              const SideHalves& halves, const Options& options);

  /// What begins chains clears.
  const TypedBuffer<float4>& contribution() const { return contribution_; }
  const SpecularChains& chains() const { return chains_; }
  SpecularChains& chains() { return chains_; }
  static size_t estimate_bytes(size_t targets, size_t contributions) {
    return targets * contributions * sizeof(float4) + SpecularChains::estimate_bytes(targets);
  }

 private:
  TypedBuffer<float4> contribution_;
  SpecularChains chains_;
};

}  // namespace lucarium::bundle
