// SPDX-License-Identifier: Apache-2.0
//
// virtual_light_field: light propagated along fixed directions, then walked through in constant time
// ---------------------------------------------------------------------------------------------------
//
// Idea. A fixed set of directions covers the sphere; along each of them lies a subfield of parallel rays through the
// whole scene, a parallel subfield. Light travels along all rays of a line at once, surface to surface, in both
// directions. Diffuse surfaces keep one irradiance per texel; mirrors and glossy surfaces keep a radiance map for every
// direction, in tiles that cover only the surface. When the light has settled, any view is a look-up (Mortensen, Khanna
// and Slater, Light Field Propagation and Rendering on the GPU, AFRIGRAPH 2007).
//
//   e_t = Σ_d ΔΩ_d Σ_r a_r L_r / Σ_d ΔΩ_d Σ_r a_r       irradiance over π of texel t, over all rays r that meet it
//   out_j(x) = k_s Σ_q b_q in_q(x) / Σ_q b_q            a mirror: q the three directions around the mirrored one
//   out_j(x) = a Σ_i g_i in_i(x) / Σ_i g_i              a glossy lobe: g_i = f(ω_i, ω_j) cos θ_i ΔΩ_i
//
// Sweeps. Sweep s transports the light that was scattered exactly s times, so that bounces are exact. The rest of
// unlimited bounces is a geometric series, whose ratio the last two sweeps show (scatter/field_tail.h).
//
// Error. Light in mirrors is blurred by the spacing of directions at every bounce; all light by cells and texels.
//
// Where the paper stands in the source (files below this folder; layered_raster/, texel_sides/ and surface_atlas/
// are in framework/lucarium/services and kernels/lucarium):
//
//   section 2.1, directions, parallel subfields (PSF)   directions/direction_grid.cpp: DirectionGrid(), make_lines()
//   section 2.1, world to canonical PSF (M_WC)          tiles/subfield_cells.clh: subfield_point()
//   section 2.1, tiles of cells, L_s (figure 3)         shared/field.h; tiles/subfield_cells.clh: subfield_radiance()
//   section 2.1, intersections of a ray in order        layered_raster/layered_raster.h: rows of sorted fragments
//   section 3.1, sparse tiles (figure 4)                tiles/build_maps.cl: mark_tiles()
//   section 3.1, locating a tile (figure 4)             tiles/subfield_cells.clh: find_cell()
//   section 2.1, a parallel subfield as an image        pixels/show_subfield.cl: show_subfield()
//   section 3.1, maps: current, next, total             tiles/cell_buffers.h: sent, incoming, total
//   section 3.2, senders and receivers (figure 5)       exchange/exchange_line.cl: layered_ray_crosses(): both ways at
//                                                       once, over fragments in depth order
//   section 3.2, sorted in advance                      exchange/exchange_line.cl: exchange_kept_line()
//   section 3.3, radiance interface (RI), transport     exchange/exchange_line.cl: receive(), field_end();
//                                                       scatter/fold_sides.cl: fold_sides()
//   section 3.3, diffuse reflectance K_d                field/light_field.cpp: transport_albedo()
//   section 3.3, skylight (figure 6)                    exchange/exchange_line.cl: layered_ray_begins(),
//                                                       layered_ray_ends()
//   section 3.4, non-diffuse scattering (figure 7)      scatter/scatter_cells.cl: scattered_light(); unshot radiance:
//                                                       cURM, nURM: tiles/cell_buffers.h: sent, incoming;
//                                                       scatter/splat_lobes.clh: splat_weight()
//   section 3.5, virtual directions                     directions/direction_grid.cpp: directions_about();
//                                                       exchange/perturbed_ends.clh: facet_sends(), add_to_cell()
//   section 4, rendering, barycentric weights           directions/direction_grid.clh: look_up_direction();
//                                                       tiles/field_lookup.clh: facet_radiance();
//                                                       pixels/shown_field.clh: add_shown()
//
// Not in the source: the painter's algorithm with Newell's sort, merging and BSP trees (section 3.2), since
// lucarium/services/layered_raster sorts the fragments of each pixel.
//
// Not in the paper: the tail, light samples (direct_mode=nee), rays from pixels (pixels/trace_lobes.cl), glossy lobes
// by gathers with normalised weights, patches that are not planar, accessibility (texel_sides/side_accessibility.h), a
// coarse field before the first sweep (field/field_preview.cpp), light kept apart of parts of texels close under glass
// (SideAccessibility::halves()).

#include <fmt/format.h>

#include "lucarium/base/numbers.h"
#include "lucarium/services/bvh/bvh.h"
#include "lucarium/services/surface_atlas/inspect.h"
#include "lucarium/technique/plugin.h"
#include "lucarium/technique/technique_base.h"
#include "lucarium/technique/technique_state.h"
#include "virtual_light_field/cost.h"
#include "virtual_light_field/declaration.h"
#include "virtual_light_field/field/field_surfaces.h"
#include "virtual_light_field/pixels/field_view.h"
#include "virtual_light_field/tiles/describe_tiles.h"

