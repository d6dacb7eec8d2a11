// SPDX-License-Identifier: Apache-2.0
//
// micro_rendering: final gathering into importance-warped micro-buffers
// ---------------------------------------------------------------------
//
// Idea. What a surface point p reflects of the light of other surfaces,
//
//   L(p, w_o) = ∫ f(w_o, w_i) L_in(p, w_i) cosθ_i dw_i,
//
// is seen by rendering the scene from p into a tiny hemispherical image whose N = B² micro-pixels have equal shares of
// f cosθ, so that L = (ρ / N) Σ L_i (Ritschel et al., Micro-Rendering for Scalable, Parallel Final Gathering, SIGGRAPH
// Asia 2009, section 2.3). The scene is a hierarchy of discs: a node that is smaller than a micro-pixel is drawn as a
// point, what is too big even as a leaf is ray-cast.
//
// How. PointForest places points on surfaces and keeps the hierarchy; LeafLight puts light onto its leaves, over
// several bounces where asked; PixelGather gathers at the pixels of a G-buffer, sub-image by sub-image. `emission` and
// `direct` come from the framework's services, `indirect` is this technique's; with gather_env so is what `direct` has
// of the environment. A frame of gathers is dear and a sample of a pixel cheap, so that frames end with further samples
// of emission and direct light: as many as lower the error of the image most for all work, by the variances measured of
// both (eye_share).
//
// What is counted. Light of all kinds by light samples at the points; behind the first visible non-mirror surface only
// diffuse lobes (with node_shading=dynamic glossy ones too, at the second) and no mirrors or glass. Paths of 2 …
// max_bounces + 1 counted scatterings are `indirect`.
//
// Error. Points stand for surfaces: light is smoothed over a leaf's disc, and visibility below a micro-pixel is
// approximate. Both vanish with more points and smaller cut_kappa; jitter is averaged over frames.
//
// Where the paper stands in the source (files below this folder; light_at_points/ and light_paths/ are in
// framework/lucarium/services):
//
//   section 2.1, point generation            points/point_sampling.cpp: sample_surface() (best candidates)
//   section 2.1, figure 2, complete tree     tree/tree_order.cpp: split()
//   section 2.1, spheres, cones of normals   tree/refit_nodes.cl: merge_spheres(), merge_cones()
//   section 2.1, skip-pointers               gather/micro_gather.clh: draw_tree() (MICRO_LANES 1; else a stack);
//                                            light/list_node_gathers.cl: behind_subtree()
//   section 2.1, deforming geometry          tree/update_leaves.cl: update_leaves(); tree/refit_nodes.cl: refit_nodes()
//   section 2.2, point hierarchy cut         gather/micro_cut.clh: cut_lanes(), advance_cut()
//   section 2.2, selection criterion         gather/micro_solid_angle.clh: lanes_sphere_is_big():
//                                            Ω_i > Ω(Φ⁻¹(ω_i)), solid angle of node against micro-pixel
//   section 2.2, depth test                  gather/micro_pixels.clh: cover_pixels(); project_nodes()
//   section 2.2, on-demand ray casting       gather/micro_splat.clh: cast_discs(), cast_disc(); the post-traversal list
//                                            is filled by gather/micro_cut.clh: advance_cut()
//   section 2.2, convolution                 gather/micro_gather.clh: micro_light()
//   section 2.3, Φ                           gather/micro_warp.clh: lanes_warp()
//   section 2.3, Φ⁻¹                         gather/micro_warp.clh: lanes_unwarp()
//   section 2.3, M⁻¹ and C⁻¹ in tables       gather/micro_table.clh: finish_table(), direction_from_table(),
//                                            table_square() (warp=table)
//   section 2.3, ρ, sum scaled by ρ          gather/micro_warp.clh: sample_weights(); the sum:
//                                            gather/micro_gather.clh: micro_light()
//   section 2.4, bilateral upsampling        pixels/upsample_gathers.cl: upsample_gathers()
//   section 3.1, node of 128 bits            shared/micro_types.h; tree/micro_node.clh: pack_node()
//   section 3.2, one thread per gather       gather/micro_gather.cl: gather_light()
//   section 3.2, 3D Morton order             pixels/list_gathers.cl: make_gather_keys();
//                                            pixels/gather_keys.clh: morton_of()
//   section 4, one bounce                    light/light_points.cl: light_point();
//                                            light/pull_radiance.cl: pull_radiance()
//   section 4, instant radiosity             light_paths/virtual_light.clh: virtual_light_at()
//   section 4, radiosity, Jacobi, push-pull  light/list_node_gathers.cl: list_cut_gathers();
//                                            light/push_irradiance.cl: push_irradiance(); light/pull_radiance.cl:
//                                            pull_radiance(); the iteration: light/leaf_light.cpp
//   section 4, photon mapping                light_at_points/photon_density.clh: photon_density_at_points()
//
// Not in the paper: the conservative cut (gather/micro_solid_angle.clh), splats tested at samples and hole filling
// (gather/micro_splat.clh, gather/micro_gather.clh: is_hole()), discs bounded by their triangles' edges
// (gather/micro_splat.clh: clip_disc()) and splats by the edges of their surface (tree/refit_nodes.cl: merge_lines()),
// faces parted at edges (tree/tree_order.cpp: has_two_faces()), hidden points (points/point_visibility.h), sheets
// (tree/tree_order.cpp: find_sheet()), the error-driven cut (gather/micro_gather.clh: tolerate_error()), analytic GGX
// maps (gather/micro_warp.clh: lanes_ggx_from_disk()) and rough transmission (pixels/add_indirect_light.cl:
// transmitted_light()).

