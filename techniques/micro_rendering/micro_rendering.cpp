// SPDX-License-Identifier: Apache-2.0
//
// micro_rendering: final gathering into importance-warped micro-buffers
// ---------------------------------------------------------------------
//
// Idea. What a surface point p reflects of the light of other surfaces,
//
//   L(p, w_o) = ∫ f(w_o, w_i) L_in(p, w_i) cosθ_i dw_i,
//
// is seen by rendering the scene from p into a tiny hemispherical image whose N = B² micro-pixels have equal shares of f
// cosθ, so that L = (ρ / N) Σ L_i (Ritschel et al., Micro-Rendering for Scalable, Parallel Final Gathering, SIGGRAPH Asia
// 2009, section 3). The scene is a hierarchy of discs: a node that is smaller than a micro-pixel is drawn as a point, what
// is too big even as a leaf is ray-cast.
//
// How. PointForest places points on surfaces and keeps the hierarchy; LeafLight puts light onto its leaves, over several
// bounces where asked; PixelGather gathers at the pixels of a G-buffer, sub-image by sub-image. `emission` and `direct`
// come from the framework's services, `indirect` is this technique's; with gather_env so is what `direct` has of the environment.
//
// What is counted. Light of all kinds by light samples at the points; behind the first visible non-mirror surface only
// diffuse lobes (with node_shading=dynamic glossy ones too, at the second) and no mirrors or glass. Paths of 2 … max_bounces + 1 counted scatterings are `indirect`.
//
// Error. Points stand for surfaces: light is smoothed over a leaf's disc, and visibility below a micro-pixel is
// approximate. Both vanish with more points and smaller cut_kappa; jitter is averaged over frames.

#include <algorithm>

#include "gather_pass.h"
#include "leaf_light.h"
#include "lucarium/base/log.h"
#include "lucarium/services/bvh.h"
#include "lucarium/services/direct_light.h"
#include "lucarium/services/gbuffer.h"
#include "lucarium/technique/plugin.h"
#include "pixel_gather.h"

const lucarium::EmbeddedSources& micro_rendering_kernels();

namespace lucarium {
namespace {

using namespace micro;

const char* const kName = "micro_rendering";

TechniqueInfo micro_rendering_info() {
  TechniqueInfo info;
  info.name = kName;
  info.version = "1.0";
  info.summary = "final gathering by rendering a hierarchy of discs into BRDF-warped micro-buffers";
  info.citation =
      "T. Ritschel, T. Engelhardt, T. Grosch, H.-P. Seidel, J. Kautz and C. Dachsbacher, Micro-Rendering for Scalable, "
      "Parallel Final Gathering, SIGGRAPH Asia 2009";
  info.capabilities.lights = {"point", "spot", "directional", "emissive", "environment"};
  info.capabilities.materials = {"diffuse", "glossy", "mirror", "refraction", "transmission", "mask", "blend", "normal_map"};
  info.capabilities.changes = {"camera", "transforms", "deformation", "materials", "lights", "topology"};
  info.capabilities.bias = 0.02;
  info.capabilities.pixel_sampling = {};
  for (uint32_t mode = 0; mode <= 16; ++mode) info.capabilities.pixel_sampling.push_back(mode);
  info.layers = {"emission", "direct", "indirect", "cut_level", "list_length", "node_visits", "upsampling_failed", "micro_buffer"};
  return info;
}

class MicroRendering : public Technique {
 public:
  ParameterTable& parameters() override { return table_; }

  PathSet path_set(const Scene&, const RenderSettings& settings) const override {
    PathSet set;
    set.max_bounces = bounces(settings);
    set.indirect = set.max_bounces > 0;
    set.light_delta = false;
    // Of several bounces only the last one before the eye's is glossy: no path set says so.
    const bool glossy_nodes = parameters_.node_shading == NodeShading::dynamic &&
                              !(parameters_.multibounce == MultiBounce::photon_map && parameters_.photon_direct);
    set.secondary_lambert_only = !glossy_nodes || set.max_bounces > 1;
    return set;
  }

