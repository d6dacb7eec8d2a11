// SPDX-License-Identifier: Apache-2.0
//
// path_tracing: unidirectional path tracing, and the reference of every comparison
// --------------------------------------------------------------------------------
//
// Idea. Follow light backwards from the eye. At every vertex x of a path with throughput T,
//
//   L += T · w_l · f(x, ω_l) · L_e · |cos| / p_l(ω_l)      one light sample ω_l, if nothing blocks it
//   T *= f(x, ω) · |cos| / p(ω)                            one BSDF sample ω, along which the path goes on
//   L += T · w_b · L_e                                     when ω hits an emitter
//
// This is the rendering equation, L = L_e + ∫ f L_i |cos| dω (Kajiya, The Rendering Equation, SIGGRAPH 1986,
// equation 1), expanded into a sum over paths. w_l and w_b are the power heuristic with β = 2 (Veach and Guibas,
// Optimally Combining Sampling Techniques, SIGGRAPH 1995, section 3.3; Veach 1997, chapter 9), so that both strategies
// may find the same emitter; punctual lights can only be sampled (w_l = 1), and after a mirror or ideal refraction
// emitters can only be hit (w_b = 1).
//
// What is counted. A path with n counted scatterings adds to the layer `emission` (n = 0), `direct` (n = 1) or
// `indirect` (n ≥ 2). Ideal mirrors and ideal refraction between the eye and the first other vertex are free; every
// other scattering counts; crossings of MASK and BLEND surfaces never do. max_bounces limits n to max_bounces + 1.
//
// How. PathIntegrator (lucarium/services/path_integrator/path_integrator.h) does the work in batches of at most
// batch_paths paths: all rays of one bounce are traced together, then all vertices shaded, then all shadow rays traced.
// This file only says which paths.
//
// Where it stands in the source (below framework/lucarium/services and kernels/lucarium):
//
//   rendering equation, one vertex   path_integrator/shade_surface.cl: shade_hit(), sample_lights(),
//                                    and sample_direction()
//   power heuristic                  mis.clh: power_heuristic(); path_integrator/shade_surface.cl: hit_weight();
//                                    direct_light/light_strategies.clh
//   choice of a light                light_tree.clh: choose_light_at(); lights.clh: choose_light()
//   visible normals of GGX           ggx.clh: sample_ggx_visible_normal()
//   Russian roulette                 path_integrator/shade_surface.cl: sample_direction()
//   Owen-scrambled Sobol points      sobol.clh
//
// Error. With replicates R > 1 the samples form R independent sets, and the layer `Variance` is s²/R of their means.
// Within a set Owen-scrambled Sobol points are used, whose own variance says nothing about the error.
//
// Limits. Punctual light through a mirror or glass is found by no strategy and is left out; shadow rays take glass as
// opaque. Caustics of small emitters are found by hits only and are noisy. Nothing is clamped unless asked.

#include <algorithm>

#include "lucarium/services/bvh/bvh.h"
#include "lucarium/services/path_integrator/path_integrator.h"
#include "lucarium/technique/plugin.h"
#include "lucarium/technique/technique_base.h"

namespace lucarium {
namespace {

// ---- options

struct PathTracingParameters {
  PathIntegratorOptions options;

  template <class V>
  void describe(V& v) {
    v.choice(
        "estimator", options.estimator,
        {{"mis", PathEstimator::mis},
         {"balance", PathEstimator::mis_balance},
         {"nee", PathEstimator::nee_only},
         {"bsdf", PathEstimator::bsdf_only}},
        "how light of surfaces and the environment is found: light samples (nee), BSDF samples (bsdf), or both by the "
        "power heuristic (mis) or the balance heuristic (balance)");
    v.choice("sampler", options.sampler, {{"sobol", PathSampler::sobol}, {"random", PathSampler::random}},
             "Owen-scrambled Sobol points, or independent random numbers");
    v.choice("light_choice", options.light_choice,
             {{"tree", LightChoice::tree}, {"power", LightChoice::power}, {"uniform", LightChoice::uniform}},
             "probability of sampling a light: by what it may send to the lit point (tree; up to four lights of one "
             "kind by power), by its power, or uniform");
    v.flag("roulette", options.roulette, "end paths by Russian roulette");
    v.number("roulette_start", options.roulette_start, 0, 4096, "scatterings",
             "counted scatterings before Russian roulette begins");
    v.number("replicates", options.replicates, 1, 64, "",
             "independent sample sets; two or more give the error per pixel (layer Variance)");
    v.number("samples_per_iteration", options.samples_per_iteration, 1, 4096, "samples/pixel",
             "samples per pixel and iteration");
    v.number("batch_paths", options.batch_paths, 1024, 1 << 22, "paths",
             "maximum paths in flight; memory grows with it");
    describe_path_set(v);
    v.basic({"estimator", "replicates", "samples_per_iteration", "batch_paths", "roulette", "roulette_start",
             "indirect_clamp"});
  }