#include "lucarium/services/bvh/bvh.h"
#include "lucarium/services/eye_light/eye_light.h"
#include "lucarium/technique/plugin.h"
#include "lucarium/technique/technique_base.h"
#include "micro_rendering/cost.h"
#include "micro_rendering/declaration.h"
#include "micro_rendering/eye_balance.h"
#include "micro_rendering/gather/gather_pass.h"
#include "micro_rendering/light/leaf_light.h"
#include "micro_rendering/pixels/pixel_gather.h"
#include "micro_rendering/tree/scene_forest.h"

namespace lucarium {
namespace {

using namespace micro;

const char* const kName = "micro_rendering";
constexpr int kMovingStep = 4;                  // of gathers, in pixels, while the camera moves
constexpr uint32_t kFurtherSamples = 1u << 20;  // number of the first one, behind all those of frames

class MicroRendering : public TechniqueBase<MicroParameters> {
 public:
  PathSet path_set(const Scene&, const RenderSettings& settings) const override {
    return micro::path_set(parameters_, settings);
  }

  std::vector<std::string> limitations(const Scene& scene, const RenderSettings& settings) const override {
    return micro::limitations(parameters_, scene, settings);
  }

  size_t estimate_bytes(const Scene& scene, const RenderSettings& settings) const override {
    return micro::estimate_bytes(parameters_, scene, settings);
  }

  double estimate_seconds(const Scene& scene, const RenderSettings& settings,
                          const ComputePower& power) const override {
    return micro::estimate_seconds(parameters_, scene, settings, power);
  }

  std::vector<ParameterSaving> savings(const Scene&, const RenderSettings&) const override { return micro::savings(); }

  void prepare(const TechniqueContext& context) override {
    TechniqueBase::prepare(context);
    if (forest_) forest_->warn_of_details();
  }

  std::map<std::string, double> counters() const override {
    std::map<std::string, double> all = counted();
    if (!forest_ || !forest_->get()) return all;
    const PointForest& forest = *forest_->get();
    all["points"] = forest.leaf_count();
    all["share of points on fine details"] = forest.fine_details();
    all["share of hidden surface"] = forest.hidden();
    all["trees"] = static_cast<double>(forest.trees().size());
    all["sampling seconds"] = forest.sampling_seconds();
    all["tree seconds"] = forest.ordering_seconds();
    all["tree update seconds"] = forest.updating_seconds();
    return all;
  }