namespace lucarium {
namespace {

using namespace vlf;

/// A depth behind all of the scene, along any direction [m].
float depth_beyond(const Bounds& bounds) {
  return glm::length(0.5f * (bounds.min + bounds.max)) + 1.01f * bounds.radius() + 1e-3f;
}

class VirtualLightField : public TechniqueBase<Parameters> {
 public:
  PathSet path_set(const Scene& scene, const RenderSettings& settings) const override {
    return vlf::path_set(parameters_, scene, settings);
  }
  std::vector<std::string> limitations(const Scene& scene, const RenderSettings& settings) const override {
    return vlf::limitations(parameters_, scene, settings);
  }
  size_t estimate_bytes(const Scene& scene, const RenderSettings& settings) const override {
    return vlf::estimate_bytes(make_plan(parameters_, scene, settings), parameters_, scene, settings);
  }
  double estimate_seconds(const Scene& scene, const RenderSettings& settings,
                          const ComputePower& power) const override {
    return vlf::estimate_seconds(make_plan(parameters_, scene, settings), parameters_, scene, settings, power);
  }
  std::vector<ParameterSaving> savings(const Scene&, const RenderSettings&) const override { return vlf::savings(); }
  std::vector<std::pair<std::string, std::string>> endless() const override { return {{"camera_samples", "0"}}; }

  std::string state_refusal() const override { return {}; }
  std::vector<std::string> parameters_of_view() const override {
    return {"cache_visibility", "camera_samples", "eye_interp", "inspect_line", "preview"};
  }

  InspectedValues inspect(const SeenPoint& point) const override {
    if (!field_) return {};
    const SurfaceAtlas& atlas = surfaces_->atlas;
    const uint32_t side = side_at(atlas, point.triangle, point.b1, point.b2, point.front);
    auto rows = describe_side(atlas, side, field_->shown(), "irradiance of later bounces");
    for (auto& row : describe_tiles(field_->maps(), side)) rows.push_back(std::move(row));
    rows.emplace_back("sweeps so far", std::to_string(field_->sweeps()));
    return rows;
  }

  std::map<std::string, double> counters() const override {
    std::map<std::string, double> result;
    if (view_) result["lobe_rays"] = static_cast<double>(view_->rays());
    if (!field_) return result;
    const LightField::Counts counts = field_->counts();
    result["lines"] = static_cast<double>(counts.subfields);
    result["kept_lines"] = static_cast<double>(counts.kept_subfields);
    result["subfield_pixels"] = counts.subfield_pixels;
    result["cells"] = field_->maps().cells();
    result["cells_scattered"] = static_cast<double>(counts.cells_scattered);
    result["propagating_bytes"] = static_cast<double>(counts.propagating_bytes);
    result["rendering_bytes"] = static_cast<double>(counts.rendering_bytes);
    result["sweeps"] = field_->sweeps();
    result["facets"] = field_->maps().info().facets;
    result["sides"] = surfaces_->atlas.info().texel_count;
    return result;
  }

 protected:
  bool step() override {
    if (!propagate()) return false;
    if (is_eye_due()) {
      if (!view_->sample()) return false;
      view_->commit();
      eye_credit_ = 0;
    }
    stepped_ = false;
    return true;
  }

  IterationResult state() const override {
    IterationResult result;
    const bool settled = !field_ || field_->done() || light_held();
    const uint32_t shown = field_ && field_->shown_sweeps() > 0 ? view_->field_samples() : view_->samples();
    // A sample has all light: those before it lack some, and are no part of what --spp asks for.
    result.samples = settled ? shown : 0;
    result.visible = view_->samples() > 0;
    result.light_done = settled && !light_rests();
    const double seen = parameters_.camera_samples > 0 ? 1 : -1;  // without a limit: unknown
    result.progress = settled ? seen : lit() ? field_->progress() : 0;
    result.converged = result.light_done && parameters_.camera_samples > 0 &&
                       shown >= static_cast<uint32_t>(parameters_.camera_samples);
    result.phase = settled ? "walk" : lit() ? field_->phase() : "light";
    if (result.converged)
      result.phase = field_ ? fmt::format("{}, and {} camera_samples", field_->why_done(), parameters_.camera_samples)
                            : fmt::format("all {} camera_samples are done", parameters_.camera_samples);
    return result;
  }

  void write(Film& film) override { view_->resolve(film); }

  bool follow(const SceneChange& change) override {
    if (!built() || !change.only_camera()) return false;
    if (view_->fits(frame()))
      view_->set_frame(frame());
    else
      make_view();
    stepped_ = false;
    eye_credit_ = 0;
    return true;
  }

