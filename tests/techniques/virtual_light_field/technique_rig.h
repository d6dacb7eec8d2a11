// SPDX-License-Identifier: Apache-2.0
// The whole technique, by sessions of 24 x 24 pixels.
#pragma once
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "device_fixture.h"
#include "lucarium/scene/load/load_scene.h"
#include "lucarium/session/session.h"
#include "test_support.h"

namespace lucarium::test {

using Options = std::vector<std::pair<std::string, std::string>>;

inline const TechniqueRegistry& registry() {
  static const TechniqueRegistry all;
  return all;
}

inline std::unique_ptr<RenderSession> session(Scene scene, int max_bounces, const Options& options,
                                              const std::string& technique = "virtual_light_field") {
  RenderSettings settings;
  settings.width = settings.height = 24;
  settings.max_bounces = max_bounces;
  settings.pixel_sampling = LUCARIUM_PIXEL_CENTRE;
  settings.camera = scene.cameras.front();
  return std::make_unique<RenderSession>(test_device(), std::move(scene), registry().find(technique), settings,
                                         options);
}

inline double mean(const std::vector<float>& values) {
  double sum = 0;
  for (const float v : values) sum += static_cast<double>(v);
  return sum / static_cast<double>(values.size());
}

inline std::vector<float> indirect(RenderSession& session) { return session.resolve().find("indirect")->pixels; }

inline Options with(Options options, const Options& more) {
  options.insert(options.end(), more.begin(), more.end());
  return options;
}

}  // namespace lucarium::test