  // The defaults are all paths; the reference of a comparison sets what the technique under test leaves out.
  template <class V>
  void describe_path_set(V& v) {
    PathSet& set = options.path_set;
    v.flag("emission", set.emission, "compute the layer emission");
    v.flag("direct", set.direct, "compute the layer direct");
    v.flag("indirect", set.indirect, "compute the layer indirect");
    v.flag("point_lights", set.point_lights, "include point lights");
    v.flag("spot_lights", set.spot_lights, "include spot lights");
    v.flag("directional_lights", set.directional_lights, "include directional lights");
    v.flag("emissive_triangles", set.emissive_triangles, "include emissive surfaces");
    v.flag("environment", set.environment, "include the environment");
    v.number("eye_deltas", set.eye_deltas, -1, PathSet::kMaxEyeDeltas, "events",
             "maximum mirrors and ideal refractions between the eye and the first other surface; -1: unlimited");
    v.flag("light_delta", set.light_delta, "include mirrors and ideal refraction behind the first counted scattering");
    v.flag("secondary_lambert_only", set.secondary_lambert_only,
           "keep only diffuse lobes behind the first non-delta vertex");
    v.flag("geometric_normals", set.geometric_normals, "shade with geometric normals instead of shading normals");
    v.flag("blend", set.blend, "cross BLEND surfaces at random by their alpha; off: they are opaque");
    v.number("indirect_clamp", set.indirect_clamp, 0.0, 1e30, "cd/m²",
             "maximum indirect light of one sample, which causes a bias; 0: no maximum");
  }
};

// ---- what it reads and writes

TechniqueInfo path_tracing_info() {
  TechniqueInfo info;
  info.name = "path_tracing";
  info.version = "1.0";
  info.summary = "unidirectional path tracing with light sampling and multiple importance sampling";
  info.citation =
      "J. T. Kajiya, The Rendering Equation, SIGGRAPH 1986; E. Veach and L. J. Guibas, Optimally Combining Sampling "
      "Techniques for Monte Carlo Rendering, SIGGRAPH 1995";
  info.capabilities.lights = all_kinds<LightKind>();
  info.capabilities.materials = all_kinds<MaterialKind>();
  info.capabilities.changes = all_kinds<ChangeKind>();
  info.capabilities.pixel_sampling = {};
  for (uint32_t mode = 0; mode <= 16; ++mode) info.capabilities.pixel_sampling.push_back(mode);
  info.layers = {"emission", "direct", "indirect", "Variance"};
  return info;
}

// ---- code

class PathTracing : public TechniqueBase<PathTracingParameters> {
 public:
  PathSet path_set(const Scene&, const RenderSettings& settings) const override {
    PathSet set = parameters_.options.path_set;
    set.max_bounces = settings.max_bounces;
    return set;
  }

  std::vector<std::string> limitations(const Scene& scene, const RenderSettings&) const override {
    const bool ideal = std::any_of(scene.materials.begin(), scene.materials.end(), [](const SceneMaterial& material) {
      return material.transmission > 0 || material.roughness < LUCARIUM_MIRROR_ROUGHNESS;
    });
    if (!ideal || scene.lights.empty()) return {};
    return {"point, spot and directional light that reaches a surface through a mirror or glass is left out"};
  }

  size_t estimate_bytes(const Scene&, const RenderSettings& settings) const override {
    return PathIntegrator::estimate_bytes(settings.width, settings.height, parameters_.options);
  }

  std::map<std::string, double> counters() const override {
    return integrator_ ? integrator_->counters() : std::map<std::string, double>();
  }

 protected:
  void build() override {
    integrator_.reset();  // its memory first
    PathIntegratorOptions options = parameters_.options;
    options.path_set = path_set(scene(), settings());
    integrator_ = std::make_unique<PathIntegrator>(device(), scheduler(), scene_buffers(), bvh(), frame(), options,
                                                   "path_tracing");
  }

  void restart() override {
    integrator_->set_frame(frame());
    integrator_->reset(full_seed());
  }

  bool follow(const SceneChange& change) override {
    if (!built() || buffers_replaced()) return false;
    if (!change.only_camera()) integrator_->follow_scene();
    restart_samples();
    return true;
  }

  bool step() override { return integrator_->iterate(); }

  IterationResult state() const override {
    IterationResult result = TechniqueBase::state();
    result.samples = integrator_->samples();
    result.phase = "trace";
    return result;
  }

  void write(Film& film) override { integrator_->resolve(film); }
  void warm_up_kernels() override { integrator_->warm_up(); }

 private:
  std::unique_ptr<PathIntegrator> integrator_;
};

std::unique_ptr<Technique> create_path_tracing() { return std::make_unique<PathTracing>(); }

}  // namespace
}  // namespace lucarium

LUCARIUM_EXPORT_TECHNIQUE(lucarium::path_tracing_info, lucarium::create_path_tracing)