  std::vector<std::string> limitations(const Scene& scene, const RenderSettings& settings) const override {
    std::vector<std::string> list;
    if (settings.max_bounces < 0) list.push_back(fmt::format("computes {} bounces (unlimited_bounces), not all", bounces(settings)));
    const bool ideal = std::any_of(scene.materials.begin(), scene.materials.end(), [](const SceneMaterial& m) {
      return m.transmission > 0 || m.roughness < LUCARIUM_MIRROR_ROUGHNESS;
    });
    if (parameters_.node_shading == NodeShading::dynamic && bounces(settings) > 1)
      list.push_back("node_shading=dynamic: beyond one bounce only the second vertex from the eye is glossy, only for light samples and virtual lights");
    if (parameters_.multibounce == MultiBounce::instant_radiosity && (bounces(settings) > 1 || parameters_.shows_virtual_lights()))
      list.push_back("virtual lights' geometry term is bounded by vpl_clamp: corners are too dark");
    if (parameters_.multibounce == MultiBounce::photon_map && (bounces(settings) > 1 || parameters_.photon_direct))
      list.push_back("the photon map blurs light over photon_k photons");
    if (parameters_.node_shading == NodeShading::dynamic && parameters_.multibounce == MultiBounce::photon_map && parameters_.photon_direct)
      list.push_back("node_shading=dynamic has no effect: photons stand for light samples (photon_direct=on)");
    if (parameters_.shows_virtual_lights()) list.push_back("final_gather=off: visible surfaces reflect indirect light by their diffuse lobes alone, and nothing is gathered");
    if (!parameters_.final_gather && !parameters_.shows_virtual_lights())
      list.push_back("final_gather=off has no effect without multibounce=instant_radiosity");
    if (parameters_.adaptive > 0 && parameters_.largest_edge() < parameters_.micro_size * 3 / 2)
      list.push_back(fmt::format("adaptive: larger micro-buffers have edges of {} micro-pixels, not {}", parameters_.largest_edge(), parameters_.micro_size * 3 / 2));
    if (parameters_.backface == Backface::cull)
      list.push_back("backs of single-sided surfaces let light through, which the reference's block (backface=cull)");
    if (ideal) list.push_back("mirrors and glass are seen by the eye alone: no caustics, no reflections in reflections of rough surfaces");
    return list;
  }

  size_t estimate_bytes(const Scene& scene, const RenderSettings& settings) const override {
    const size_t pixels = size_t{settings.width} * settings.height;
    size_t bytes = GBuffer::estimate_bytes(settings.width, settings.height) + DirectLight::estimate_bytes(pixels) + 3 * pixels * sizeof(float4);
    if (bounces(settings) == 0) return bytes;
    const PointForest::Size forest = PointForest::estimate(scene, forest_options());
    if (parameters_.shows_virtual_lights()) bytes += LightPaths::estimate_bytes(parameters_, pixels, bounces(settings) + 1);
    return bytes + forest.bytes + LeafLight::estimate_bytes(parameters_, forest.leaves, bounces(settings)) +
           PixelGather::estimate_bytes(settings.width, settings.height, parameters_, transmits(scene));
  }

  void prepare(const TechniqueContext& context) override {
    context_ = std::make_unique<TechniqueContext>(context);
    seed_ = context.settings.seed;
    SourceLibrary library;
    library.add(micro_rendering_kernels());
    program_ = Program(*context.device, library, {"micro_rendering/pixels", {"micro_rendering/micro_pixels.cl"}, {}});
    if (bounces(context.settings) > 0) {
      gather_ = GatherPass(*context.device, parameters_, GatherAt::pixels);
      if (bounces(context.settings) > 1 && parameters_.multibounce == MultiBounce::jacobi)
        node_gather_ = GatherPass(*context.device, parameters_, GatherAt::nodes);
    }
    make_anew();
    warn_of_details();
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
    result.phase = leaf_light_ && !virtual_lights_ && !leaf_light_->lit(frame_, kernel_seed(seed_)) ? "light" : "gather";
    return result;
  }

  void resolve(Film& film) override {
    if (!made_) throw Error(ErrorClass::input, "micro_rendering: the scene's last change could not be followed; nothing to show");
    context_->scheduler.finish();
    resolve_sum(film, "emission", emission_);
    resolve_sum(film, "direct", direct_);
    if (pixels_) pixels_->resolve(film);
  }

  void reset(uint64_t seed) override {
    seed_ = seed;
    if (!made_) return make_anew();
    gbuffer_->set_frame(frame());
    restart();
  }

  void warm_up() override {
    if (!made_) make_anew();
    gbuffer_->warm_up();
    direct_light_->warm_up(gbuffer_->points(), frame_direct_);
    context_->scheduler.warm_up(direct_schedule_);
    if (leaf_light_) leaf_light_->warm_up();
    if (pixels_) pixels_->warm_up();
    if (virtual_lights_) virtual_lights_->warm_up();
  }

