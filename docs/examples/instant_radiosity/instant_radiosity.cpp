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

#include "lucarium/base/seed.h"
#include "lucarium/services/bvh/bvh.h"
#include "lucarium/services/direct_light/direct_light.h"
#include "lucarium/services/gbuffer/gbuffer.h"
#include "lucarium/services/layer_sums/layer_sums.h"
#include "lucarium/services/light_at_points/light_at_points.h"
#include "lucarium/services/light_paths/light_paths.h"
#include "lucarium/technique/plugin.h"
#include "lucarium/technique/technique_base.h"

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
    v.number("lights", lights, 1, 4096, "paths/iteration", "light paths per iteration, each with one virtual light");
    v.number("max_geometry", max_geometry, 0.01f, 1e6f, "1/R²",
             "maximum geometry term of a virtual light; R is the scene's radius");
  }
};

// ---- what it can do

TechniqueInfo describe_technique() {
  TechniqueInfo info;
  info.name = owner;
  info.version = "1.0";
  info.summary = "direct light, and one bounce of indirect light by virtual point lights";
  info.citation = "A. Keller, Instant Radiosity, SIGGRAPH 1997";
  info.capabilities.lights = all_kinds<LightKind>();
  info.capabilities.materials = {MaterialKind::diffuse, MaterialKind::glossy, MaterialKind::mirror,
                                 MaterialKind::mask,    MaterialKind::blend,  MaterialKind::normal_map};
  info.capabilities.changes = all_kinds<ChangeKind>();
  info.capabilities.bias = 0.03;  // what the bound takes from corners
  info.layers = {"emission", "direct", "indirect"};
  return info;
}

// ---- code

class InstantRadiosity : public TechniqueBase<Options> {
 public:
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
    const auto lights = static_cast<uint32_t>(parameters_.lights);
    return GBuffer::estimate_bytes(settings.width, settings.height) + DirectLight::estimate_bytes(pixels) +
           LightPaths::estimate_bytes(lights) + lights * sizeof(VirtualLight) + LightAtPoints::estimate_bytes(pixels) +
           LayerSums::estimate_bytes(pixels, 3) + pixels * sizeof(float4);
  }

 protected:
  void compile() override {
    program_ = make_program(device(), instant_radiosity_kernels(), {"instant_radiosity/light_pixels"});
  }

  /// Everything that refers to the scene's buffers. Called again when they may have been replaced.
  void build() override {
    for (Schedule* schedule : {&paths_, &light_, &add_}) *schedule = {};  // before the memory that they refer to
    direct_light_.reset();
    gbuffer_.reset();
    gbuffer_ = std::make_unique<GBuffer>(device(), scheduler(), scene_buffers(), bvh(), frame(), owner);
    direct_light_ = std::make_unique<DirectLight>(device(), scheduler(), scene_buffers(), bvh(), owner);
    sums_ = LayerSums(device(), owner, pixels(), {"emission", "direct", "indirect"});
    reflected_ = TypedBuffer<float4>(device(), owner, "reflected light", pixels(), "lower --size");
    record_paths();
    record_light();
    record_add();
  }

  /// From zero samples, with the present camera and seed.
  void restart() override {
    gbuffer_->set_frame(frame());
    sums_.clear();
  }

  /// One sample per pixel, or none at all: false when cancelled, and the sums are then as before.
  bool step() override {
    const auto sample = static_cast<uint32_t>(samples());
    if (!gbuffer_->render(sample)) return false;
    paths_.set(run_, sample);
    paths_.set(path_seed_, seed());
    if (scheduler().run(paths_) == RunResult::cancelled) return false;
    const float radius = std::max(scene().bounds().radius(), 1e-6f);
    light_.set(max_geometry_, parameters_.max_geometry / (radius * radius));
    light_.set(light_seed_, indexed_seed(seed(), sample));
    for (uint32_t i = 0; i < virtual_lights_.count() && settings().max_bounces != 0; ++i) {
      light_.set(light_index_, i);
      if (scheduler().run(light_) == RunResult::cancelled) return false;
    }
    if (!direct_light_->accumulate_radiance(gbuffer_->points(), sums_["direct"], sample, seed())) return false;
    scheduler().run_to_end(add_);  // all sums hold the same samples, also after Ctrl-C
    return true;
  }

  void write(Film& film) override { sums_.write(film); }

  void warm_up_kernels() override {
    gbuffer_->warm_up();
    direct_light_->warm_up(gbuffer_->points(), sums_["direct"]);
    for (Schedule* schedule : {&paths_, &light_, &add_}) scheduler().warm_up(*schedule);
  }

 private:
  /// Virtual lights of a run, before their light is added.
  void record_paths() {
    const LightPathOptions options{.paths = static_cast<uint32_t>(parameters_.lights), .diffuse_only = true};
    const LightPaths paths(device(), scene_buffers(), bvh(), options, owner);
    virtual_lights_ = TypedBuffer<VirtualLight>(device(), owner, "virtual lights", paths.virtual_lights(0));
    ScheduleRecorder recorder = scheduler().record("virtual lights", owner);
    run_ = recorder.variable("run", 0u);
    path_seed_ = recorder.variable("seed", 0u);
    paths.record_virtual_lights(recorder, run_, path_seed_, virtual_lights_, 0, true);
    recorder.fill_zero("no reflected light", reflected_);
    paths_ = recorder.compile();
  }

  /// One virtual light at what all pixels see.
  void record_light() {
    const auto bind_points = [&](PassBuilder& pass) { pass.arg("points", gbuffer_->points()); };
    const auto bind_sums = [&](PassBuilder& pass) {
      pass.arg("seen", gbuffer_->points()).arg("reflected", reflected_);
    };
    const LightAtPoints light(device(), scene_buffers(), bvh(), program_, pixels(), bind_points, owner, "lower --size");
    ScheduleRecorder recorder = scheduler().record("virtual light", owner);
    light_index_ = recorder.variable("light", 0u);
    light_seed_ = recorder.variable("seed", 0u);
    max_geometry_ = recorder.variable("max_geometry", 0.f);
    light.record_virtual_light(recorder, virtual_lights_, light_index_, light_seed_, max_geometry_, bind_sums);
    light_ = recorder.compile();
  }

  void record_add() {
    ScheduleRecorder recorder = scheduler().record("add sample", owner);
    recorder.pass("add sample", program_, "add_layers")
        .global(pixels())
        .arg("points", gbuffer_->points())
        .arg("count", pixels())
        .arg("reflected", reflected_)
        .arg("emission", sums_["emission"])
        .arg("indirect", sums_["indirect"]);
    add_ = recorder.compile();
  }

  Program program_;
  std::unique_ptr<GBuffer> gbuffer_;
  std::unique_ptr<DirectLight> direct_light_;
  LayerSums sums_;
  TypedBuffer<VirtualLight> virtual_lights_;  ///< of an iteration
  TypedBuffer<float4> reflected_;             ///< their light of an iteration, per pixel [cd/m²]
  Schedule paths_, light_, add_;
  Variable<uint32_t> run_, path_seed_, light_index_, light_seed_;
  Variable<float> max_geometry_;  ///< [1/m²]
};

std::unique_ptr<Technique> create_technique() { return std::make_unique<InstantRadiosity>(); }

}  // namespace

LUCARIUM_EXPORT_TECHNIQUE(describe_technique, create_technique)
