// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <memory>

#include "lucarium/services/intersector.h"
#include "lucarium/services/primitives/primitives.h"
#include "micro_rendering/gather/gather_pass.h"
#include "micro_rendering/light/node_gather.h"
#include "micro_rendering/light/path_light.h"

namespace lucarium::micro {

/// Light at the leaves of a forest: direct light by shadow rays, further bounces by gathering at nodes (Jacobi
/// iteration) or by paths from the lights (all of Ritschel et al. 2009, section 4), and its means in the inner nodes.
/// It comes in steps of about as much work as NodeGather::kBatch gathers or less, one light sample per leaf at least.
class LeafLight {
 public:
  /// `bounces`: scatterings before the last gather; 1 is direct light alone.
  LeafLight(Device& device, KernelScheduler& scheduler, const Scene& host_scene, const SceneBuffers& scene,
            const Intersector& intersector, const PointForest& forest, const GatherPass& gather,
            const MicroParameters& parameters, int bounces, const std::string& owner);

  /// Whether the nodes shine with samples that belong to `frame`.
  bool lit(uint32_t frame, uint32_t seed) const { return stage_ == Stage::done && frame_ == frame && seed_ == seed; }
  /// Whether nodes shine with samples of any frame, though further bounces or another frame's may be on their way.
  bool shines() const { return shines_; }
  /// The next step towards lit(); starts over for another frame or seed. When cancelled (false) nodes shine as before,
  /// and the next call repeats the step; where it was that of photons it starts over.
  bool step(uint32_t frame, uint32_t seed);
  /// What the last step was worth [gathers].
  double last_work() const { return last_work_; }
  /// All steps until only bounces by gathering and the nodes' radiance are left. False when cancelled.
  bool receive(uint32_t frame, uint32_t seed);
  /// All steps that are left.
  bool spread();
  TypedBuffer<float4>& received() { return direct_; }  ///< by leaf [lx]
  const TypedBuffer<float4>& irradiance() const {
    return nodes_ ? irradiance_ : direct_;
  }                                                    ///< all that leaves get, by leaf [lx]
  const NodeGather& nodes() const { return *nodes_; }  ///< with several bounces, by multibounce=jacobi
  const DynamicShading& shading() const { return shading_; }
  /// Something that light depends on has changed; `surfaces`: points have moved, or materials have changed.
  void changed(bool surfaces);
  void warm_up();
  uint64_t gathers() const { return gathers_; }  ///< at nodes, so far
  static size_t estimate_bytes(const MicroParameters& parameters, size_t leaves, int bounces);

 private:
  enum class Stage { none, samples, paths, path_light, pull, gather, done };
  bool dynamic() const { return parameters_.node_shading == NodeShading::dynamic; }
  void begin(uint32_t frame, uint32_t seed);
  bool advance();
  bool sample();
  bool add_path_light();
  bool pull();
  bool gather();
  void record_direct();
  void record_pull();
  void record_bounce();
  void record_lobes();
  void add_choices(ScheduleRecorder& recorder, const BufferRef& extremes);
  void add_pull(ScheduleRecorder& recorder, const BufferRef& irradiance, bool choose);

  Device& device_;
  KernelScheduler& scheduler_;
  const SceneBuffers& scene_;
  const Intersector& intersector_;
  const PointForest& forest_;
  MicroParameters parameters_;
  int bounces_;
  std::string owner_;
  Program program_;
  Primitives primitives_;
  TypedBuffer<float4> direct_;      ///< irradiance of leaves by direct light and paths [lx]
  TypedBuffer<float4> irradiance_;  ///< the same with what nodes have gathered
  DynamicShading shading_;
  TypedBuffer<MicroLeafLight> arriving_;  ///< shading_.leaf_lights of a frame on its way: nodes still stand for those
  Schedule direct_schedule_, pull_schedule_, bounce_schedule_, lobes_schedule_;
  Variable<uint32_t> sample_, light_seed_, choice_seed_;
  std::unique_ptr<NodeGather> nodes_;
  std::unique_ptr<PathLight> paths_;
  uint64_t gathers_ = 0;
  bool lobes_known_ = false, shines_ = false;
  Stage stage_ = Stage::none;
  uint32_t frame_ = 0, seed_ = 0;  ///< of the light that is there or on its way
  uint32_t part_ = 0;              ///< of the stage: light sample, virtual light, or node
  int bounce_ = 1;                 ///< that nodes gather
  double last_work_ = 0;
};

}  // namespace lucarium::micro
