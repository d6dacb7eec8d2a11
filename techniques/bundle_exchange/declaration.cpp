// SPDX-License-Identifier: Apache-2.0
#include "bundle_exchange/declaration.h"

#include <algorithm>

#include "bundle_exchange/base/name.h"
#include "lucarium/base/error.h"

namespace lucarium::bundle {

TechniqueInfo technique_info() {
  TechniqueInfo info;
  info.name = technique_name;
  info.version = "1.1";
  info.summary = "radiance exchange along global parallel ray-bundles into a surface atlas";
  info.citation =
      "J. Hermes, N. Henrich, T. Grosch, S. Mueller, Global Illumination using Parallel Global Ray-Bundles, Vision, "
      "Modeling, and Visualization 2010";
  info.capabilities.lights = all_kinds<LightKind>();
  info.capabilities.materials = all_kinds<MaterialKind>();
  info.capabilities.changes = all_kinds<ChangeKind>();
  info.capabilities.max_bounces = -1;
  info.capabilities.view_independent = true;
  info.capabilities.resizes = true;
  info.capabilities.bias = 0.02;  // radiance is constant over a texel; geometric cosines of indirect light
  info.layers = {"emission", "direct", "indirect"};
  info.optional_layers = {{"debug_layers=on",
                           {"sampled_direct", "exchanged_direct", "diffuse_exchange", "specular_chains",
                            "bundle_gather", "accessibility", "balance", "direction_history"}}};
  info.check_parameters = {{"texels", "4096"}, {"directions", "96"}};
  info.oclgrind_parameters = {{"texels", "256"}, {"batch", "1"}, {"directions", "2"}};
  return info;
}

namespace {

bool divides_directions(const Parameters& parameters) {
  return !forgets(parameters) || parameters.sequence == DirectionOrder::hammersley;
}

}  // namespace

PathSet path_set(const Parameters& parameters, const RenderSettings& settings) {
  PathSet set;
  set.max_bounces = settings.max_bounces;
  if (parameters.interleave == Interleave::pingpong && set.max_bounces < 0 &&
      parameters.directions > 0) {  // a bounce for each block
    const int head = parameters.direct_mode == DirectMode::exchange ? parameters.direct_first : 0;
    set.max_bounces = (std::max(0, parameters.directions - head) + parameters.block - 1) / parameters.block;
  }
  set.light_delta = parameters.glossy_bounces == GlossyBounces::multiple;
  set.secondary_lambert_only = !set.light_delta;
  return set;
}

void check_parameters(const Parameters& parameters) {
  if (!divides_directions(parameters) || parameters.directions > 0) return;
  throw_error(ErrorClass::usage,
              "bundle_exchange: directions=0 with interleave=pingpong, interleave=fixed or sequence=hammersley, which "
              "divide a number of directions; set directions to 1 or more");
}

std::vector<std::pair<std::string, std::string>> endless(const Parameters& parameters) {
  if (divides_directions(parameters) || parameters.preview) return {{"camera_samples", "0"}};
  return {{"directions", "0"}, {"stop_error", "0"}, {"camera_samples", "0"}};
}

std::string state_refusal(const Parameters& parameters) {
  if (parameters.directions == 0) return "exchanges light for ever where directions=0; set them to 1 or more";
  if (parameters.pixel_rays == PixelRays::bundle)
    return "gathers along new bundles for every picture with pixel_rays=bundle; give pixel_rays=traced";
  if (parameters.debug_layers) return "shows the exchange itself with debug_layers=on; leave that out";
  return "";
}

}  // namespace lucarium::bundle
