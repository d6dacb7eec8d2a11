// SPDX-License-Identifier: Apache-2.0
//
// instant_radiosity: one bounce of indirect light by virtual lights
// -----------------------------------------------------------------
//
// Idea (Keller 1997). Light paths leave the lamps and meet surfaces at points y with flux Φ. What a diffuse surface of
// albedo ρ reflects there lights every other point x like a small lamp:
//
//   E(x) = Σ ρ Φ/π · G(x, y) V(x, y),   G = cos θ_x cos θ_y / |x − y|²
//
// so that the indirect light of all pixels takes one shadow ray per virtual light and pixel.
//
// What is counted. Layers `emission`, `direct` (light and BSDF samples, the service DirectLight), and `indirect`: one
// bounce off the diffuse lobes, reflected to the eye by the whole BSDF.
//
// Error. G grows without bound in corners. It is bounded by `max_geometry`, which loses light there; the rest is
// unbiased. Every iteration has virtual lights of its own.
#include <algorithm>

#include "lucarium/compute/program/source_library.h"
#include "lucarium/services/bvh/bvh.h"
#include "lucarium/services/direct_light/direct_light.h"
#include "lucarium/services/gbuffer/gbuffer.h"
#include "lucarium/services/light_at_points/light_at_points.h"
#include "lucarium/services/light_paths/light_paths.h"
#include "lucarium/technique/plugin.h"

const lucarium::EmbeddedSources& instant_radiosity_kernels();

namespace {
using namespace lucarium;

const char* const owner = "instant_radiosity";  // pays for the memory in the account of the device

// ---- options

struct Options {
  int lights = 16;
  float max_geometry = 100;

  template <class V>
  void describe(V& v) {
    v.number("lights", lights, 1, 4096, "paths/iteration", "virtual lights of an iteration");
    v.number("max_geometry", max_geometry, 0.01f, 1e6f, "1/R²",
             "upper bound of the geometry term, R the scene's radius");
  }
};

// ---- what it can do

TechniqueInfo describe_technique() {
  TechniqueInfo info;
  info.name = owner;
  info.version = "1.0";
  info.summary = "direct light, and one bounce of indirect light by virtual point lights";
  info.citation = "A. Keller, Instant Radiosity, SIGGRAPH 1997";
  info.capabilities.lights = {"point", "spot", "directional", "emissive", "environment"};
  info.capabilities.materials = {"diffuse", "glossy", "mirror", "mask", "blend", "normal_map"};
  info.capabilities.changes = {"camera", "transforms", "deformation", "materials", "lights", "topology"};
  info.capabilities.bias = 0.03;  // what the bound takes from corners
  info.layers = {"emission", "direct", "indirect"};
  return info;
}

// ---- code

class InstantRadiosity : public Technique {
 public:
  ParameterTable& parameters() override { return table_; }

  PathSet path_set(const Scene&, const RenderSettings& settings) const override {
    PathSet set;
    set.max_bounces = settings.max_bounces == 0 ? 0 : 1;
    set.indirect = set.max_bounces > 0;
    set.secondary_lambert_only = true;  // light paths see diffuse lobes alone
    set.light_delta = false;
    return set;
  }

  std::vector<std::string> limitations(const Scene&, const RenderSettings& settings) const override {
    std::vector<std::string> list = {"indirect light of corners is bounded (max_geometry)"};
    if (settings.max_bounces < 0 || settings.max_bounces > 1)
      list.push_back("it computes one bounce of indirect light");
    return list;
  }

  size_t estimate_bytes(const Scene&, const RenderSettings& settings) const override {
    const size_t pixels = size_t{settings.width} * settings.height;
    const auto lights = static_cast<uint32_t>(options_.lights);
    return GBuffer::estimate_bytes(settings.width, settings.height) + DirectLight::estimate_bytes(pixels) +
           LightPaths::estimate_bytes(lights) + lights * sizeof(VirtualLight) + LightAtPoints::estimate_bytes(pixels) +
           4 * pixels * sizeof(float4);
  }

  void prepare(const TechniqueContext& context) override {
    context_ = std::make_unique<TechniqueContext>(context);
    SourceLibrary library;
    library.add(instant_radiosity_kernels());
    program_ = Program(*context.device, library, {owner, {"instant_radiosity/light_pixels.cl"}, {}});
    build();
  }

  void update(const SceneChange& change) override {
    if (change.only_camera()) {
      restart();
    } else if (change.any()) {
      build();  // buffers of the scene and its hierarchy may have been replaced
    }
  }

  IterationResult iterate() override {
    if (add_sample()) ++samples_;
    IterationResult result;
    result.samples = samples_;
    result.progress = -1;  // how much there is to do is unknown
    result.phase = "virtual lights";
    return result;
  }

  void resolve(Film& film) override {
    context_->scheduler.finish();
    write_layer(film, "emission", emission_.download());
    write_layer(film, "direct", direct_.download());
    write_layer(film, "indirect", indirect_.download());
  }

  void reset(uint64_t seed) override {
    seed_ = seed;
    restart();
  }

  void warm_up() override {
    gbuffer_->warm_up();
    direct_light_->warm_up(gbuffer_->points(), direct_);
    for (Schedule* schedule : {&paths_, &light_, &add_}) context_->scheduler.warm_up(*schedule);
  }

