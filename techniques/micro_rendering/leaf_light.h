// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <memory>

#include "gather_pass.h"
#include "light_paths.h"
#include "lucarium/services/intersector.h"
#include "lucarium/services/primitives.h"

namespace lucarium::micro {

/// Light at the leaves of a forest: direct light by shadow rays, further bounces by gathering at the nodes of one level
/// (Jacobi iteration) or by paths from the lights (Ritschel et al. 2009, section 4), and its means in the inner nodes.
class LeafLight {
 public:
  /// `bounces`: scatterings before the last gather; 1 is direct light alone.
  LeafLight(Device& device, KernelScheduler& scheduler, const Scene& host_scene, const SceneBuffers& scene,
            const Intersector& intersector, const PointForest& forest, const GatherPass& gather, const MicroParameters& parameters, int bounces,
            const std::string& owner);

  /// Lights the forest with samples that belong to `frame`, unless that is how it is lit. False when cancelled: radiance is
  /// then useless.
  bool run(uint32_t frame, uint32_t seed);
  /// The first part of run(): irradiance of the leaves by all light that needs no gathering.
  bool receive(uint32_t frame, uint32_t seed);
  /// The rest: bounces by gathering at nodes, and the nodes' radiance.
  bool spread(uint32_t frame, uint32_t seed);
  TypedBuffer<float4>& received() { return direct_; }  ///< by leaf [lx]
  const TypedBuffer<float4>& gathered() const { return node_results_.irradiance; }  ///< of the last bounce, by node [lx]
  const DynamicShading& shading() const { return shading_; }
  /// Something that light depends on has changed; `surfaces`: points have moved, or materials have changed.
  void changed(bool surfaces);
  void warm_up();
  uint64_t gathers() const { return gathers_; }  ///< at nodes, so far
  static size_t estimate_bytes(const MicroParameters& parameters, size_t leaves, int bounces);

 private:
  bool gathers_at_nodes() const { return bounces_ > 1 && parameters_.multibounce == MultiBounce::jacobi; }
  void record_direct();
  void record_pull();
  void record_bounce();
  void record_nodes();
  bool dynamic() const { return parameters_.node_shading == NodeShading::dynamic; }
  void record_lobes();
  void add_choices(ScheduleRecorder& recorder, const BufferRef& extremes);
  void add_pull(ScheduleRecorder& recorder, const BufferRef& irradiance, bool choose);
  uint32_t level_of(const ForestTree& tree) const;

  Device& device_;
  KernelScheduler& scheduler_;
  const SceneBuffers& scene_;
  const Intersector& intersector_;
  const PointForest& forest_;
  const GatherPass& gather_;
  MicroParameters parameters_;
  int bounces_;
  std::string owner_;
  Program program_;
  Primitives primitives_;
  TypedBuffer<float4> direct_;      ///< irradiance of leaves by direct light [lx]
  TypedBuffer<float4> irradiance_;  ///< the same with what nodes have gathered
  DynamicShading shading_;
  TypedBuffer<uint32_t> leaf_count_, node_count_;  ///< one element each
  TypedBuffer<MicroGather> node_gathers_;
  GatherResults node_results_;
  std::vector<uint32_t> first_slot_;  ///< by tree, in node_gathers_
  Schedule direct_schedule_, pull_schedule_, bounce_schedule_, nodes_schedule_, lobes_schedule_;
  Variable<uint32_t> sample_, light_seed_, choice_seed_;
  Variable<MicroSettings> settings_;
  uint64_t gathers_ = 0;
  bool nodes_known_ = false, lobes_known_ = false, lit_ = false;
  uint32_t lit_frame_ = 0, lit_seed_ = 0;  ///< of what the nodes shine with, where lit_
  std::unique_ptr<LightPaths> paths_;
};

}  // namespace lucarium::micro
