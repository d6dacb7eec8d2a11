// SPDX-License-Identifier: Apache-2.0
// Whole techniques, by sessions of 24 x 24 pixels.
#pragma once
#include "lucarium/scene/load/load_scene.h"
#include "lucarium/session/session.h"
#include "test_support.h"

namespace lucarium::test {

using Options = std::vector<std::pair<std::string, std::string>>;

inline const TechniqueRegistry& registry() {
  static const TechniqueRegistry all;
  return all;
}

inline std::unique_ptr<RenderSession> session(const std::string& technique, Scene scene, int max_bounces,
                                              const Options& options) {
  RenderSettings settings;
  settings.width = settings.height = 24;
  settings.max_bounces = max_bounces;
  settings.pixel_sampling = LUCARIUM_PIXEL_CENTRE;
  settings.camera = scene.cameras.front();
  return std::make_unique<RenderSession>(Device::open(), std::move(scene), registry().find(technique), settings,
                                         options);
}

inline std::vector<float> indirect(RenderSession& session) { return session.resolve().find("indirect")->pixels; }

inline double mean(const std::vector<float>& values) {
  double sum = 0;
  for (const float v : values) sum += static_cast<double>(v);
  return sum / static_cast<double>(values.size());
}

inline double indirect_mean(const std::string& technique, const char* scene, int max_bounces, uint64_t iterations,
                            const Options& options) {
  const auto run = session(technique, load_scene(scene), max_bounces, options);
  run->run({.iterations = iterations});
  return mean(indirect(*run));
}

/// Iterations exchange, all of them: tests count them.
inline const Options few_texels = {{"texels", "2048"}, {"batch", "1"}, {"stop_error", "0"}, {"eye_share", "0"}};

inline Options with(Options options, const Options& more) {
  options.insert(options.end(), more.begin(), more.end());
  return options;
}

}  // namespace lucarium::test
