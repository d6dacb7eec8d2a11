// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "lucarium/compute/schedule/scheduler.h"
#include "lucarium/scene/device/scene_buffers.h"
#include "lucarium/services/interior_surfaces/texel_interior.h"
#include "lucarium/services/layered_raster/layered_raster.h"
#include "lucarium/services/texel_sides/side_accessibility.h"
#include "lucarium/technique/technique_state.h"
#include "virtual_light_field/base/plan.h"
#include "virtual_light_field/directions/direction_grid.h"
#include "virtual_light_field/scatter/field_tail.h"
#include "virtual_light_field/tiles/tile_maps.h"

namespace lucarium::vlf {

/// The light field of a scene and its propagation. Sweep s transports, along all lines, the light that was scattered
/// exactly s times: out^(0) is emission; what a sweep has brought is scattered, and is sent in the next. Irradiance of
/// texel sides and radiance of cells sum up over sweeps.
///
/// Three maps (Mortensen et al. 2007, section 3.1): `sent_`, what this sweep shoots (current; section 3.4:
/// cURM), `incoming_`, what the sweep brings (next; nURM), and `total_`; of texel sides `records_`, which has what is
/// sent and what comes, and `direct_` and `indirect_`.
class LightField {
 public:
  struct Options {
    uint32_t dir_n = 16;
    FilmPlan film;
    uint64_t seed = 1;
    uint32_t line_seed = 1;  ///< decides BLEND, with the line
    int max_bounces = -1;
    bool sampled = true;       ///< Plan::sampled
    bool scatter_last = true;  ///< facets send what the last sweep of finite bounces brought, for look-ups by pixels
    bool split = true;         ///< direct light of cells is kept apart
    bool fold = true;          ///< weak coats reflect diffusely
    bool tail = true;
    double residual = 0.005;
  };
  /// All must outlive this. `light_samples`: SideLight::light_samples().
  LightField(Device& device, KernelScheduler& scheduler, const Scene& host_scene, const SceneBuffers& scene,
             const Intersector& intersector, const SurfaceAtlas& atlas, const Patches& patches,
             const LayeredRaster& raster, const TexelInterior& interior, const SideAccessibility& accessibility,
             const TypedBuffer<float4>& light_samples, const Options& options);

  /// When the light samples are known: the next part of the propagation, about 4 million pixels of films or a million
  /// cells. False when cancelled: the next call goes on there.
  bool advance();
  bool done() const { return stage_ == Stage::done; }
  double progress() const;  ///< [1], of finite bounces; of unlimited ones estimated by the error
  std::string phase() const;
  const std::string& why_done() const { return why_done_; }

  /// Grows when what is displayed has changed.
  uint32_t shown_sweeps() const { return shown_sweeps_; }

  // Per texel side, over π and times accessibility, w accessibility: direct, of later sweeps, and all that rays of
  // pixels may look up (one bounce less).
  const TypedBuffer<float4>& shown_direct() const { return shown_direct_; }
  const TypedBuffer<float4>& shown() const { return shown_; }
  const TypedBuffer<float4>& held() const { return held_; }
  const TileMaps& maps() const { return maps_; }
  const TypedBuffer<uint32_t>& total() const { return total_; }  ///< per cell, RGB9E5 times scale()
  const TypedBuffer<uint32_t>& direct() const { return direct_cells_; }
  bool split() const { return options_.split; }
  float scale() const { return scale_; }
  const FieldTail& tail() const { return tail_; }
  uint32_t sweeps() const { return sweep_; }  ///< transported
  uint64_t lines_drawn() const { return lines_drawn_; }
  double film_pixels() const { return film_pixels_; }
  uint64_t cells_scattered() const { return cells_scattered_; }
  void warm_up();
  /// What is displayed. A loaded field shows the same bits; it is not to be advanced.
  void save(StateWriter& chunks) const;
  void load(const StateReader& chunks);

  /// Device memory without cells [bytes], and of a cell while light propagates.
  static size_t estimate_bytes(size_t sides);
  static constexpr uint32_t kMaxLights = 32;  ///< punctual ones that make highlights on facets
  static constexpr size_t kCellBytes = 16, kSplitBytes = 4;

 private:
  enum class Stage { survey, transport, scatter, done };
  /// What a line's schedule takes.
  struct LineSchedule {
    Schedule schedule;
    Variable<uint32_t> line, first_cell, cells;
    Variable<float> weight, scale, inverse_scale;
  };
  void record_sides();
  static LineSchedule begin_line(ScheduleRecorder& recorder);
  void record_lines(Device& device, const LayeredRaster& raster, const TexelInterior& interior,
                    const SideAccessibility& accessibility);
  void record_scatter(Device& device);
  void record_visibility(Device& device, const Intersector& intersector);
  void begin();
  void find_scale();
  bool run_line();
  void end_sweep();
  double scatter_tiles();  ///< the next ones; how many cells
  void finish_sweep(const Norms& norms);
  bool is_last() const;
  Norms take_norms() const;

  KernelScheduler* scheduler_;
  const Scene* host_scene_;
  const SceneBuffers* scene_;
  const SurfaceAtlas* atlas_;
  Options options_;
  DirectionGrid grid_;
  TileMaps maps_;
  bool tiled_;
  uint32_t sides_;
  TypedBuffer<float4> light_samples_, albedo_, records_, direct_, indirect_, last_, shown_direct_, shown_, held_;
  TypedBuffer<float> shares_;
  TypedBuffer<uint32_t> cell_side_, incoming_, sent_, total_, direct_cells_;
  TypedBuffer<float4> received_, extinction_, side_norms_, tile_norms_, norms_;
  TypedBuffer<float> distance_;
  TypedBuffer<LayeredView> views_;
  TypedBuffer<float4> ends_;
  std::vector<uint32_t> host_lights_;  ///< entries of the light mixture
  TypedBuffer<uint32_t> lights_, visible_, count_;
  Program side_program_;
  Schedule see_, emit_, fold_, scatter_, sum_tiles_, show_, add_cells_;
  Schedule begin_line_;
  Variable<LayeredView> line_view_;
  Variable<float4> line_omega_;
  Variable<uint32_t> line_emission_;
  LineSchedule survey_, line_;
  Variable<uint32_t> cell_sweep_, fold_sweep_, scatter_first_, scatter_end_, scatter_sweep_;
  Variable<float> scatter_scale_, field_scale_;
  Variable<uint32_t> seen_light_, seen_bit_;
  Variable<float4> show_tail_, cell_tail_;
  Variable<uint32_t> show_hold_;
  Stage stage_ = Stage::survey;
  bool begun_ = false;
  uint32_t next_light_ = 0, next_line_ = 0, next_tile_ = 0, sweep_ = 0, shown_sweeps_ = 0;
  float scale_ = 1;
  FieldTail tail_;
  std::string why_done_;
  Norms side_sums_{};
  uint64_t lines_drawn_ = 0, cells_scattered_ = 0;
  double film_pixels_ = 0;
};

}  // namespace lucarium::vlf
