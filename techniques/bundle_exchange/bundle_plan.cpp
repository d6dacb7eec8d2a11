// SPDX-License-Identifier: Apache-2.0
#include "bundle_exchange/bundle_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "bundle_exchange/declaration.h"
#include "bundle_exchange/exchange/bundle_transfer.h"
#include "bundle_exchange/pixels/debug_layers.h"
#include "bundle_exchange/specular/side_specular.h"
#include "lucarium/compute/device/remedies.h"
#include "lucarium/services/texel_sides/side_light.h"
#include "lucarium/shared/texel_sides.h"
#include "lucarium/technique/technique_state.h"

namespace lucarium::bundle {
namespace {

bool has_lamps(const Scene& scene) {
  return std::any_of(scene.materials.begin(), scene.materials.end(), [](const SceneMaterial& m) { return m.emits(); });
}

/// Unlimited bounces feed one channel back to itself; finite ones have a channel each.
Channels make_channels(const Parameters& parameters, const Scene& scene, const RenderSettings& settings,
                       bool reflects) {
  Channels result;
  result.chains = has_specular_lobes(scene) || parameters.final_gather == FinalGather::all;
  // Glossy texel sides that trace no rays get what lamps and the environment send along the bundles.
  result.to_history = parameters.direct_mode == DirectMode::nee && SideSpecular::uses_history(parameters) && reflects &&
                      (has_lamps(scene) || scene.environment);
  result.emission = parameters.direct_mode == DirectMode::exchange || result.to_history;
  result.self_fed = settings.max_bounces < 0;
  result.count = (result.self_fed ? 1 : static_cast<uint32_t>(settings.max_bounces)) + (result.emission ? 1 : 0);
  result.count = std::max(1u, result.count);  // direct light by samples alone exchanges nothing
  return result;
}

}  // namespace

bool has_specular_lobes(const Scene& scene) {
  return std::any_of(scene.materials.begin(), scene.materials.end(), [](const SceneMaterial& m) {
    return std::abs(m.ior - 1) >= 1e-3f || m.metallic > 0 || m.transmission > 0;
  });
}

BundlePlan make_plan(const Parameters& parameters, const Scene& scene, const RenderSettings& settings) {
  check_parameters(parameters);
  BundlePlan plan;
  const bool specular = has_specular_lobes(scene), punctual = !scene.lights.empty();
  plan.atlas.samples = SIDE_POINTS;
  plan.atlas.remedy = remedies::lower_texels;
  plan.atlas.texel_count = parameters.texels > 0
                               ? static_cast<uint64_t>(parameters.texels)
                               : suitable_texels(uint64_t{settings.width} * settings.height, scene.triangle_count());
  // Direct light needs no lobes of texel sides: they begin behind the first scattering.
  plan.reflects = specular && settings.max_bounces != 0 && parameters.glossy_bounces == GlossyBounces::multiple;
  plan.exchanges = exchanges(parameters, settings);
  plan.halves = SideHalves::per_side(scene, parameters.access_gap);
  plan.preview = parameters.preview && forgets(parameters);
  plan.channels = make_channels(parameters, scene, settings, plan.reflects);
  const bool idle = parameters.final_gather == FinalGather::glossy && !specular;
  plan.camera.gather = idle ? FinalGather::off : parameters.final_gather;
  plan.camera.punctual = punctual;
  plan.camera.single = parameters.glossy_bounces == GlossyBounces::final;
  plan.camera.exchanged = plan.channels.exchanged();
  plan.camera.max_bounces = settings.max_bounces;
  plan.camera.by_bundles = parameters.pixel_rays == PixelRays::bundle && settings.max_bounces != 0 &&
                           parameters.interleave != Interleave::pingpong;  // bundles then carry one bounce only
  plan.camera.debug = parameters.debug_layers;
  plan.camera.min_alpha = SideSpecular::min_alpha(parameters);
  plan.light_kinds = DirectLight::kAllLights;
  if (parameters.direct_mode == DirectMode::exchange) plan.light_kinds = punctual ? DirectLight::kPunctualLights : 0;
  return plan;
}

bool exchanges(const Parameters& parameters, const RenderSettings& settings) {
  return settings.max_bounces != 0 || parameters.direct_mode == DirectMode::exchange;
}

std::shared_ptr<const EnvironmentGuide> make_guide(const Parameters& parameters, const Scene& scene) {
  return scene.environment && parameters.env_guiding > 0 ? make_environment_guide(&*scene.environment) : nullptr;
}

size_t estimate_bytes(const BundlePlan& plan, const Parameters& parameters, const Scene& scene,
                      const RenderSettings& settings) {
  const size_t sides = SurfaceAtlas::estimate_sides(scene, plan.atlas);
  return SurfaceAtlas::estimate_bytes(scene, plan.atlas, sides) +
         SideMeans::estimate_bytes(plan.halves * sides, plan.channels, parameters) +
         SideLight::estimate_bytes(sides, plan.halves) + TexelInterior::estimate_bytes(sides, SIDE_POINTS) +
         SideAccessibility::estimate_bytes(sides, plan.halves) +
         (plan.reflects ? SideSpecular::estimate_bytes(sides, plan.halves, plan.channels, parameters) : 0) +
         CameraLight::estimate_bytes(settings.width, settings.height, plan.camera.gather, plan.camera.by_bundles,
                                     plan.preview) +
         BundleTransfer::estimate_bytes(scene, SurfaceAtlas::estimate_edge(scene, plan.atlas), parameters,
                                        plan.camera.by_bundles) +
         (plan.preview ? SidePreview::estimate_bytes(plan.halves * sides, plan.channels) : 0) +
         (plan.camera.debug ? DebugLayers::estimate_bytes(size_t{settings.width} * settings.height, plan.preview) +
                                  SideState::estimate_bytes(plan.halves * sides)
                            : 0);
}

std::vector<std::string> limitations(const Parameters& parameters, const Scene& scene, const RenderSettings& settings) {
  std::vector<std::string> result;
  const auto any = [&](auto&& test) { return std::any_of(scene.materials.begin(), scene.materials.end(), test); };
  if (any([](const SceneMaterial& m) {
        return m.transmission > 0 && m.thickness > 0 && std::isfinite(m.attenuation_distance);
      }))
    result.push_back("bundles are not attenuated inside volumes");
  if (parameters.direct_mode == DirectMode::exchange &&
      static_cast<uint64_t>(parameters.direct_first) >= direction_limit(parameters) && settings.max_bounces != 0)
    result.push_back("indirect light is left out: all directions carry emission only (direct_first)");
  if (parameters.interleave == Interleave::fixed)
    result.push_back("light of several bounces is lost (interleave=fixed, for comparison only)");
  if (parameters.interleave == Interleave::running && settings.max_bounces < 0)
    result.push_back("light of many bounces converges slowly (interleave=running, for comparison only)");
  const bool history = SideSpecular::uses_history(parameters) && has_specular_lobes(scene) &&
                       parameters.glossy_bounces == GlossyBounces::multiple;
  if (history) {
    if (parameters.sequence == DirectionOrder::halton)
      result.push_back("glossy light between surfaces is too dark by about half (sequence=halton with glossy_window)");
    if (std::none_of(scene.materials.begin(), scene.materials.end(), [&](const SceneMaterial& m) {
          return m.roughness * m.roughness >= SideSpecular::min_alpha(parameters);
        }))
      result.push_back(
          fmt::format("glossy_window has no effect: no surface has the minimum GGX alpha of {:.2f} (history_alpha)",
                      SideSpecular::min_alpha(parameters)));
  }
  if (parameters.interleave == Interleave::pingpong && history)
    result.push_back("bounces of glossy light are mixed (interleave=pingpong with glossy_window)");
  if (parameters.interleave == Interleave::pingpong && has_specular_lobes(scene))
    result.push_back("specular reflections between diffuse ones do not count as bounces (interleave=pingpong)");
  if (parameters.interleave == Interleave::pingpong && parameters.pixel_rays == PixelRays::bundle)
    result.push_back("pixel_rays=bundle has no effect: bundles carry one bounce at a time (interleave=pingpong)");
  for (const auto& [name, on] :
       {std::pair("preview", parameters.preview), std::pair("warm_start", parameters.warm_start)})
    if (on && !forgets(parameters))
      result.push_back(fmt::format("{}=on has no effect: it needs interleave=sd or running", name));
  if (parameters.final_gather == FinalGather::off && has_specular_lobes(scene))
    result.push_back(parameters.direct_mode == DirectMode::exchange
                         ? "light that specular lobes reflect towards the eye is left out, except from punctual lights "
                           "(final_gather=off)"
                         : "indirect light that specular lobes reflect towards the eye is left out (final_gather=off)");
  return result;
}

}  // namespace lucarium::bundle
