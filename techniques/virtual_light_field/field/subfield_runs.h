// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <memory>
#include <vector>

#include "lucarium/compute/schedule/scheduler.h"
#include "lucarium/scene/device/scene_buffers.h"
#include "lucarium/services/interior_surfaces/texel_interior.h"
#include "lucarium/services/layered_raster/layered_raster.h"
#include "lucarium/services/texel_sides/kept_rows.h"
#include "lucarium/services/texel_sides/side_accessibility.h"
#include "virtual_light_field/base/plan.h"
#include "virtual_light_field/tiles/cell_buffers.h"
#include "virtual_light_field/tiles/tile_maps.h"

namespace lucarium::vlf {

/// What happens along subfields: which texel side each cell shows, fragments that are kept, and the exchange of light.
/// A line has one subfield, or `perturb` of directions about its own.
class SubfieldRuns {
 public:
  struct Options {
    SubfieldPlan subfield;
    uint32_t perturb = 1;   ///< Q
    bool cellwise = false;  ///< facets send by cells, not by directions around a perturbed one
    uint64_t seed = 1;
    uint32_t blend_seed = 1;  ///< with the subfield
    size_t cache = 0;         ///< for fragments that are kept [bytes]; 0: none are
  };
  /// All must outlive this. `records`: of texel sides (fold_sides.cl).
  SubfieldRuns(Device& device, KernelScheduler& scheduler, const Scene& host_scene, const SceneBuffers& scene,
               const DirectionGrid& grid, const TileMaps& maps, const SurfaceAtlas& atlas, const LayeredRaster& raster,
               const TexelInterior& interior, const SideAccessibility& accessibility, const CellBuffers& cells,
               const TypedBuffer<float4>& records, const Options& options);

  uint32_t lines() const { return maps_->info().lines; }
  uint32_t subfields() const { return lines() * options_.perturb; }
  double pixels() const;  ///< of a subfield
  /// Each of these runs to its end: half a subfield would be counted twice. False when cancelled before.
  bool survey(uint32_t line);
  bool keep(uint32_t subfield);
  /// emission: of the sky.
  bool exchange(uint32_t subfield, bool emission, float scale);
  /// Behind the last exchange of a sweep: what has come to cells of coarser grids, from all lines.
  void average_coarse();
  size_t coarse_bytes() const { return average_coarse_ ? coarse_.bytes() : 0; }

  /// Subfields that were kept are known from here on.
  void end_keeping() {
    if (kept_) kept_->finish();
  }
  bool keeps() const { return kept_ != nullptr; }
  /// Whether fragments of a scene can be kept: attenuation asks for lengths of gaps, which are not.
  static bool can_keep(const Scene& scene);
  uint32_t kept_subfields() const { return kept_ ? kept_->kept_views() : 0; }
  uint64_t drawn() const { return drawn_; }  ///< subfields, by raster or kept
  void forget_drawn() { drawn_ = 0; }
  double drawn_pixels() const { return static_cast<double>(drawn_) * pixels(); }
  /// Directions of subfields, xyz; perturbed ones where there are any.
  const std::vector<FieldLine>& host_subfields() const { return perturbed_.empty() ? maps_->host_lines() : perturbed_; }
  void warm_up();

 private:
  /// What the schedule of a subfield takes.
  struct Run {
    Schedule schedule;
    Variable<uint32_t> line, first_cell, coarse_base, cells, subfield;
    Variable<float> weight, scale, inverse_scale;
  };
  void record_begin(Device& device, const SceneBuffers& scene);
  void record_survey(const LayeredRaster& raster, const SurfaceAtlas& atlas, const CellBuffers& cells,
                     const Program& average, bool kept, Run* target);
  void record_exchange(Device& device, const LayeredRaster& raster, const SurfaceAtlas& atlas,
                       const TexelInterior& interior, const SideAccessibility& accessibility, const CellBuffers& cells,
                       const TypedBuffer<float4>& records, bool kept, Run* run);
  void record_average(const CellBuffers& cells, const Program& average);
  void record_coarse_average(const CellBuffers& cells, const Program& average);
  bool begin(const FieldLine& subfield, uint32_t number, bool emission);

  KernelScheduler* scheduler_;
  double depth_range_;  ///< of views [m]; known once, since Scene::bounds() looks at every vertex
  const TileMaps* maps_;
  Options options_;
  std::vector<FieldLine> perturbed_;
  TypedBuffer<LayeredView> views_;
  TypedBuffer<float4> ends_, extinction_, received_;
  TypedBuffer<uint32_t> fixed_, coarse_;
  TypedBuffer<float> distance_;
  std::unique_ptr<KeptRows> kept_;
  Schedule begin_;
  Variable<LayeredView> view_;
  Variable<float4> omega_;
  Variable<uint32_t> emission_;
  Run survey_, survey_kept_, exchange_, exchange_kept_, average_;
  Schedule average_coarse_;
  uint64_t drawn_ = 0;
};

}  // namespace lucarium::vlf