 protected:
  // ---- a frame: light at the points, a G-buffer, gathers at its pixels

  /// One batch of gathers; before the first of a frame the G-buffer; behind the last, one by one, further samples of
  /// pixels. True when it ends a frame. Where light at the points takes several iterations, the first frame's direct
  /// light comes with the first of them: there is something to see then.
  bool step() override {
    if (light_rests() && !virtual_lights_) return see_moving();
    if (further_left_ > 0) return see_further() && further_left_ == 0;
    if (!light_points()) return false;
    if (!points_lit()) {
      if (frame_index() == 0) see_directly();
      return false;
    }
    if (!gather_batch()) return false;
    seen_ = false;
    batch_ = (batch_ + 1) % batches();
    if (batch_ > 0) return false;
    if (balance_) balance_->frame_added();
    further_left_ = further_samples(frame_index() + 1, false);
    return further_left_ == 0;
  }

  IterationResult state() const override {
    IterationResult result = TechniqueBase::state();
    result.visible = batch_ > 0 || seen_ || further_left_ > 0;
    result.phase = further_left_ > 0 ? "direct light" : points_lit() ? "gather" : "light";
    return result;
  }

  void write(Film& film) override {
    eye_light_->write(film);
    if (pixels_) pixels_->resolve(film, parameters_.gather_step > 1);
  }

  void restart() override {
    batch_ = further_left_ = further_ = 0;
    seen_ = false;
    if (!fits_view()) make_view();
    eye_light_->set_frame(frame());
    if (!pixels_) return;
    pixels_->set_camera(frame().camera);
    pixels_->restart();
    if (balance_) balance_->clear();
  }

  // ---- what is made for a scene

  void compile() override {
    if (bounces() == 0) return;
    gather_ = GatherPass(device(), parameters_, GatherAt::pixels);
    if (bounces() > 1 && parameters_.multibounce == MultiBounce::jacobi)
      node_gather_ = GatherPass(device(), parameters_, GatherAt::nodes);
    forest_ = std::make_unique<SceneForest>(context(), parameters_, kName);
  }

  bool follow(const SceneChange& change) override {
    if (TechniqueBase::follow(change)) return true;  // the camera alone
    const bool forest_follows = !forest_ || forest_->follow(change);
    keeps_forest_ = built() && forest_follows;
    if (!keeps_forest_ || transmits(scene()) != transmits_ || buffers_replaced()) return false;
    keeps_forest_ = false;
    if (leaf_light_) leaf_light_->changed(change.geometry() || !change.materials.empty());
    restart_samples();
    return true;
  }

  void build() override {
    drop_gathers();  // what refers to memory goes before the memory
    eye_light_.reset();
    const bool keeps_forest = std::exchange(keeps_forest_, false);
    if (forest_ && !keeps_forest) forest_->make();
    transmits_ = transmits(scene());
    if (forest_)
      leaf_light_ = std::make_unique<LeafLight>(device(), scheduler(), scene(), scene_buffers(), bvh(), *forest_->get(),
                                                node_gather_, parameters_, bounces(), kName);
    make_view();
  }

  void warm_up_kernels() override {
    eye_light_->warm_up();
    if (leaf_light_) leaf_light_->warm_up();
    if (pixels_) pixels_->warm_up();
    if (virtual_lights_) virtual_lights_->warm_up();
    if (balance_) balance_->warm_up();
  }

 private:
  int bounces() const { return micro::bounces(parameters_, settings()); }
  uint32_t batches() const { return pixels_ ? pixels_->batches() : 1; }
  uint32_t frame_index() const { return static_cast<uint32_t>(samples()); }

