// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>

#include "lucarium/compute/schedule/scheduler.h"
#include "micro_rendering/base/micro_parameters.h"
#include "micro_rendering/shared/micro_types.h"
#include "micro_rendering/tree/point_forest.h"

namespace lucarium::micro {

/// Where a gather pass puts its results, by their index (MicroGather).
struct GatherResults {
  TypedBuffer<float4> irradiance;           ///< 1 per result
  TypedBuffer<float4> specular;             ///< 2 per result; 2 elements suffice for diffuse gathers alone
  TypedBuffer<MicroStatistics> statistics;  ///< 1 per result
  TypedBuffer<float4> micro_buffer;         ///< of the inspected result, row by row: 64 · 64
  TypedBuffer<float4> levels;               ///< 1 per result, at pixels with cut_error
  TypedBuffer<float4> sky;                  ///< 3 per result where gathers see the environment, else none

  GatherResults() = default;
  GatherResults(Device& device, const std::string& owner, const std::string& what, size_t count, bool specular_too,
                bool sky_too = false);
  static size_t estimate_bytes(size_t count, bool specular_too, bool sky_too = false);
};

/// What nodes need beside their stored radiance for node_shading=dynamic; empty without it.
struct DynamicShading {
  TypedBuffer<MicroNodeChoice> choices;     ///< by node
  TypedBuffer<MicroLeafLight> leaf_lights;  ///< by leaf
  TypedBuffer<MicroLeafLobe> leaf_lobes;    ///< by leaf

  DynamicShading() = default;
  DynamicShading(Device& device, const std::string& owner, size_t leaves);
  static size_t estimate_bytes(size_t leaves);
};

/// Who gathers: visible points, or nodes for further bounces. Only the former see the environment, and
/// glossy lobes of nodes.
enum class GatherAt { pixels, nodes };

/// The gather kernel with the rules that parameters choose.
class GatherPass {
 public:
  GatherPass() = default;
  GatherPass(Device& device, const MicroParameters& parameters, GatherAt at);

  /// What all passes of these parameters have in common.
  static MicroSettings settings(const MicroParameters& parameters, uint32_t seed, uint32_t inspect = LUCARIUM_NONE,
                                uint32_t inspect_too = LUCARIUM_NONE);

  /// Records a pass over gathers [settings.first, gather_count[0]), at most `max_count` of them; 0: from settings.first
  /// = 0 on, all. `shading` is used at pixels alone.
  void record(ScheduleRecorder& recorder, const std::string& name, const SceneBuffers& scene, const PointForest& forest,
              const BufferRef& gathers, const BufferRef& gather_count, uint32_t max_count,
              const Variable<MicroSettings>& settings, const GatherResults& results,
              const DynamicShading& shading) const;

 private:
  Program program_;
  size_t gathers_per_slice_ = 1;
  bool sky_ = false, dynamic_ = false, levels_ = false;
};

}  // namespace lucarium::micro
