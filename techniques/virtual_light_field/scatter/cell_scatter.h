// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <vector>

#include "lucarium/compute/schedule/scheduler.h"
#include "lucarium/scene/device/scene_buffers.h"
#include "lucarium/services/intersector.h"
#include "virtual_light_field/base/parameters.h"
#include "virtual_light_field/scatter/field_tail.h"
#include "virtual_light_field/tiles/cell_buffers.h"
#include "virtual_light_field/tiles/tile_maps.h"

namespace lucarium::vlf {

/// What facets reflect and refract of what a sweep has brought, cell by cell, and the totals of that.
class CellScatter {
 public:
  struct Options {
    bool split = true;  ///< the first scattering is kept apart
    ScatterMode mode = ScatterMode::gather;
    uint32_t perturb = 1;  ///< subfields of a line
    uint32_t seed = 1;     ///< of shadow rays
  };
  static constexpr uint32_t kMaxLights = 32;  ///< punctual ones that make highlights on facets

  /// All must outlive this. `subfields`: SubfieldRuns::host_subfields(). `norms`: receives sums of norms.clh.
  CellScatter(Device& device, KernelScheduler& scheduler, const Scene& host_scene, const SceneBuffers& scene,
              const Intersector& intersector, const SurfaceAtlas& atlas, const TileMaps& maps, const CellBuffers& cells,
              const std::vector<FieldLine>& subfields, const Program& sums, const TypedBuffer<float4>& norms,
              const Options& options);

  /// Cells without light, before the first sweep.
  void begin();
  /// Which punctual lights texel sides see: the next light. False when cancelled.
  bool see_light();
  bool sees_all() const { return next_light_ == host_lights_.size(); }
  bool has_lights() const { return !host_lights_.empty(); }
  /// The next tiles, behind sweep `sweep`; how many cells. Behind the last ones their norms are summed up.
  double scatter(uint32_t sweep, float scale);
  bool complete() const { return next_tile_ == maps_->tiles(); }
  /// Adds what is sent next to the totals, and `tail` times as much.
  void add(uint32_t sweep, const float4& tail);

  size_t norm_bytes() const { return tile_norms_.bytes(); }
  uint64_t cells_scattered() const { return cells_scattered_; }
  void warm_up();
  /// Device memory without cells and tiles [bytes].
  static size_t estimate_bytes(size_t sides, bool lights);

 private:
  void record_scatter(const SceneBuffers& scene, const SurfaceAtlas& atlas, const Program& program,
                      const std::vector<FieldLine>& subfields);
  void record_visibility(Device& device, const SceneBuffers& scene, const SurfaceAtlas& atlas,
                         const Intersector& intersector);

  KernelScheduler* scheduler_;
  const TileMaps* maps_;
  CellBuffers cells_;
  Options options_;
  std::vector<uint32_t> host_lights_;  ///< entries of the light mixture
  TypedBuffer<uint32_t> lights_, visible_, count_;
  TypedBuffer<float4> tile_norms_, subfields_;
  Schedule see_, scatter_, sum_, add_;
  Variable<uint32_t> first_tile_, end_tile_, sweep_, added_sweep_, light_, bit_;
  Variable<float> scale_, inverse_scale_;
  Variable<float4> tail_;
  uint32_t next_tile_ = 0, next_light_ = 0;
  uint64_t cells_scattered_ = 0;
};

}  // namespace lucarium::vlf