  void build() override {
    view_.reset();  // their memory first
    field_.reset();
    surfaces_.reset();
    check_parameters(parameters_, scene(), settings());
    plan_ = make_plan(parameters_, scene(), settings());
    if (parameters_.texels == 0)
      automatic_texels_ = plan_.atlas.texel_count = std::max(automatic_texels_, plan_.atlas.texel_count);
    if (!plan_.field) return;
    // The atlas that texels=0 chooses by the image's size is that of the state.
    if (context().state && parameters_.texels == 0) plan_.atlas.texel_count = saved_texels(*context().state);
    surfaces_ = std::make_unique<FieldSurfaces>(device(), scheduler(), scene(), scene_buffers(), bvh(), parameters_,
                                                plan_, context().progress);
    if (!context().state) surfaces_->measure(context().progress);  // else nothing will be propagated at first
  }

  /// Directions depend on the seed, and with them the tiles.
  void restart() override {
    view_.reset();
    field_.reset();
    stepped_ = false;
    runs_left_ = 0;
    eye_credit_ = 0;
    if (plan_.field) {
      if (!context().state) surfaces_->measure(context().progress);  // where a state that was loaded has spared it
      surfaces_->light.reset(seed());
      make_field();
    }
    make_view();
  }

  void save(StateWriter& chunks) override {
    if (!field_) return;
    chunks.put_value("texels", plan_.atlas.texel_count);
    field_->save(chunks);
  }
  void load(const StateReader& chunks) override {
    if (field_) field_->load(chunks);
  }

  void warm_up_kernels() override {
    if (surfaces_) surfaces_->light.warm_up();
    if (field_) field_->warm_up();
    view_->warm_up();
  }

 private:
  bool lit() const { return surfaces_->light.complete(); }

  /// Of the image's size, with no sample.
  void make_view() {
    view_.reset();  // its memory first
    FieldView::Options options = FieldView::make_options(plan_, parameters_);
    options.reach = depth_beyond(scene().bounds());
    view_ = std::make_unique<FieldView>(device(), scheduler(), scene_buffers(), bvh(),
                                        surfaces_ ? &surfaces_->atlas : nullptr,
                                        surfaces_ ? &surfaces_->patches : nullptr, field_.get(), frame(), options);
    view_->reset(seed());
  }

  void make_field() {
    LightField::Options options = field_options(plan_, parameters_);
    options.subfield = surfaces_->subfield;
    options.seed = full_seed();
    options.line_seed = seed();
    options.loaded = context().state != nullptr;
    field_ = std::make_unique<LightField>(device(), scheduler(), scene(), scene_buffers(), bvh(), surfaces_->atlas,
                                          surfaces_->patches, surfaces_->raster, surfaces_->interior,
                                          surfaces_->accessibility, surfaces_->light.light_samples(), options);
  }

  /// The part of the propagation of this iteration. False when cancelled; what is done is not done again.
  bool propagate() {
    if (!field_ || stepped_ || light_held()) return true;
    if (!lit()) {
      if (runs_left_ == 0) {
        runs_left_ = surfaces_->light.runs();
        eye_credit_ += light_seconds(runs_left_ * surfaces_->light.run_length());
      }
      for (; runs_left_ > 0 && !lit(); --runs_left_) {
        if (!surfaces_->light.sample()) return false;
        surfaces_->light.commit();
      }
      runs_left_ = 0;
    } else {
      const double drawn = field_->drawn_share();
      if (!field_->advance(kSubfieldPixels)) return false;
      eye_credit_ += subfield_seconds(kSubfieldPixels, drawn);
    }
    stepped_ = true;
    return true;
  }

  /// Until all light is there samples of pixels are kEyeShare of the work: what the image lacks most is light.
  bool is_eye_due() const {
    const bool settled = !field_ || field_->done() || light_held();
    const double eye = eye_seconds(frame().width * frame().height);
    return settled || view_->samples() == 0 || kEyeShare * (eye_credit_ + eye) >= eye ||
           view_->shown_sweeps() != field_->shown_sweeps();
  }

  static constexpr double kEyeShare = 0.25;
  static constexpr double kSubfieldPixels = 4e6;  ///< that light runs through in an iteration

  Plan plan_;
  uint64_t automatic_texels_ = 0;            ///< that texels=0 means: by the largest size that the image has had
  std::unique_ptr<FieldSurfaces> surfaces_;  ///< null where no light is propagated
  std::unique_ptr<LightField> field_;        ///< likewise
  std::unique_ptr<FieldView> view_;
  double eye_credit_ = 0;   ///< work of the propagation since the last sample of pixels [s of a core]
  bool stepped_ = false;    ///< the propagation of this iteration is done
  uint32_t runs_left_ = 0;  ///< of light samples, in an iteration that was cancelled
};

std::unique_ptr<Technique> create_virtual_light_field() { return std::make_unique<VirtualLightField>(); }

}  // namespace
}  // namespace lucarium

LUCARIUM_EXPORT_TECHNIQUE(lucarium::vlf::technique_info, lucarium::create_virtual_light_field)
