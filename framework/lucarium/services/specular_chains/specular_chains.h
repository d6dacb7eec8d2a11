// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <functional>
#include <string>

#include "lucarium/compute/schedule/scheduler.h"
#include "lucarium/scene/device/scene_buffers.h"
#include "lucarium/services/intersector.h"
#include "lucarium/services/primitives/primitives.h"
#include "lucarium/shared/specular_chain.h"

namespace lucarium {

/// Follows specular chains by rays until none is left: paths that leave a target (a pixel, a texel side) by reflection
/// or transmission and go on by specular lobes only, mirrors, glass, metals, coats. The lobes are sampled, with Russian
/// roulette from the fourth vertex on; media absorb; emitters and the environment are found by chance, punctual lights
/// by light samples at vertices with smooth lobes. The consumer adds what surfaces send by other lobes
/// (advance.clh): from an atlas, a light field, or nothing.
///
/// The caller's own kernel begins the chains with begin_chain() and extend_chain() of chain.clh, at most one per
/// target.
class SpecularChains {
 public:
  /// Longest chain that is worth following: ChainSettings::max_vertices.
  static constexpr uint32_t kMaxVertices = 64;

  struct Options {
    uint32_t targets = 0;
    bool punctual = false;  ///< there are point, spot or directional lights
    std::string owner;      ///< pays for the memory
    std::string what;       ///< has chains, for names of passes and memory: "pixels"
  };
  /// The consumer's kernels with LUCARIUM_CHAIN_PARAMETERS and LUCARIUM_CHAIN_LIGHT_PARAMETERS, compiled with
  /// ray_end_defines(), and what binds their other parameters.
  struct Consumer {
    Program program;
    std::string advance, add_light;
    std::function<void(PassBuilder&)> bind_advance, bind_add_light;
  };
  SpecularChains(Device& device, KernelScheduler& scheduler, const SceneBuffers& scene, const Intersector& intersector,
                 Options options, Consumer consumer);
  SpecularChains(const SpecularChains&) = delete;  // schedules read back into it
  SpecularChains& operator=(const SpecularChains&) = delete;

  // Buffers that the kernel which begins chains fills: chains by target; rays, and their targets, `active` of them.
  const TypedBuffer<SpecularChain>& chains() const { return chains_; }
  const TypedBuffer<Ray>& first_rays() const { return rays_; }
  const TypedBuffer<RayEnds>& first_ends() const { return ends_; }  ///< empty where the intersector wants none
  const TypedBuffer<uint32_t>& queue() const { return queue_; }
  const TypedBuffer<uint32_t>& active() const { return active_; }
  /// Records the passes that add light samples whose shadow rays are free, of first vertices, which the caller has
  /// sampled (sample_chain_light()). No passes without punctual lights.
  /// shadow_light: xyz light, w bits of its number of scatterings; shadow_ends: where the intersector wants them.
  void record_light(ScheduleRecorder& recorder, const BufferRef& shadow_rays, const BufferRef& shadow_light,
                    const BufferRef& shadow_ends = {}) const;

  /// Follows all chains to their ends; false when cancelled, and the chains must be begun again.
  bool follow(const ChainSettings& settings);
  void warm_up();
  uint64_t rays() const { return rays_traced_; }  ///< segments since the last reset_count()
  void reset_count() { rays_traced_ = 0; }
  static size_t estimate_bytes(size_t targets);

 private:
  void record(const SceneBuffers& scene);
  KernelScheduler* scheduler_;
  const Intersector* intersector_;
  Primitives primitives_;
  Options options_;
  Consumer consumer_;
  Program program_;
  TypedBuffer<SpecularChain> chains_;
  TypedBuffer<Ray> rays_;
  TypedBuffer<RayEnds> ends_;
  TypedBuffer<uint32_t> queue_, active_, counts_;
  Schedule follow_;
  Variable<ChainSettings> settings_;
  uint32_t segment_[2] = {0, 0};  ///< read back after every segment: chains that took part, and that go on
  uint64_t rays_traced_ = 0;
};

}  // namespace lucarium
