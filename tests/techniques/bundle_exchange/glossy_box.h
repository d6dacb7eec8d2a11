// SPDX-License-Identifier: Apache-2.0
// A box that shines and reflects by specular lobes only, and what its walls reflect of light from everywhere.
#pragma once
#include <algorithm>
#include <cmath>

#include "bundle_rig.h"
#include "lucarium/scene/device/specular_albedo.h"

namespace lucarium::test {

/// A box of emission 1 whose walls have specular lobes only.
inline Scene shining_box(float k, float roughness) {
  Scene scene;
  const int metal = add_metal(scene, "metal", glm::vec3(k), roughness);
  scene.materials[metal].emissive_factor = glm::vec3(1);
  return box_scene({metal, metal, metal, metal, metal, metal}, std::move(scene));
}

/// bounces 0: unlimited.
inline bundle::Channels glossy_channels(int bounces) {
  bundle::Channels channels;
  channels.chains = channels.emission = channels.to_history = true;
  channels.self_fed = bounces == 0;
  channels.count = 1 + (channels.self_fed ? 1 : static_cast<uint32_t>(bounces));
  return channels;
}

/// Albedo E1 of the reflection lobe of a metal of F = 1 at cosine mu to the normal, interpolated in the table as
/// kernels/lucarium/specular_albedo.clh says.
inline double white_lobe_albedo(double mu, double roughness) {
  constexpr int averages = 129, nodes = 32;
  const std::vector<float> table = specular_albedo_table();
  const auto entry = [&](int row, int column) { return double(table[2 * (averages + row * nodes + column)]); };
  const double y = roughness * (nodes - 1), x = std::sqrt(mu) * (nodes - 1);
  const int i = std::min(int(x), nodes - 2), j = std::min(int(y), nodes - 2);
  const auto row = [&](int r) { return std::lerp(entry(r, i), entry(r, i + 1), x - i); };
  return std::lerp(row(j), row(j + 1), y - j);
}

}  // namespace lucarium::test
