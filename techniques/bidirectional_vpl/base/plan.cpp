// SPDX-License-Identifier: Apache-2.0
#include "bidirectional_vpl/base/plan.h"

#include <algorithm>

#include "lucarium/shared/path_settings.h"

namespace lucarium::bidirectional {

namespace {

constexpr uint32_t kPixelsPerLightPath = 8;

/// Vertices of a light path that some strategy can use: of K scatterings connections leave one to the camera path,
/// splats none.
uint32_t useful_vertices(uint32_t wanted, uint32_t max_scatterings, bool vpl, bool splat) {
  const uint32_t limit = splat ? max_scatterings : max_scatterings - 1;
  if (max_scatterings < 2 || (!vpl && wanted < 2)) return 0;
  return std::min(wanted, limit);
}

}  // namespace

std::vector<std::string> Plan::strategy_names() const {
  if (!shows_strategies) return {};
  std::vector<std::string> names = {"hit", "nee"};
  for (uint32_t s = 1; s <= light_vertices; ++s) names.push_back("vpl" + std::to_string(s));
  names.push_back("splat");
  return names;
}

Effort whole_effort(const BidirectionalParameters& parameters) {
  return {true, parameters.splat, parameters.light_vertices, parameters.camera_edges};
}

Plan make_plan(const BidirectionalParameters& parameters, const RenderSettings& settings) {
  return make_plan(parameters, settings, whole_effort(parameters));
}

Plan make_plan(const BidirectionalParameters& parameters, const RenderSettings& settings, const Effort& effort) {
  Plan plan;
  BidirectionalSettings& s = plan.settings;
  const bool all = parameters.strategy == Strategy::all;
  s.pixels = settings.width * settings.height;
  s.width = settings.width;
  s.interleave = static_cast<uint32_t>(parameters.interleave);
  plan.filter = parameters.filter && parameters.interleave > 1;
  plan.caches = parameters.caches;
  s.max_scatterings =
      settings.max_bounces < 0 ? LUCARIUM_PATH_SCATTERING_CAP : static_cast<uint32_t>(settings.max_bounces) + 1;
  s.camera_edges = static_cast<uint32_t>(effort.camera_edges);
  s.candidates = static_cast<uint32_t>(parameters.candidates);
  plan.beta = static_cast<uint32_t>(parameters.beta);
  s.bundles = static_cast<uint32_t>(parameters.bundles);
  plan.bundles = parameters.directions != Directions::bsdf;
  plan.bundles_and_bsdf = parameters.directions == Directions::both;
  s.reuse = plan.takes_several_bundles() ? static_cast<uint32_t>(parameters.reuse) : BIDIRECTIONAL_REUSE_PER_DEPTH;
  plan.bundles_follow_sky = plan.bundles && parameters.dir_pdf == DirectionPdf::environment;
  plan.bundles_one_sided = plan.bundles && parameters.bundle_sides == BundleSides::one;
  if (plan.bundles) plan.bundle_mode = parameters.bundle_mode;
  plan.bundle_res = static_cast<uint32_t>(parameters.bundle_res);
  plan.choice = parameters.vpl_choice;
  plan.shows_strategies = parameters.show_strategies;

  // Choose the strategies.
  plan.lights = all || parameters.strategy == Strategy::nee;
  plan.vpl = effort.light_paths && (all || parameters.strategy == Strategy::vpl);
  if (plan.vpl) plan.two_bounce = parameters.two_bounce;
  plan.gloss = parameters.gloss;
  s.g_max = parameters.g_max;
  s.m_prime = parameters.m_prime;
  const uint32_t wanted = plan.two_bounce == TwoBounce::mis ? static_cast<uint32_t>(effort.light_vertices) : 1;
  plan.splat = effort.light_paths && (all ? effort.splats : parameters.strategy == Strategy::splat) &&
               settings.pixel_sampling == LUCARIUM_PIXEL_JITTER && wanted >= 2;
  plan.light_vertices = plan.vpl || plan.splat ? useful_vertices(wanted, s.max_scatterings, plan.vpl, plan.splat) : 0;
  plan.vpl = plan.vpl && plan.light_vertices > 0;
  plan.splat = plan.splat && plan.light_vertices >= 2;
  plan.learned = parameters.light_choice == LightChoice::learned && plan.light_vertices > 0;
  plan.punctual_paths = parameters.vpl_lights == VplLights::punctual;
  plan.rsm = parameters.light_trace == LightTrace::rsm && plan.light_vertices > 0;
  plan.vpl_maps = parameters.vpl_visibility == VplVisibility::map && plan.vpl;
  plan.direct_maps = parameters.direct == Direct::maps && plan.lights;
  plan.map_res = static_cast<uint32_t>(parameters.map_res);
  plan.guide =
      parameters.guide && all && plan.light_vertices >= 2 && !plan.bundles && !plan.caches && plan.gloss == Gloss::none;
  if (plan.light_vertices > 0) {
    const bool few = plan.choice == VplChoice::all || plan.choice == VplChoice::pair;
    const uint32_t automatic = few ? s.bundles : std::max(s.pixels / kPixelsPerLightPath, 1u);
    s.light_paths = plan.choice == VplChoice::own ? s.pixels
                    : parameters.light_paths > 0  ? static_cast<uint32_t>(parameters.light_paths)
                                                  : automatic;
  }

  // Count their samples for the weights. A connection is worth half as many as it compares, at the number of vertices
  // that light paths have on average if they end at any of them alike. One light path is one sample of its vertices.
  s.hit_samples = all || parameters.strategy == Strategy::hit ? 1.0f : 0.0f;
  s.light_samples = plan.lights ? 1.0f : 0.0f;
  float compared = 1.0f;
  if (plan.choice == VplChoice::resample)
    compared = std::max(compared, static_cast<float>(s.candidates) / (static_cast<float>(plan.light_vertices) + 1.0f));
  const auto tile = static_cast<float>(s.interleave * s.interleave);
  if (plan.choice == VplChoice::all) compared = static_cast<float>(s.light_paths) / tile;
  s.connection_samples = plan.vpl ? compared : 0.0f;
  s.splat_samples = plan.splat ? static_cast<float>(s.light_paths) : 0.0f;
  s.flags = (plan.choice == VplChoice::own ? BIDIRECTIONAL_OWN_VERTICES : 0u) |
            (plan.choice == VplChoice::pair ? BIDIRECTIONAL_PAIRED_VERTICES : 0u) |
            (plan.choice == VplChoice::all ? BIDIRECTIONAL_ALL_VERTICES : 0u) |
            (plan.two_bounce == TwoBounce::compensate ? BIDIRECTIONAL_COMPENSATES : 0u) |
            (plan.filter ? BIDIRECTIONAL_FILTERED : 0u) | (plan.shows_strategies ? BIDIRECTIONAL_STRATEGIES : 0u);
  return plan;
}

std::map<std::string, std::string> plan_defines(const Plan& plan) {
  std::map<std::string, std::string> defines;
  // Weights of whole paths take the probability of a light to be the same for all points.
  defines["LUCARIUM_LIGHTS_FROM_TABLE"] = "";
  defines["LUCARIUM_PATH_MIS_POWER"] = std::to_string(plan.beta);
  if (plan.learned) defines["LEARNED_LIGHTS"] = "1";
  if (plan.punctual_paths) defines["PUNCTUAL_PATHS"] = "1";
  if (plan.bundles) defines["EYE_BUNDLES"] = "1";
  if (plan.bundles_and_bsdf) defines["EYE_BUNDLES_AND_BSDF"] = "1";
  if (plan.bundles_follow_sky) defines["EYE_BUNDLES_FOLLOW_SKY"] = "1";
  if (plan.bundles_one_sided) defines["EYE_BUNDLES_ONE_SIDED"] = "1";
  if (plan.stores_bundles()) defines["EYE_BUNDLES_STORED"] = "1";
  if (plan.gloss != Gloss::none) {
    const char* const names[] = {"", "GLOSS_CLAMP", "GLOSS_VSL", "GLOSS_ROUGHNESS"};
    defines[names[static_cast<int>(plan.gloss)]] = "1";
  }
  return defines;
}

std::map<std::string, std::string> eye_defines(const Plan& plan) {
  std::map<std::string, std::string> defines = plan_defines(plan);
  defines["LIGHT_VERTICES"] = std::to_string(plan.light_vertices);
  if (plan.two_bounce != TwoBounce::mis) defines["TWO_BOUNCE"] = "1";
  if (plan.guide) defines["EYE_GUIDE"] = "1";
  if (plan.settings.interleave > 1) defines["EYE_INTERLEAVED"] = "1";
  if (plan.caches) defines["EYE_CACHES"] = "1";
  if (plan.direct_maps) defines["EYE_LIGHT_MAPS"] = "1";
  return defines;
}

}  // namespace lucarium::bidirectional
