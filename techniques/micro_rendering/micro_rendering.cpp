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
// Asia 2009, section 3). The scene is a hierarchy of discs: a node that is smaller than a micro-pixel is drawn as a
// point, what is too big even as a leaf is ray-cast.
//
// How. PointForest places points on surfaces and keeps the hierarchy; LeafLight puts light onto its leaves, over
// several bounces where asked; PixelGather gathers at the pixels of a G-buffer, sub-image by sub-image. `emission` and
// `direct` come from the framework's services, `indirect` is this technique's; with gather_env so is what `direct` has
// of the environment.
//
// What is counted. Light of all kinds by light samples at the points; behind the first visible non-mirror surface only
// diffuse lobes (with node_shading=dynamic glossy ones too, at the second) and no mirrors or glass. Paths of 2 …
// max_bounces + 1 counted scatterings are `indirect`.
//
// Error. Points stand for surfaces: light is smoothed over a leaf's disc, and visibility below a micro-pixel is
// approximate. Both vanish with more points and smaller cut_kappa; jitter is averaged over frames.

#include "lucarium/services/bvh/bvh.h"
#include "lucarium/technique/plugin.h"
#include "micro_rendering/declaration.h"
#include "micro_rendering/gather/gather_pass.h"
#include "micro_rendering/light/leaf_light.h"
#include "micro_rendering/pixels/eye_light.h"
#include "micro_rendering/pixels/pixel_gather.h"
#include "micro_rendering/tree/scene_forest.h"

namespace lucarium {
namespace {

using namespace micro;

const char* const kName = "micro_rendering";

class MicroRendering : public Technique {
 public:
  ParameterTable& parameters() override { return table_; }

  PathSet path_set(const Scene&, const RenderSettings& settings) const override {
    return micro::path_set(parameters_, settings);
  }

  std::vector<std::string> limitations(const Scene& scene, const RenderSettings& settings) const override {
    return micro::limitations(parameters_, scene, settings);
  }

  size_t estimate_bytes(const Scene& scene, const RenderSettings& settings) const override {
    return micro::estimate_bytes(parameters_, scene, settings);
  }

  void prepare(const TechniqueContext& context) override {
    context_ = std::make_unique<TechniqueContext>(context);
    seed_ = context.settings.seed;
    if (bounces() > 0) {
      gather_ = GatherPass(*context.device, parameters_, GatherAt::pixels);
      if (bounces() > 1 && parameters_.multibounce == MultiBounce::jacobi)
        node_gather_ = GatherPass(*context.device, parameters_, GatherAt::nodes);
      forest_ = std::make_unique<SceneForest>(*context_, parameters_, kName);
    }
    make_anew();
    if (forest_) forest_->warn_of_details();
  }

  /// Interrupted while points are placed anew it leaves that to the next iterate(): there is nothing to show.
  void update(const SceneChange& change) override {
    try {
      follow(change);
    } catch (const Error& error) {
      if (error.error_class() != ErrorClass::interrupted) throw;
    }
  }

  IterationResult iterate() override {
    if (!made_) make_anew();  // the last attempt failed
    if (light() && step()) {
      ++batch_;
      if (!pixels_ || batch_ == pixels_->batches()) batch_ = 0, ++frame_;
    }
    IterationResult result;
    result.progress = -1;
    result.samples = frame_;
    result.visible = batch_ > 0;
    result.phase =
        leaf_light_ && !virtual_lights_ && !leaf_light_->lit(frame_, kernel_seed(seed_)) ? "light" : "gather";
    return result;
  }

  void resolve(Film& film) override {
    if (!made_)
      throw Error(ErrorClass::input, "micro_rendering: the scene's last change could not be followed; nothing to show");
    context_->scheduler.finish();
    eye_light_->resolve(film);
    if (pixels_) pixels_->resolve(film);
  }

  void reset(uint64_t seed) override {
    seed_ = seed;
    if (!made_) return make_anew();
    eye_light_->set_frame(frame());
    restart();
  }

