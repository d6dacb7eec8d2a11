// SPDX-License-Identifier: Apache-2.0
// The seconds that the work takes on one core, on the safe side of what was measured with PoCL
// (docs/measurements/bundle_exchange.md, "Model of the time").
#include "bundle_exchange/cost.h"

#include <algorithm>

#include "lucarium/services/texel_sides/side_accessibility.h"

namespace lucarium::bundle {
namespace {

constexpr double kAtlasSeconds = 3e-6;          // a texel of the atlas …
constexpr double kChartSeconds = 3e-6;          // … and a triangle
constexpr double kHiddenSeconds = 1.3e-5;       // a texel's walks that find hidden places
constexpr double kAccessibilitySeconds = 4e-8;  // a ray of a texel that measures accessibility
constexpr double kSideLightSeconds = 1.8e-5;    // a texel's first light samples
constexpr double kTexelSeconds = 8e-8;          // a texel, in a direction
constexpr double kTriangleSeconds = 2e-8;       // a triangle, in a direction
constexpr double kPixelSeconds = 2e-6;          // a sample of a pixel
constexpr double kFirstDirections = 64;         // that give a picture
constexpr double kMaxEyeSamples = 256;          // of a step
constexpr double kLightSampleSeconds = 3e-7;    // a light sample of a texel side
constexpr double kChainRaySeconds = 4e-7;       // a ray of a chain, with what follows from its hit

}  // namespace

double estimate_seconds(const BundlePlan& plan, const Parameters& parameters, const Scene& scene,
                        const RenderSettings& settings, const ComputePower& power) {
  const auto texels = static_cast<double>(plan.atlas.texel_count),
             triangles = static_cast<double>(scene.triangle_count());
  const double pixels = double{1} * settings.width * settings.height;
  const double atlas = texels * kAtlasSeconds + triangles * kChartSeconds;
  double device = pixels * kPixelSeconds;
  if (settings.max_bounces != 0 || parameters.direct_mode == DirectMode::exchange) {
    const double area = double{parameters.pixel_size} * parameters.pixel_size;
    const double rays = SideAccessibility::bundles(parameters.pixel_size, parameters.access_rays) / area;
    const double accessibility = parameters.access_gap != 0 ? rays * kAccessibilitySeconds : 0;
    const double light = parameters.direct_mode == DirectMode::nee ? kSideLightSeconds : 0;
    const double directions = std::min(static_cast<double>(direction_limit(parameters)), kFirstDirections);
    device += texels * (kHiddenSeconds + accessibility + light) +
              directions * (texels * kTexelSeconds + triangles * kTriangleSeconds);
  }
  return atlas / power.host + device / power.device;
}

WorkUnits work_units(uint32_t sides, uint32_t light_run, size_t triangles, uint32_t pixels, double rays) {
  return {sides * kTexelSeconds + static_cast<double>(triangles) * kTriangleSeconds, light_run * kLightSampleSeconds,
          pixels * kPixelSeconds + rays * kChainRaySeconds};
}

double earned_eye_samples(const Parameters& parameters, const EyeShare& eye, const WorkUnits& units,
                          uint64_t directions, uint32_t light_runs, bool lit) {
  if (parameters.pixel_rays == PixelRays::bundle || eye.share == 0) return 1;
  const double other = static_cast<double>(directions) * units.direction + light_runs * units.light_run;
  const double at_share = eye.share / (1 - eye.share) * other / units.eye_sample;
  if (!lit) return std::min(1.0, at_share);
  const double least = eye.measured ? (eye.due ? 1.0 : 0.0) : std::min(1.0, other / units.eye_sample);
  return std::min(kMaxEyeSamples, std::max(at_share, least));
}

std::vector<ParameterSaving> savings() {
  return {
      {"access_rays", {"128"}}, {"texels", {"131072", "65536", "32768", "16384", "8192"}}, {"texels", {"4096"}, true}};
}

}  // namespace lucarium::bundle