  std::map<std::string, double> counters() const override {
    std::map<std::string, double> all = counted();
    if (!forest_) return all;
    all["points"] = forest_->leaf_count();
    all["share of points on fine details"] = forest_->fine_details();
    all["trees"] = static_cast<double>(forest_->trees().size());
    all["sampling seconds"] = forest_->sampling_seconds();
    all["tree seconds"] = forest_->ordering_seconds();
    all["tree update seconds"] = forest_->updating_seconds();
    return all;
  }

 private:
  /// Whether some surface is rough and lets light through.
  static bool transmits(const Scene& scene) {
    return std::any_of(scene.materials.begin(), scene.materials.end(), [](const SceneMaterial& m) { return m.transmission > 0 && m.roughness >= LUCARIUM_MIRROR_ROUGHNESS; });
  }

  void follow(const SceneChange& change) {
    if (!change.any()) return;
    if (!made_) return make_anew();
    if (change.only_camera()) {
      gbuffer_->set_frame(frame());
      restart();
      return;
    }
    const bool rebuilt = forest_ && !forest_->update(change);
    if (change.topology) moved_.clear(), moving_.clear();  // instances may have other numbers
    if (rebuilt) {
      posed_ = !change.topology && (posed_ || forest_->loosened());
      // What a program moves once gives the picture of a fresh start. What it moves again gets a tree of its own, so that
      // the next move is one of its matrix.
      for (const int instance : change.moved_instances) {
        std::vector<int>& list = holds(moved_, instance) ? moving_ : moved_;
        if (!holds(list, instance)) list.push_back(instance);
      }
      make_forest();
    }
    if (rebuilt || transmits(context_->scene) != transmits_ || scene_generation_ != context_->scene_buffers.generation() || bvh_generation_ != context_->bvh().generation()) {
      make_passes();
      return;
    }
    if (change.camera) gbuffer_->set_frame(frame());
    if (leaf_light_) leaf_light_->changed(change.geometry() || !change.materials.empty());
    restart();
  }

  static bool holds(const std::vector<int>& list, int value) { return std::find(list.begin(), list.end(), value) != list.end(); }

  int bounces(const RenderSettings& settings) const {
    return settings.max_bounces < 0 ? parameters_.unlimited_bounces : settings.max_bounces;
  }

  ForestOptions forest_options() const {
    ForestOptions options;
    options.points_log2 = parameters_.points_log2;
    options.disc_scale = parameters_.disc_scale;
    options.all_cullable = parameters_.backface == Backface::cull;
    options.moving = moving_;
    options.posed = posed_;
    if (context_) options.progress = context_->progress;
    return options;
  }

  Frame frame() const {
    Frame frame = make_frame(context_->settings);
    frame.seed = kernel_seed(seed_);
    return frame;
  }

  /// Above this share of points on fine details indirect light was seen to err by more than the declared bias.
  static constexpr double kMostFineDetails = 0.06;

  void warn_of_details() const {
    if (!forest_ || forest_->fine_details() <= kMostFineDetails) return;
    log_warning("micro_rendering: {:.0f} % of the points are on details finer than their discs: indirect light may be off by several "
                "per cent; raise points_log2, or compare with a reference", 100 * forest_->fine_details());
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
    if (bounces(context_->settings) == 0) return;
    drop_gathers();  // what refers to memory goes before the memory
    for (bool again = true; again;) {
      forest_.reset();
      forest_ = std::make_unique<PointForest>(*context_->device, context_->scheduler, context_->scene, context_->scene_buffers,
                                              forest_options(), kName);
      again = !posed_ && forest_->loosened();
      posed_ = posed_ || again;
    }
  }