  /// Whether the points have the light of this frame. With gather_visible=off they need none.
  bool points_lit() const { return !leaf_light_ || virtual_lights_ || leaf_light_->lit(frame_index(), seed()); }

  /// Light of the frame at the points, worth batch_gathers gathers at most: some may be missing. False when cancelled.
  bool light_points() {
    for (double work = 0; !points_lit() && work < parameters_.batch_gathers; work += leaf_light_->last_work())
      if (!leaf_light_->step(frame_index(), seed())) return false;
    return true;
  }

  /// Emission and direct light of a frame before its gathers, unless they are there. When cancelled the sums are as
  /// before.
  void see_directly() {
    const uint32_t index = frame_index();
    if (seen_ || !eye_light_->see(index) || !eye_light_->sample(index)) return;
    commit_eye_light();
    seen_ = true;
  }

  /// Emission and direct light of one more sample of each pixel. False when cancelled: the sums are as before.
  bool see_further() {
    const uint32_t index = kFurtherSamples + further_;
    if (!eye_light_->see(index) || !eye_light_->sample(index)) return false;
    commit_eye_light();
    ++further_;
    further_left_ = further_samples(frame_index() + 1, true);
    return true;
  }

  void commit_eye_light() {
    eye_light_->commit();
    if (balance_) balance_->eye_added();
  }

  /// Samples of pixels that are still to follow the gathers of this frame; `frames`: with it.
  uint32_t further_samples(uint32_t frames, bool begun) const {
    if (balance_) return balance_->further_samples(frames, parameters_, scene(), settings());
    if (light_rests() || !pixels_) return 0;
    return begun ? further_left_ - 1 : eye_samples_per_frame(parameters_, scene(), settings()) - 1;
  }

  /// One batch of a frame, before its first one G-buffer and direct light. False when cancelled: the sums are as
  /// before.
  bool gather_batch() {
    const uint32_t index = frame_index();
    const bool first = batch_ == 0 && !seen_;
    if (first && !eye_light_->see(index)) return false;
    if (virtual_lights_ ? !show_virtual_lights() : pixels_ && !pixels_->gather(batch_, index, seed())) return false;
    if (first && !eye_light_->sample(index)) return false;
    if (first) commit_eye_light();
    if (pixels_) pixels_->add(batch_, index);
    return true;
  }

  /// A frame for a camera that moves, in the light that points have, of whatever frame; until they have any, direct
  /// light alone. False when cancelled: the sums are as before.
  bool see_moving() {
    const uint32_t index = frame_index();
    const bool gathers = pixels_ && leaf_light_->shines();
    if (!eye_light_->see(index) || (gathers && !pixels_->gather(0, index, seed())) || !eye_light_->sample(index))
      return false;
    eye_light_->commit();
    if (gathers) pixels_->add(0, index);
    return true;
  }

  /// The light of all virtual lights at the pixels, once a frame. False when cancelled.
  bool show_virtual_lights() {
    if (batch_ > 0) return true;
    scheduler().finish();
    pixels_->irradiance().fill_zero();
    if (!virtual_lights_->trace(frame_index(), seed())) return false;
    for (uint32_t part = 0; part < virtual_lights_->parts(); ++part)
      if (!virtual_lights_->add(part)) return false;
    return true;
  }

  bool fits_view() const {
    return eye_light_ && view_width_ == settings().width && view_height_ == settings().height &&
           view_moves_ == light_rests();
  }

  /// All that depends on the image's size. What was there goes before.
  void make_view() {
    if (pixels_)
      for (const auto& [name, count] : pixels_->counters()) counted_before_[name] += count;
    balance_.reset();
    virtual_lights_.reset();
    pixels_.reset();
    eye_light_.reset();
    view_width_ = settings().width;
    view_height_ = settings().height;
    view_moves_ = light_rests();
    make_eye_light();
    if (forest_) make_gathers(*forest_->get());
  }

