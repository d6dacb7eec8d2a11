// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "bundle_exchange/pixels/camera_light.h"
#include "bundle_exchange/senders/side_means.h"
#include "lucarium/technique/technique.h"

namespace lucarium::bundle {

/// What parameters, scene and settings ask for, before anything is built.
struct BundlePlan {
  SurfaceAtlasOptions atlas;
  Channels channels;
  CameraLight::Options camera;
  bool exchanges = false;    ///< bundles carry anything
  bool preview = false;      ///< images that have not converged show what SidePreview smooths
  bool reflects = false;     ///< specular lobes of texel sides take part in the exchange
  uint32_t halves = 1;       ///< SideAccessibility::Options::halves
  uint32_t light_kinds = 0;  ///< of lights that texel sides get light samples of (LUCARIUM_LIGHT_* bits)
};
BundlePlan make_plan(const Parameters& parameters, const Scene& scene, const RenderSettings& settings);

/// Whether bundles carry anything.
bool exchanges(const Parameters& parameters, const RenderSettings& settings);

/// What directions are drawn by, or null: by nothing.
std::shared_ptr<const EnvironmentGuide> make_guide(const Parameters& parameters, const Scene& scene);

/// Whether some material may reflect or transmit otherwise than diffusely.
bool has_specular_lobes(const Scene& scene);

/// What light is missing or wrong with these parameters, a line each, for people.
std::vector<std::string> limitations(const Parameters& parameters, const Scene& scene, const RenderSettings& settings);

/// Expected device memory [bytes].
size_t estimate_bytes(const BundlePlan& plan, const Parameters& parameters, const Scene& scene,
                      const RenderSettings& settings);

}  // namespace lucarium::bundle
