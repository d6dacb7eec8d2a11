// SPDX-License-Identifier: Apache-2.0
// What tests of the whole technique share: one layer of a rendered scene, the reference's parameters.
#pragma once
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "lucarium/scene/builtin/builder.h"
#include "lucarium/scene/load/load_scene.h"
#include "lucarium/session/session.h"
#include "registry.h"

namespace lucarium::test {

using Parameters = std::vector<std::pair<std::string, std::string>>;

inline RenderSettings settings_for(const Scene& scene, uint32_t size, int max_bounces) {
  RenderSettings settings;
  settings.width = settings.height = size;
  settings.max_bounces = max_bounces;
  settings.pixel_sampling = LUCARIUM_PIXEL_CENTRE;  // so that edges of things are the same in every picture
  settings.camera = scene.cameras.front();
  return settings;
}

/// A layer of a scene after some iterations.
inline std::vector<float> rendered_layer(Scene scene, const std::string& technique, const char* layer, uint32_t size,
                                         int max_bounces, uint64_t iterations, const Parameters& parameters) {
  const RenderSettings settings = settings_for(scene, size, max_bounces);
  Parameters all = parameters;
  if (technique == "micro_rendering") all.emplace_back("eye_share", "0");  // an iteration is a frame
  RenderSession session(Device::open(), std::move(scene), registry().find(technique), settings, all);
  session.run({.iterations = iterations});
  return session.resolve().find(layer)->pixels;
}
inline std::vector<float> indirect_light(Scene scene, const std::string& technique, uint32_t size, int max_bounces,
                                         uint64_t iterations, const Parameters& parameters) {
  return rendered_layer(std::move(scene), technique, "indirect", size, max_bounces, iterations, parameters);
}

/// Hangs the scene's last instance on a node that an animation of one second moves, or stretches: values at its two
/// ends.
inline void animate_last_instance(Scene& scene, AnimationPath path, std::vector<float> values) {
  Node node;
  node.meshes = {scene.instances.back().mesh};
  scene.instances.back().node = static_cast<int>(scene.nodes.size());
  scene.nodes.push_back(node);
  Animation animation;
  animation.duration = 1;
  AnimationChannel channel;
  channel.node = scene.instances.back().node;
  channel.path = path;
  channel.times = {0, 1};
  channel.values = std::move(values);
  animation.channels.push_back(channel);
  scene.animations.push_back(animation);
  evaluate(scene, 0);
}

inline double mean(const std::vector<float>& values) {
  double sum = 0;
  for (const float v : values) sum += static_cast<double>(v);
  return sum / static_cast<double>(values.size());
}

/// Root mean square of the difference over the mean of `expected`.
inline double relative_rmse(const std::vector<float>& values, const std::vector<float>& expected) {
  double squares = 0;
  for (size_t i = 0; i < values.size(); ++i) {
    const double difference = static_cast<double>(values[i]) - static_cast<double>(expected[i]);
    squares += difference * difference;
  }
  return std::sqrt(squares / static_cast<double>(values.size())) / mean(expected);
}

/// The parameters of `base` with `more` behind them, which win.
inline Parameters with(Parameters base, const Parameters& more) {
  base.insert(base.end(), more.begin(), more.end());
  return base;
}

const Parameters reference = {
    {"secondary_lambert_only", "on"}, {"light_delta", "off"}, {"samples_per_iteration", "64"}};
// An iteration is a frame here.
const Parameters small = {{"points_log2", "13"}, {"micro_size", "16"}, {"jacobi_level", "8"}, {"eye_share", "0"}};

}  // namespace lucarium::test
