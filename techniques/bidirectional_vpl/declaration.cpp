// SPDX-License-Identifier: Apache-2.0
#include "bidirectional_vpl/declaration.h"

#include <algorithm>

#include "bidirectional_vpl/base/plan.h"
#include "bidirectional_vpl/effort/trials.h"
#include "bidirectional_vpl/iteration/parts.h"
#include "lucarium/base/error.h"

namespace lucarium::bidirectional {

namespace {

// Bounds of admitted_bias(), measured (docs/measurements/bidirectional_vpl.md, bias) or derived.
// Dependent directions.
constexpr double kSharedBias = 0.1;
// Pixels of rasterized bundles, over their number per axis: feet of bodies get too dark.
constexpr double kBundlePixelBias = 2;
// Clamped connections are those of paths of two bounces and more: rho^2 of all light in a room of reflectance rho = .7,
// of which a corner loses 39 % at 1 / m^2.
constexpr double kClampBias = 0.49 * 0.39;
// Lobes that are wider, cut or spread, of either sign: rough glass after 64 samples.
constexpr double kGlossBias = 0.25;
// Texels of maps, of either sign: edges of shadows. Of virtual lights' maps at 256 x 256.
constexpr double kMapBias = 0.02, kMapRes = 256;
// Filter and caches of a picture that rests, on diffuse surfaces: the filter mixes pixels of almost one plane.
constexpr double kFewSamplesBias = 0.01;

}  // namespace

TechniqueInfo technique_info() {
  TechniqueInfo info;
  info.name = "bidirectional_vpl";
  info.version = "1.0";
  info.summary = "bidirectional path tracing from virtual point lights, light samples and camera paths, joined by MIS";
  info.citation =
      "Y. Tokuyoshi and S. Ogaki, Real-Time Bidirectional Path Tracing via Rasterization, I3D 2012; I. Georgiev, J. "
      "Krivanek, T. Davidovic and P. Slusallek, Light Transport Simulation with Vertex Connection and Merging, "
      "SIGGRAPH "
      "Asia 2012";
  info.capabilities.lights = all_kinds<LightKind>();
  info.capabilities.materials = all_kinds<MaterialKind>();
  info.capabilities.changes = all_kinds<ChangeKind>();
  info.capabilities.pixel_sampling = {};
  for (uint32_t mode = 0; mode <= 16; ++mode) info.capabilities.pixel_sampling.push_back(mode);
  info.layers = {"emission", "direct", "indirect"};
  OptionalLayers strategies;
  strategies.parameters = "show_strategies=on";
  strategies.names = {"hit", "nee"};
  const BidirectionalParameters defaults;
  for (int s = 1; s <= defaults.light_vertices; ++s) strategies.names.push_back("vpl" + std::to_string(s));
  strategies.names.push_back("splat");
  OptionalLayers further;
  further.parameters = "show_strategies=on and as many light_vertices";
  for (int s = defaults.light_vertices + 1; s <= BidirectionalParameters::kMaxLightVertices; ++s)
    further.names.push_back("vpl" + std::to_string(s));
  info.optional_layers = {strategies, further};
  return info;
}

double admitted_bias(const BidirectionalParameters& parameters, double declared) {
  const bool bundles = parameters.directions != Directions::bsdf;
  const bool shared = parameters.directions == Directions::bundle && parameters.reuse == Reuse::shared;
  double bias = shared ? kSharedBias : declared;
  if (bundles && parameters.bundle_mode != BundleMode::rays && parameters.bundle_mode != BundleMode::exact)
    bias += kBundlePixelBias / parameters.bundle_res;
  if (parameters.two_bounce == TwoBounce::clamp) bias += kClampBias;
  if (parameters.gloss != Gloss::none) bias += kGlossBias;
  if (parameters.light_trace == LightTrace::rsm) bias += kMapBias;
  if (parameters.direct == Direct::maps) bias += kMapBias;
  if (parameters.vpl_visibility == VplVisibility::map) bias += kMapBias * kMapRes / parameters.map_res;
  if (parameters.caches || parameters.filter) bias += kFewSamplesBias;
  return bias;
}

bool may_be_ideal(const Scene& scene) {
  return std::any_of(scene.materials.begin(), scene.materials.end(), [](const SceneMaterial& material) {
    // Light samples and virtual lights find what rough glass passes on; a texture may lower the roughness.
    return material.roughness < LUCARIUM_MIRROR_ROUGHNESS || material.metallic_roughness_texture.texture >= 0;
  });
}

PathSet path_set(const BidirectionalParameters& parameters, const RenderSettings& settings) {
  PathSet set;
  set.max_bounces = settings.max_bounces;
  const Plan plan = make_plan(parameters, settings);
  if (parameters.strategy == Strategy::vpl || parameters.strategy == Strategy::splat) {
    set.direct = false;
    set.indirect = plan.light_vertices > 0;
  }
  if (parameters.strategy == Strategy::splat) set.max_bounces = std::max(static_cast<int>(plan.light_vertices) - 1, 0);
  if (parameters.strategy == Strategy::hit) set.point_lights = set.spot_lights = set.directional_lights = false;
  return set;
}

namespace {

bool has_lights(const Scene& scene, bool directional) {
  return std::any_of(scene.lights.begin(), scene.lights.end(),
                     [&](const SceneLight& light) { return directional || light.type != LightType::directional; });
}

/// Whether there may be something that shines and can be hit.
bool has_emitters(const Scene& scene) {
  return scene.environment ||
         std::any_of(scene.instances.begin(), scene.instances.end(), [&](const SceneInstance& instance) {
           return scene.materials[static_cast<size_t>(instance.material)].emits();
         });
}

void list_map_limitations(const Plan& plan, const BidirectionalParameters& parameters, const Scene& scene,
                          std::vector<std::string>& list) {
  const bool cubes = has_lights(scene, false);
  if (plan.light_vertices > 0 && plan.punctual_paths)
    list.push_back(has_lights(scene, true)
                       ? "lamps and the environment are left to camera paths (vpl_lights=punctual)"
                       : "there are no virtual lights: no point, spot or directional light (vpl_lights=punctual)");
  if (plan.direct_maps && cubes)
    list.push_back("shadows of point and spot lights are blurred over some texels of their maps (direct=maps)");
  if (plan.vpl_maps && (!plan.punctual_paths || has_lights(scene, true)))
    list.push_back(
        "light of virtual lights leaks past what is nearer to a surface than texels are wide "
        "(vpl_visibility=map)");
  if (!cubes && (plan.rsm || plan.direct_maps))
    list.push_back("light_trace=rsm and direct=maps have no effect: no point or spot light");
  if (parameters.vpl_visibility == VplVisibility::map && !plan.vpl_maps)
    list.push_back("vpl_visibility=map has no effect: nothing is connected to virtual lights");
}

/// Parameters that were set and that others, or the scene, leave without effect.
void list_idle_parameters(const Plan& plan, const BidirectionalParameters& parameters, const Scene& scene,
                          std::vector<std::string>& list) {
  const BidirectionalParameters usual;
  const char* const no_bundles = "camera paths take no bundles (directions)";
  const char* const no_paths = "there are no light paths (strategy, --max-bounces)";
  const char* const no_connections = "nothing is connected to virtual lights (strategy, --max-bounces)";
  const bool light_paths = plan.light_vertices > 0, own = parameters.vpl_choice == VplChoice::own;
  const bool few = parameters.vpl_choice == VplChoice::all || parameters.vpl_choice == VplChoice::pair;
  // As many light paths as bundles.
  const bool as_many_paths = light_paths && few && parameters.light_paths == 0;
  const struct {
    const char* name;
    bool is_set, has_effect;
    const char* reason;
  } all[] = {
      {"splat=off", !parameters.splat, parameters.strategy != Strategy::splat, "splats are all there is (strategy)"},
      {"light_vertices", parameters.light_vertices != usual.light_vertices, light_paths, no_paths},
      {"light_paths", parameters.light_paths > 0 && !own, light_paths, no_paths},
      {"light_paths", parameters.light_paths > 0 && own, false, "vpl_choice=own takes one per pixel"},
      {"vpl_choice", parameters.vpl_choice != usual.vpl_choice, light_paths, no_paths},
      {"vpl_lights=punctual", parameters.vpl_lights == VplLights::punctual, light_paths, no_paths},
      {"candidates", parameters.candidates != usual.candidates, plan.has_table(),
       "virtual lights are not compared (vpl_choice, strategy, --max-bounces)"},
      {"bundles", parameters.bundles != usual.bundles, plan.bundles || as_many_paths, no_bundles},
      {"dir_pdf", parameters.dir_pdf != usual.dir_pdf, plan.bundles, no_bundles},
      {"bundle_sides", parameters.bundle_sides != usual.bundle_sides, plan.bundles, no_bundles},
      {"dir_pdf=env", plan.bundles_follow_sky, scene.environment.has_value(), "there is no environment"},
      {"reuse", parameters.reuse != usual.reuse, plan.takes_several_bundles(),
       "no camera path takes several bundles (directions, --max-bounces)"},
      {"bundle_mode", parameters.bundle_mode != usual.bundle_mode, plan.bundles, no_bundles},
      {"bundle_res", parameters.bundle_res != usual.bundle_res, plan.stores_bundles(),
       "no bundles are rasterized (directions, bundle_mode)"},
      {"map_res", parameters.map_res != usual.map_res, parameters.vpl_visibility == VplVisibility::map,
       "virtual lights have no maps (vpl_visibility)"},
      {"g_max", parameters.g_max != usual.g_max, parameters.two_bounce != TwoBounce::mis,
       "connections are not clamped (two_bounce)"},
      {"m_prime", parameters.m_prime != usual.m_prime,
       parameters.gloss == Gloss::clamp || parameters.gloss == Gloss::roughness,
       "glossy lobes stay as they are (gloss)"},
      {"gloss=vsl", parameters.gloss == Gloss::vsl, plan.vpl, no_connections},
      {"two_bounce", parameters.two_bounce != usual.two_bounce, plan.vpl, no_connections},
      {"interleave", parameters.interleave > 1 && !plan.bundles && own, plan.filter,
       "every pixel has virtual lights of its own (vpl_choice=own)"},
      {"interleave", parameters.interleave > 1 && !plan.bundles && !own, plan.vpl || plan.filter, no_connections},
      {"direct=maps", parameters.direct == Direct::maps, plan.lights, "there are no light samples (strategy)"},
      {"light_choice=learned", parameters.light_choice == LightChoice::learned, light_paths, no_paths},
      {"light_trace=rsm", parameters.light_trace == LightTrace::rsm, light_paths, no_paths},
  };
  for (const auto& parameter : all)
    if (parameter.is_set && !parameter.has_effect)
      list.push_back(std::string(parameter.name) + " has no effect: " + parameter.reason);
}

}  // namespace

std::vector<std::string> limitations(const BidirectionalParameters& parameters, const Scene& scene,
                                     const RenderSettings& settings) {
  std::vector<std::string> list;
  const bool ideal = may_be_ideal(scene);
  if (ideal && !scene.lights.empty())
    list.push_back("point, spot and directional light that reaches a surface through a mirror or glass is left out");
  const Plan plan = make_plan(parameters, settings);
  if (parameters.strategy != Strategy::all && parameters.strategy != Strategy::hit && ideal)
    list.push_back("one strategy alone misses most light that mirrors and glass pass on (strategy)");
  if (parameters.strategy == Strategy::hit && !has_emitters(scene))
    list.push_back("strategy=hit finds nothing: there is no lamp and no environment");
  if (parameters.splat && parameters.strategy == Strategy::all && settings.pixel_sampling != LUCARIUM_PIXEL_JITTER)
    list.push_back("splat has no effect: light paths are connected to the camera with jittered pixels only");
  if (plan.two_bounce == TwoBounce::mis && plan.light_vertices > 0 &&
      static_cast<int>(plan.light_vertices) < parameters.light_vertices &&
      parameters.light_vertices != BidirectionalParameters().light_vertices)
    list.push_back("light_vertices is lowered to " + std::to_string(plan.light_vertices) +
                   ": paths of so few bounces have no more");
  list_map_limitations(plan, parameters, scene, list);
  list_idle_parameters(plan, parameters, scene, list);
  if (plan.takes_several_bundles() && parameters.reuse == Reuse::shared)
    list.push_back("reuse=shared is biased: deeper scatterings take directions that depend on the first");
  if (plan.takes_several_bundles() && parameters.reuse == Reuse::distinct && parameters.bundles < 2)
    list.push_back("reuse=distinct has nothing to choose from with one bundle (bundles)");
  if (plan.two_bounce != TwoBounce::mis && parameters.light_vertices > 1)
    list.push_back("light_vertices is lowered to 1 (two_bounce)");
  if (plan.two_bounce == TwoBounce::clamp && plan.settings.max_scatterings > 2)
    list.push_back("two_bounce=clamp is biased: corners lose light of two and more bounces");
  if (parameters.filter && parameters.interleave < 2)
    list.push_back("filter has no effect: its window is a tile of one pixel (interleave)");
  if (plan.filter && plan.shows_strategies) list.push_back("filter leaves the layers of strategies as they are");
  if (plan.caches && plan.shows_strategies)
    list.push_back("caches=on leaves indirect light from caches out of the layers of strategies");
  if (plan.caches) list.push_back("caches=on shows indirect light of up to four frames before");
  return list;
}

size_t estimate_bytes(const BidirectionalParameters& parameters, const Scene& scene, const RenderSettings& settings) {
  const Plan plan = make_plan(parameters, settings);
  return Parts::estimate_bytes(plan, scene) + (plan.guide && may_be_ideal(scene) ? GuidePhotons::estimate_bytes() : 0) +
         Trials::estimate_bytes(parameters, scene, settings);
}

void check_parameters(const BidirectionalParameters& parameters, const RenderSettings& settings) {
  const Plan plan = make_plan(parameters, settings);
  const size_t largest = std::max(8 * (plan.vertex_slots() + 264),
                                  size_t{plan.settings.pixels} * std::max(plan.layers(), plan.light_vertices));
  if (largest > UINT32_MAX)
    throw_error(ErrorClass::usage,
                "bidirectional_vpl: {} light paths of {} vertices for {}x{} pixels are too many; lower --size, "
                "light_paths or light_vertices",
                plan.settings.light_paths, plan.light_vertices, settings.width, settings.height);
  if (parameters.strategy == Strategy::splat && settings.pixel_sampling != LUCARIUM_PIXEL_JITTER)
    throw Error(ErrorClass::usage,
                "bidirectional_vpl: strategy=splat needs jittered pixels; set --pixel-sampling jitter");
  if (parameters.strategy == Strategy::splat && !plan.splat)
    throw Error(ErrorClass::usage,
                "bidirectional_vpl: strategy=splat finds nothing with one light vertex or without bounces; raise "
                "light_vertices to 2 and --max-bounces to 1");
  if (parameters.strategy == Strategy::vpl && !plan.vpl)
    throw Error(ErrorClass::usage,
                "bidirectional_vpl: strategy=vpl finds nothing without bounces; set --max-bounces 1");
}

}  // namespace lucarium::bidirectional