  /// While the camera moves few pixels gather, and all others are interpolated from them.
  MicroParameters view_parameters() const {
    MicroParameters parameters = parameters_;
    if (!light_rests() || parameters.shows_virtual_lights()) return parameters;
    parameters.gather_step = std::max(parameters.gather_step, kMovingStep);
    parameters.upsample_fail = 0;
    return parameters;
  }

  void make_eye_light() {
    const bool gathers_sky = forest_ && parameters_.gather_env;
    const uint32_t kinds =
        gathers_sky ? DirectLight::kAllLights & ~(1u << LUCARIUM_LIGHT_ENVIRONMENT) : DirectLight::kAllLights;
    eye_light_ = std::make_unique<EyeLight>(device(), scheduler(), scene_buffers(), bvh(), frame(), kName, kinds,
                                            static_cast<uint32_t>(parameters_.direct_samples));
  }

  void make_gathers(const PointForest& forest) {
    pixels_ = std::make_unique<PixelGather>(
        device(), scheduler(), scene_buffers(), eye_light_->points(), settings().width, settings().height, forest,
        gather_, leaf_light_->shading(), view_parameters(), transmits_, eye_light_->deviations(), kName);
    if (parameters_.eye_share < 0 && !view_moves_)
      balance_ = std::make_unique<EyeBalance>(device(), scheduler(), *eye_light_, *pixels_, kName);
    if (parameters_.shows_virtual_lights())
      virtual_lights_ = std::make_unique<PathLight>(device(), scheduler(), scene(), scene_buffers(), bvh(), forest,
                                                    parameters_, bounces() + 1, pixels_->irradiance(),
                                                    TypedBuffer<MicroLeafLight>(), kName, &eye_light_->points());
  }

  void drop_gathers() {
    counted_before_ = counted();
    balance_.reset();
    virtual_lights_.reset();
    pixels_.reset();
    leaf_light_.reset();
  }

  /// What was counted since prepare(), also by passes that are gone.
  std::map<std::string, double> counted() const {
    std::map<std::string, double> all = counted_before_;
    if (pixels_)
      for (const auto& [name, count] : pixels_->counters()) all[name] += count;
    // Of the picture, since restart().
    all["eye samples"] = static_cast<double>(samples() + further_ + (seen_ || batch_ > 0 || further_left_ > 0 ? 1 : 0));
    if (leaf_light_) all["gathers at nodes"] += static_cast<double>(leaf_light_->gathers());
    return all;
  }

  uint32_t batch_ = 0;                         ///< of the frame, the next one
  bool seen_ = false;                          ///< see_directly() is done, the gathers are not begun
  uint32_t further_left_ = 0, further_ = 0;    ///< samples of pixels behind the frame's gathers; all since restart()
  bool transmits_ = false;                     ///< some surface is rough and lets light through
  uint32_t view_width_ = 0, view_height_ = 0;  ///< of the image that eye_light_ and pixels_ were made for
  bool view_moves_ = false;                    ///< they were made for a camera that moves
  bool keeps_forest_ = false;                  ///< build() follows a change that the forest could follow
  std::map<std::string, double> counted_before_;
  GatherPass gather_, node_gather_;
  std::unique_ptr<SceneForest> forest_;  ///< null without indirect light
  std::unique_ptr<EyeLight> eye_light_;
  std::unique_ptr<LeafLight> leaf_light_;
  std::unique_ptr<PixelGather> pixels_;
  std::unique_ptr<EyeBalance> balance_;        ///< null where eye_share is given, and for a camera that moves
  std::unique_ptr<PathLight> virtual_lights_;  ///< with gather_visible=off
};

std::unique_ptr<Technique> create_micro_rendering() { return std::make_unique<MicroRendering>(); }

}  // namespace
}  // namespace lucarium

LUCARIUM_EXPORT_TECHNIQUE(lucarium::micro::technique_info, lucarium::create_micro_rendering)
