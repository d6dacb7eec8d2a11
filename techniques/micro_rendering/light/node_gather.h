// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <vector>

#include "lucarium/services/primitives/primitives.h"
#include "micro_rendering/gather/gather_pass.h"

namespace lucarium::micro {

/// Irradiance gathered at the nodes of a cut (`jacobi_level`, `jacobi_cone`) and pushed to the leaves below them: an
/// iteration of "Multiple Bounces with Radiosity" (Ritschel et al. 2009, section 4).
class NodeGather {
 public:
  NodeGather(Device& device, KernelScheduler& scheduler, const SceneBuffers& scene, const PointForest& forest,
             const GatherPass& gather, const DynamicShading& shading, const MicroParameters& parameters,
             const std::string& owner);

  /// Chooses the cut and where its nodes gather, unless known: depends on geometry alone.
  void list();
  void geometry_changed() { listed_ = false; }
  uint32_t count() const { return count_; }  ///< nodes of the cut, after list()
  /// Gathers from node `first` on, at most kBatch of them. False when cancelled.
  bool gather(uint32_t first, uint32_t seed);
  /// Records `irradiance` = `direct` + what was gathered, by leaf.
  void add_push(ScheduleRecorder& recorder, const BufferRef& direct, const BufferRef& irradiance) const;
  const TypedBuffer<float4>& gathered() const {
    return results_.irradiance;
  }  ///< by result index [lx]; the first count() count
  void warm_up();
  static size_t estimate_bytes(const MicroParameters& parameters, size_t leaves);

  static constexpr uint32_t kBatch = 1024;

 private:
  uint32_t level_of(const ForestTree& tree) const;
  void record_list();
  void record_gather();

  KernelScheduler& scheduler_;
  const SceneBuffers& scene_;
  const PointForest& forest_;
  const GatherPass& gather_;
  const DynamicShading& shading_;
  MicroParameters parameters_;
  std::string owner_;
  Program program_;
  Primitives primitives_;
  std::vector<uint32_t> first_root_;  ///< by tree, among the nodes from which the cuts start
  uint32_t roots_ = 0, count_ = 0;
  TypedBuffer<uint32_t> totals_, cut_results_, leaf_results_, node_count_;
  TypedBuffer<MicroGather> gathers_;
  GatherResults results_;
  Schedule list_schedule_, gather_schedule_;
  Variable<MicroSettings> settings_;
  bool listed_ = false;
};

}  // namespace lucarium::micro
