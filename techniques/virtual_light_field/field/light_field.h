// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "lucarium/technique/technique_state.h"
#include "virtual_light_field/field/subfield_runs.h"
#include "virtual_light_field/scatter/cell_scatter.h"

namespace lucarium::vlf {

constexpr float kMaxStored = 256;      // stored radiance of the brightest sender; bounces add up to 255 times as much
constexpr float kMaxScale = 0x1p100f;  // what radiance is stored times is from 1 / kMaxScale to this

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
    SubfieldPlan subfield;
    uint32_t perturb = 1;   ///< Q: subfields of a line
    bool cellwise = false;  ///< SubfieldRuns::Options::cellwise
    size_t cache = 0;       ///< for kept fragments [bytes]
    bool rows = false;      ///< store=csr
    ScatterMode scatter = ScatterMode::gather;
    uint64_t seed = 1;
    uint32_t line_seed = 1;  ///< decides BLEND, with the subfield
    int max_bounces = -1;
    bool sampled = true;       ///< Plan::sampled
    bool scatter_last = true;  ///< facets send what the last sweep of finite bounces brought, for look-ups by pixels
    bool split = true;         ///< direct light of cells is kept apart
    bool fold = true;          ///< weak coats reflect diffusely
    bool tail = true;
    bool preview = false;  ///< few lines bring a coarse field first, which is displayed until a better one is known
    double residual = 0.005;
    bool loaded = false;  ///< nothing will be propagated: load() follows
  };
  /// All must outlive this. `light_samples`: SideLight::light_samples().
  LightField(Device& device, KernelScheduler& scheduler, const Scene& host_scene, const SceneBuffers& scene,
             const Intersector& intersector, const SurfaceAtlas& atlas, const Patches& patches,
             const LayeredRaster& raster, const TexelInterior& interior, const SideAccessibility& accessibility,
             const TypedBuffer<float4>& light_samples, const Options& options);

  /// When the light samples are known: the next part of the propagation, about so many pixels of subfields, or a
  /// quarter as many cells; at least a line. False when cancelled: the next call goes on there.
  bool advance(double subfield_pixels = 4e6);
  bool done() const { return stage_ == Stage::done; }
  /// Of the subfields that come next, those that are rasterized; the others' fragments are kept.
  double drawn_share() const;
  double progress() const;  ///< [1], of finite bounces; of unlimited ones estimated by the error
  std::string phase() const;
  const std::string& why_done() const { return why_done_; }

  /// Grows when what is displayed has changed.
  uint32_t shown_sweeps() const { return shown_sweeps_; }

  // Per texel side, of its halves (SideAccessibility::halves()), over π and times accessibility, w accessibility:
  // direct, of later sweeps, and all that rays of pixels may look up (one bounce less).
  const TypedBuffer<float4>& shown_direct() const { return shown_direct_; }
  const TypedBuffer<float4>& shown() const { return shown_; }
  const TypedBuffer<float4>& held() const { return held_; }
  const SideHalves& halves() const { return halves_; }
  /// Of the last sweep that has ended, xyz irradiance over π; w: Σ ΔΩ a of the rays that met the side [sr].
  const TypedBuffer<float4>& last() const { return last_; }
  const TileMaps& maps() const { return maps_; }
  const TypedBuffer<uint32_t>& total() const { return cells_.total; }  ///< per cell, RGB9E5 times scale()
  const TypedBuffer<uint32_t>& direct() const { return cells_.direct; }
  bool split() const { return options_.split; }
  float scale() const { return scale_; }
  const FieldTail& tail() const { return tail_; }
  uint32_t sweeps() const { return sweep_; }  ///< transported
  struct Counts {
    uint64_t subfields = 0, kept_subfields = 0, cells_scattered = 0;
    double subfield_pixels = 0;
    size_t propagating_bytes = 0, rendering_bytes = 0;  ///< of cells with their index
  };
  Counts counts() const;
  void warm_up();
  /// What is displayed. A loaded field shows the same bits; it is not to be advanced.
  void save(StateWriter& chunks) const;
  void load(const StateReader& chunks);

  /// Device memory without cells [bytes], and of a cell while light propagates.
  static size_t estimate_bytes(size_t sides, uint32_t halves);
  static constexpr size_t kCellBytes = 16, kSplitBytes = 4;
  static constexpr int kKeptBounces = 3;  ///< so many at least: drawing twice to keep fragments pays
  /// Expected ends of rays of all subfields at texel sides. `pixel` [m]; `area`: of the sides [m²].
  static double estimate_ends(uint32_t dir_n, uint32_t perturb, double pixel, double area);
  /// That a preview draws, all of its sweeps together.
  static uint32_t estimate_preview_subfields(const Options& options);

 private:
  enum class Stage { preview, keep, survey, transport, scatter, done };
  void record_sides();
  void begin();
  void find_scale();
  bool run_subfield();
  uint32_t subfields_of_stage() const;
  uint32_t preview_bounces() const;  ///< 0: no preview
  void end_subfields();
  Stage stage_after_preview() const;
  void set_albedo(bool facets);  ///< facets reflect diffusely, too
  void choose_preview_lines();
  void end_preview_sweep();
  void show(const float4& tail, bool hold);
  void end_sweep();
  double scatter_tiles();  ///< the next ones; how many cells
  void finish_sweep(const Norms& norms);
  void end_propagation();
  bool is_last() const;
  Norms take_norms() const;

  KernelScheduler* scheduler_;
  const Scene* host_scene_;
  const SurfaceAtlas* atlas_;
  const Patches* patches_;
  Options options_;
  DirectionGrid grid_;
  TileMaps maps_;
  bool tiled_;
  SideHalves halves_;
  TypedBuffer<float4> light_samples_, albedo_, records_, direct_, indirect_, last_, shown_direct_, shown_, held_;
  TypedBuffer<float> shares_;
  TypedBuffer<float4> side_norms_, norms_;
  CellBuffers cells_;
  Program side_program_;
  Schedule emit_, fold_, show_;
  std::unique_ptr<SubfieldRuns> subfields_;  ///< null where nothing is propagated any more
  std::unique_ptr<CellScatter> scatter_;     ///< likewise, and where there are no cells
  Variable<uint32_t> fold_sweep_, show_hold_;
  Variable<float4> show_tail_;
  Stage stage_ = Stage::survey;
  bool begun_ = false;
  double work_left_ = 0;  ///< of an iteration that was cancelled [subfield pixels]
  uint32_t next_subfield_ = 0, sweep_ = 0, shown_sweeps_ = 0;
  std::vector<uint32_t> preview_subfields_;
  uint32_t preview_sweep_ = 0;  ///< sweeps of the preview that have ended
  float scale_ = 1;
  FieldTail tail_;
  std::string why_done_;
  Norms side_sums_{};
  Counts counts_;
};

/// What parameters decide of it; subfield and seeds are left to the caller.
LightField::Options field_options(const Plan& plan, const Parameters& parameters);

}  // namespace lucarium::vlf
