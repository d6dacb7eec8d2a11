// SPDX-License-Identifier: Apache-2.0
// The seconds that the work takes on one core, on the safe side of what was measured with PoCL
// (docs/measurements/micro_rendering.md, "Model of the time").
#include "micro_rendering/cost.h"

#include <cmath>

#include "lucarium/technique/work_share.h"
#include "micro_rendering/declaration.h"

namespace lucarium::micro {
namespace {

constexpr double kPointSeconds = 1.2e-5;  // placed, looked at from both sides, ordered
constexpr double kPixelSeconds = 8e-7;    // of G-buffer and a light sample
constexpr double kLightSampleSeconds = 3e-7;
constexpr double kVirtualLightSeconds = 1e-7;  // a virtual light at a point
constexpr double kPhotonPathSeconds = 8e-7;    // a light path
constexpr double kPhotonSearchSeconds = 3e-7;  // a photon of a density at a point
constexpr double kGatherSeconds = 1.2e-5;      // a gather, beside its micro-pixels
constexpr double kMicroPixelSeconds = 2.8e-7;  // over 2^16 points, with cut_kappa=1
constexpr double kNodesPerCut = 2;             // at most, over those of jacobi_level
constexpr double kFailedInterpolation = 0.1;   // share of the pixels that gather themselves (gather_step)
constexpr double kTransmittingPixels = 0.05;   // that gather on two sides, where a material transmits
constexpr double kVisitSeconds = 6.5e-9;       // a node that a gather opens, with what follows from it
constexpr double kGatherNoise = 0.1;           // of a micro-buffer of 16², of its light

double gather_seconds(const MicroParameters& parameters, float kappa) {
  const double depth = std::exp2((parameters.points_log2 - 16) / 4.0);  // about: nodes that are opened
  const double nodes = std::pow(double{kappa}, -0.85);                  // over those of cut_kappa=1
  return kGatherSeconds + kMicroPixelSeconds * depth * nodes * parameters.micro_size * parameters.micro_size;
}

/// Light at the points, of the bounces before the last.
double light_seconds(const MicroParameters& parameters, int bounces) {
  const double points = std::exp2(parameters.points_log2), before = bounces - 1;
  const double samples = points * parameters.light_samples * kLightSampleSeconds;
  switch (parameters.multibounce) {
    case MultiBounce::jacobi:
      return samples + before * kNodesPerCut * std::exp2(parameters.jacobi_level) *
                           gather_seconds(parameters, parameters.node_kappa());
    case MultiBounce::instant_radiosity: return samples + before * parameters.vpls * points * kVirtualLightSeconds;
    case MultiBounce::photon_map:
      return samples + parameters.photons * kPhotonPathSeconds + points * parameters.photon_k * kPhotonSearchSeconds;
  }
  return samples;
}

double eye_seconds(const MicroParameters& parameters, const RenderSettings& settings) {
  return double{1} * settings.width * settings.height * (1 + parameters.direct_samples) / 2 * kPixelSeconds;
}

/// Gathers at pixels, or virtual lights at them.
double pixel_seconds(const MicroParameters& parameters, const Scene& scene, const RenderSettings& settings) {
  const double pixels = double{1} * settings.width * settings.height;
  if (parameters.shows_virtual_lights())
    return pixels * parameters.vpls * bounces(parameters, settings) * kVirtualLightSeconds;
  const double step = parameters.gather_step;
  const double gathered = pixels * (transmits(scene) ? 1 + kTransmittingPixels : 1) *
                          std::min(1.0, 1 / (step * step) + (step > 1 ? kFailedInterpolation : 0));
  return gathered * gather_seconds(parameters, parameters.cut_kappa);
}

/// Of a frame, beside samples of pixels. Virtual lights that light pixels need no light at points.
double indirect_seconds(const MicroParameters& parameters, const Scene& scene, const RenderSettings& settings) {
  const double light = parameters.shows_virtual_lights() ? 0 : light_seconds(parameters, bounces(parameters, settings));
  return light + pixel_seconds(parameters, scene, settings);
}

}  // namespace

double estimate_seconds(const MicroParameters& parameters, const Scene& scene, const RenderSettings& settings,
                        const ComputePower& power) {
  const double eye = eye_seconds(parameters, settings);
  if (bounces(parameters, settings) == 0) return eye / power.device;
  const double points = std::exp2(parameters.points_log2) * kPointSeconds / power.host;
  return points + (eye + indirect_seconds(parameters, scene, settings)) / power.device;
}

uint32_t eye_samples_per_frame(const MicroParameters& parameters, const Scene& scene, const RenderSettings& settings) {
  if (bounces(parameters, settings) == 0) return 1;
  const FrameWork work = frame_work(parameters, scene, settings);
  return units_for_share(static_cast<double>(parameters.eye_share), work.indirect, work.eye, kMaxEyeSamples);
}

FrameWork frame_work(const MicroParameters& parameters, const Scene& scene, const RenderSettings& settings,
                     double visits) {
  double indirect = indirect_seconds(parameters, scene, settings);
  if (visits > 0) indirect += visits * kVisitSeconds - pixel_seconds(parameters, scene, settings);
  return {eye_seconds(parameters, settings), indirect};
}

double assumed_gather_variance(const MicroParameters& parameters) {
  const double noise = kGatherNoise * 16 / parameters.micro_size;
  return noise * noise;
}

std::vector<ParameterSaving> savings() {
  // Nodes of four micro-pixels before fewer points and micro-pixels: discs that stick out and coarse nodes show as
  // patches, which are worse to look at than noise.
  return {{"cut_kappa", {"2", "4"}},
          {"points_log2", {"17"}},
          {"jacobi_level", {"11", "10"}},
          {"vpls", {"128", "64", "32"}},
          {"photons", {"500000", "250000", "125000"}},
          {"light_samples", {"4"}},
          {"micro_size", {"20", "16"}},
          {"gather_step", {"2", "4"}},
          {"micro_size", {"12", "8"}, true},
          {"points_log2", {"16", "15", "14", "13", "12", "11"}, true},
          {"jacobi_level", {"9", "8", "7", "6"}, true},
          {"light_samples", {"2", "1"}, true}};
}

}  // namespace lucarium::micro