 private:
  /// One sample per pixel, or none at all: false when cancelled, and the sums are then as before.
  bool add_sample() {
    KernelScheduler& scheduler = context_->scheduler;
    const auto sample = static_cast<uint32_t>(samples_);
    const uint32_t seed = kernel_seed(seed_);
    if (!gbuffer_->render(sample)) return false;
    paths_.set(run_, sample);
    paths_.set(path_seed_, seed);
    if (scheduler.run(paths_) == RunResult::cancelled) return false;
    light_.set(light_seed_, seed ^ (sample * 0x9e3779b9u));
    const float radius = std::max(context_->scene.bounds().radius(), 1e-6f);
    light_.set(max_geometry_, options_.max_geometry / (radius * radius));
    for (uint32_t i = 0; i < virtual_lights_.count() && context_->settings.max_bounces != 0; ++i) {
      light_.set(light_index_, i);
      if (scheduler.run(light_) == RunResult::cancelled) return false;
    }
    if (!direct_light_->accumulate_radiance(gbuffer_->points(), direct_, sample, seed)) return false;
    scheduler.run_to_end(add_);  // all sums hold the same samples, also after Ctrl-C
    return true;
  }

  /// Everything that refers to the scene's buffers.
  void build() {
    Device& device = *context_->device;
    const SceneBuffers& scene = context_->scene_buffers;
    const uint32_t pixels = context_->settings.width * context_->settings.height;
    for (Schedule* schedule : {&paths_, &light_, &add_}) *schedule = {};  // before the memory that they refer to
    direct_light_.reset();
    gbuffer_.reset();
    gbuffer_ = std::make_unique<GBuffer>(device, context_->scheduler, scene, context_->bvh(),
                                         make_frame(context_->settings), owner);
    direct_light_ = std::make_unique<DirectLight>(device, context_->scheduler, scene, context_->bvh(), owner);
    for (auto* sum : {&emission_, &direct_, &indirect_, &reflected_})
      *sum = TypedBuffer<float4>(device, owner, "sums", pixels, "lower --size");
    record_paths();
    record_light(pixels);
    record_add(pixels);
    reset(context_->settings.seed);
  }

  /// Virtual lights of a run, and no light of theirs yet.
  void record_paths() {
    Device& device = *context_->device;
    const LightPathOptions options{.paths = static_cast<uint32_t>(options_.lights), .diffuse_only = true};
    const LightPaths paths(device, context_->scene_buffers, context_->bvh(), options, owner);
    virtual_lights_ = TypedBuffer<VirtualLight>(device, owner, "virtual lights", paths.virtual_lights(0));
    ScheduleRecorder recorder = context_->scheduler.record("virtual lights", owner);
    run_ = recorder.variable("run", 0u);
    path_seed_ = recorder.variable("seed", 0u);
    paths.record_virtual_lights(recorder, run_, path_seed_, virtual_lights_, 0, true);
    recorder.fill_zero("no reflected light", reflected_);
    paths_ = recorder.compile();
  }

  /// One virtual light at what all pixels see.
  void record_light(uint32_t pixels) {
    const LightAtPoints light(
        *context_->device, context_->scene_buffers, context_->bvh(), program_, pixels,
        [&](PassBuilder& pass) { pass.arg("points", gbuffer_->points()); }, owner, "lower --size");
    ScheduleRecorder recorder = context_->scheduler.record("virtual light", owner);
    light_index_ = recorder.variable("light", 0u);
    light_seed_ = recorder.variable("seed", 0u);
    max_geometry_ = recorder.variable("max_geometry", 0.f);
    light.record_virtual_light(
        recorder, virtual_lights_, light_index_, light_seed_, max_geometry_,
        [&](PassBuilder& pass) { pass.arg("seen", gbuffer_->points()).arg("reflected", reflected_); });
    light_ = recorder.compile();
  }

  void record_add(uint32_t pixels) {
    ScheduleRecorder recorder = context_->scheduler.record("add sample", owner);
    recorder.pass("add sample", program_, "add_sample")
        .global(pixels)
        .arg("points", gbuffer_->points())
        .arg("count", pixels)
        .arg("reflected", reflected_)
        .arg("emission", emission_)
        .arg("indirect", indirect_);
    add_ = recorder.compile();
  }

  /// From zero samples, with the present camera and seed.
  void restart() {
    Frame frame = make_frame(context_->settings);
    frame.seed = kernel_seed(seed_);
    gbuffer_->set_frame(frame);
    samples_ = 0;
    for (auto* sum : {&emission_, &direct_, &indirect_}) sum->fill_zero();
  }

  void write_layer(Film& film, const char* name, const std::vector<float4>& sums) const {
    const float samples = static_cast<float>(std::max<uint64_t>(samples_, 1));
    FilmLayer& layer = film.layer(name, {"R", "G", "B"}, true);  // part of the sum that is the image
    for (size_t i = 0; i < sums.size(); ++i)
      for (size_t c = 0; c < 3; ++c) layer.pixels[3 * i + c] = (&sums[i].x)[c] / samples;
  }

  Options options_;
  ParameterTable table_ = make_parameter_table(options_);
  std::unique_ptr<TechniqueContext> context_;
  Program program_;
  std::unique_ptr<GBuffer> gbuffer_;
  std::unique_ptr<DirectLight> direct_light_;
  TypedBuffer<VirtualLight> virtual_lights_;          ///< of an iteration
  TypedBuffer<float4> emission_, direct_, indirect_;  ///< sums per pixel [cd/m²]
  TypedBuffer<float4> reflected_;                     ///< indirect light of an iteration [cd/m²]
  Schedule paths_, light_, add_;
  Variable<uint32_t> run_, path_seed_, light_index_, light_seed_;
  Variable<float> max_geometry_;  ///< [1/m²]
  uint64_t samples_ = 0, seed_ = 1;
};

std::unique_ptr<Technique> create_technique() { return std::make_unique<InstantRadiosity>(); }

}  // namespace

LUCARIUM_EXPORT_TECHNIQUE(describe_technique, create_technique)