  /// Everything that is recorded over the buffers of scene and hierarchy.
  void make_passes() {
    Device& device = *context_->device;
    KernelScheduler& scheduler = context_->scheduler;
    const SceneBuffers& scene = context_->scene_buffers;
    const RenderSettings& settings = context_->settings;
    made_ = false;
    transmits_ = transmits(context_->scene);
    direct_schedule_ = {};
    drop_gathers();
    direct_light_.reset();
    gbuffer_.reset();
    gbuffer_ = std::make_unique<GBuffer>(device, scheduler, scene, context_->bvh(), frame(), kName);
    const bool gathers_sky = forest_ && parameters_.gather_env;
    const uint32_t kinds = gathers_sky ? DirectLight::kAllLights & ~(1u << LUCARIUM_LIGHT_ENVIRONMENT) : DirectLight::kAllLights;
    direct_light_ = std::make_unique<DirectLight>(device, scheduler, scene, context_->bvh(), kName, kinds);
    const uint32_t pixels = settings.width * settings.height;
    if (!emission_) {  // the size of an image never changes
      emission_ = TypedBuffer<float4>(device, kName, "emission", pixels, "lower --size");
      direct_ = TypedBuffer<float4>(device, kName, "direct light", pixels, "lower --size");
      frame_direct_ = TypedBuffer<float4>(device, kName, "direct light of a frame", pixels, "lower --size");
    }
    ScheduleRecorder recorder = scheduler.record("add emission and direct light", kName);
    recorder.pass("add emission and direct light", program_, "mr_add_direct").global(pixels).local(64)
        .arg("points", gbuffer_->points()).arg("count", pixels).arg("frame_direct", frame_direct_).arg("emission", emission_)
        .arg("direct", direct_);
    direct_schedule_ = recorder.compile();
    if (forest_) {
      leaf_light_ = std::make_unique<LeafLight>(device, scheduler, context_->scene, scene, context_->bvh(), *forest_, node_gather_, parameters_,
                                                bounces(settings), kName);
      pixels_ = std::make_unique<PixelGather>(device, scheduler, scene, gbuffer_->points(), settings.width, settings.height,
                                              *forest_, gather_, leaf_light_->shading(), parameters_, transmits_, kName);
      if (parameters_.shows_virtual_lights()) {
        virtual_lights_ = std::make_unique<LightPaths>(device, scheduler, context_->scene, scene, context_->bvh(), *forest_, parameters_, bounces(settings) + 1,
                                                       pixels_->irradiance(), leaf_light_->shading(), kName, &gbuffer_->points());
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
    emission_.fill_zero();
    direct_.fill_zero();
    if (pixels_) pixels_->restart();
  }

  /// Light of the frame at the points, worth batch_gathers gathers at most. False when cancelled or when some is missing.
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
    if (batch_ == 0 && !gbuffer_->render(frame_)) return false;
    if (virtual_lights_ ? batch_ == 0 && !show_virtual_lights(seed) : pixels_ && !pixels_->gather(batch_, frame_, seed)) return false;
    if (batch_ == 0) {
      context_->scheduler.finish();
      frame_direct_.fill_zero();
      const auto samples = static_cast<uint32_t>(parameters_.direct_samples);
      for (uint32_t s = 0; s < samples; ++s)
        if (!direct_light_->accumulate_radiance(gbuffer_->points(), frame_direct_, frame_ * samples + s, seed)) return false;
      context_->scheduler.run_to_end(direct_schedule_);
    }
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

  static void resolve_sum(Film& film, const char* name, const TypedBuffer<float4>& sums) {
    FilmLayer& layer = film.layer(name, {"R", "G", "B"}, true);
    const std::vector<float4> values = sums.download();
    for (size_t i = 0; i < values.size(); ++i) {
      const float scale = values[i].w > 0 ? 1 / values[i].w : 0;
      for (size_t c = 0; c < 3; ++c) layer.pixels[3 * i + c] = scale * (&values[i].x)[c];
    }
  }

  MicroParameters parameters_;
  ParameterTable table_ = make_parameter_table(parameters_);
  std::unique_ptr<TechniqueContext> context_;
  uint64_t seed_ = 1;
  bool made_ = false;        ///< forest and passes are whole and those of the present scene
  bool posed_ = false;       ///< a deformation has loosened a tree
  std::vector<int> moved_;   ///< instances that have been moved though no animation does it
  std::vector<int> moving_;  ///< those that were moved again, and have trees of their own
  uint32_t frame_ = 0, batch_ = 0;
  bool transmits_ = false;
  uint64_t scene_generation_ = 0, bvh_generation_ = 0;
  std::map<std::string, double> counted_before_;
  Program program_;
  GatherPass gather_, node_gather_;
  std::unique_ptr<PointForest> forest_;
  std::unique_ptr<GBuffer> gbuffer_;
  std::unique_ptr<DirectLight> direct_light_;
  std::unique_ptr<LeafLight> leaf_light_;
  std::unique_ptr<PixelGather> pixels_;
  std::unique_ptr<LightPaths> virtual_lights_;  ///< with final_gather=off
  TypedBuffer<float4> emission_, direct_, frame_direct_;  ///< xyz sum, w samples
  Schedule direct_schedule_;
};

std::unique_ptr<Technique> create_micro_rendering() { return std::make_unique<MicroRendering>(); }

}  // namespace
}  // namespace lucarium

LUCARIUM_EXPORT_TECHNIQUE(lucarium::micro_rendering_info, lucarium::create_micro_rendering)