  void warm_up() override {
    if (!made_) make_anew();
    eye_light_->warm_up();
    if (leaf_light_) leaf_light_->warm_up();
    if (pixels_) pixels_->warm_up();
    if (virtual_lights_) virtual_lights_->warm_up();
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

 private:
  void follow(const SceneChange& change) {
    if (!change.any()) return;
    if (!made_) {
      if (forest_) forest_->follow(change);
      return make_anew();
    }
    if (change.only_camera()) {
      eye_light_->set_frame(frame());
      restart();
      return;
    }
    const bool rebuilt = forest_ && !forest_->follow(change);
    if (rebuilt) make_forest();
    if (rebuilt || transmits(context_->scene) != transmits_ ||
        scene_generation_ != context_->scene_buffers.generation() || bvh_generation_ != context_->bvh().generation()) {
      make_passes();
      return;
    }
    if (change.camera) eye_light_->set_frame(frame());
    if (leaf_light_) leaf_light_->changed(change.geometry() || !change.materials.empty());
    restart();
  }

  int bounces() const { return micro::bounces(parameters_, context_->settings); }

  Frame frame() const {
    Frame frame = make_frame(context_->settings);
    frame.seed = kernel_seed(seed_);
    return frame;
  }

  void make_anew() {
    make_forest();
    make_passes();
  }

  /// What was counted since prepare(), also by passes that are gone.
  std::map<std::string, double> counted() const {
    std::map<std::string, double> all = counted_before_;
    if (pixels_)
      for (const auto& [name, count] : pixels_->counters()) all[name] += count;
    if (leaf_light_) all["gathers at nodes"] += static_cast<double>(leaf_light_->gathers());
    return all;
  }

  void drop_gathers() {
    counted_before_ = counted();
    virtual_lights_.reset();
    pixels_.reset();
    leaf_light_.reset();
  }

  void make_forest() {
    made_ = false;
    if (!forest_) return;
    drop_gathers();  // what refers to memory goes before the memory
    forest_->make();
  }

  /// Everything that is recorded over the buffers of scene and hierarchy.
  void make_passes() {
    Device& device = *context_->device;
    KernelScheduler& scheduler = context_->scheduler;
    const SceneBuffers& scene = context_->scene_buffers;
    const RenderSettings& settings = context_->settings;
    made_ = false;
    transmits_ = transmits(context_->scene);
    drop_gathers();
    eye_light_.reset();
    const bool gathers_sky = forest_ && parameters_.gather_env;
    const uint32_t kinds =
        gathers_sky ? DirectLight::kAllLights & ~(1u << LUCARIUM_LIGHT_ENVIRONMENT) : DirectLight::kAllLights;
    eye_light_ = std::make_unique<EyeLight>(device, scheduler, scene, context_->bvh(), frame(), kinds,
                                            static_cast<uint32_t>(parameters_.direct_samples), kName);
    if (forest_) {
      const PointForest& forest = *forest_->get();
      leaf_light_ = std::make_unique<LeafLight>(device, scheduler, context_->scene, scene, context_->bvh(), forest,
                                                node_gather_, parameters_, bounces(), kName);
      pixels_ =
          std::make_unique<PixelGather>(device, scheduler, scene, eye_light_->points(), settings.width, settings.height,
                                        forest, gather_, leaf_light_->shading(), parameters_, transmits_, kName);
      if (parameters_.shows_virtual_lights()) {
        virtual_lights_ = std::make_unique<LightPaths>(device, scheduler, context_->scene, scene, context_->bvh(),
                                                       forest, parameters_, bounces() + 1, pixels_->irradiance(),
                                                       leaf_light_->shading(), kName, &eye_light_->points());
      }
    }
    scene_generation_ = scene.generation();
    bvh_generation_ = context_->bvh().generation();
    restart();
    made_ = true;
  }

  void restart() {
    context_->scheduler.finish();
    frame_ = batch_ = 0;
    if (pixels_) pixels_->set_camera(frame().camera);
    eye_light_->restart();
    if (pixels_) pixels_->restart();
  }

  /// Light of the frame at the points, worth batch_gathers gathers at most. False when cancelled or when some is
  /// missing.
  bool light() {
    const uint32_t seed = kernel_seed(seed_);
    double work = 0;
    while (leaf_light_ && !virtual_lights_ && !leaf_light_->lit(frame_, seed)) {
      if (work > 0 && work >= parameters_.batch_gathers) return false;
      if (!leaf_light_->step(frame_, seed)) return false;
      work += leaf_light_->last_work();
    }
    return true;
  }

  /// One batch of a frame, before its first one G-buffer. False when cancelled: the sums are as before.
  bool step() {
    const uint32_t seed = kernel_seed(seed_);
    if (batch_ == 0 && !eye_light_->see(frame_)) return false;
    if (virtual_lights_ ? batch_ == 0 && !show_virtual_lights(seed) : pixels_ && !pixels_->gather(batch_, frame_, seed))
      return false;
    if (batch_ == 0 && !eye_light_->add(frame_)) return false;
    if (pixels_) pixels_->add(batch_, frame_);
    return true;
  }

  /// The light of all virtual lights at the pixels. False when cancelled.
  bool show_virtual_lights(uint32_t seed) {
    context_->scheduler.finish();
    pixels_->irradiance().fill_zero();
    if (!virtual_lights_->trace(frame_, seed)) return false;
    for (uint32_t part = 0; part < virtual_lights_->parts(); ++part)
      if (!virtual_lights_->add(part)) return false;
    return true;
  }

  MicroParameters parameters_;
  ParameterTable table_ = make_parameter_table(parameters_);
  std::unique_ptr<TechniqueContext> context_;
  uint64_t seed_ = 1;
  bool made_ = false;  ///< forest and passes are whole and those of the present scene
  uint32_t frame_ = 0, batch_ = 0;
  bool transmits_ = false;
  uint64_t scene_generation_ = 0, bvh_generation_ = 0;
  std::map<std::string, double> counted_before_;
  GatherPass gather_, node_gather_;
  std::unique_ptr<SceneForest> forest_;  ///< null without indirect light
  std::unique_ptr<EyeLight> eye_light_;
  std::unique_ptr<LeafLight> leaf_light_;
  std::unique_ptr<PixelGather> pixels_;
  std::unique_ptr<LightPaths> virtual_lights_;  ///< with final_gather=off
};

std::unique_ptr<Technique> create_micro_rendering() { return std::make_unique<MicroRendering>(); }

}  // namespace
}  // namespace lucarium

LUCARIUM_EXPORT_TECHNIQUE(lucarium::micro::technique_info, lucarium::create_micro_rendering)
