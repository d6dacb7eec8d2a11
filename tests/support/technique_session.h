// SPDX-License-Identifier: Apache-2.0
// Whole techniques, by sessions of 24 x 24 pixels that look at pixel centres.
#pragma once
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "device_fixture.h"
#include "lucarium/scene/load/load_scene.h"
#include "lucarium/session/session.h"
#include "registry.h"
#include "test_support.h"

namespace lucarium::test {

using Options = std::vector<std::pair<std::string, std::string>>;

struct SessionStart {
  uint32_t width = 24;
  uint64_t seed = 1;
  int max_bounces = -1;
};

/// `state`: what it begins with; null: nothing.
inline std::unique_ptr<RenderSession> session(const std::string& technique, Scene scene, const SessionStart& start,
                                              const Options& options, const StateFile* state = nullptr) {
  RenderSettings settings;
  settings.width = start.width;
  settings.height = 24;
  settings.max_bounces = start.max_bounces;
  settings.seed = start.seed;
  settings.pixel_sampling = LUCARIUM_PIXEL_CENTRE;
  settings.camera = scene.cameras.front();
  return std::make_unique<RenderSession>(test_device(), std::move(scene), registry().find(technique), settings, options,
                                         RenderSession::OnPreparing{}, TimeBudget(), state);
}

inline std::unique_ptr<RenderSession> session(const std::string& technique, Scene scene, int max_bounces,
                                              const Options& options) {
  return session(technique, std::move(scene), SessionStart{.max_bounces = max_bounces}, options);
}

inline std::vector<float> indirect(RenderSession& session) { return session.resolve().find("indirect")->pixels; }

inline double mean(const std::vector<float>& values) {
  double sum = 0;
  for (const float v : values) sum += static_cast<double>(v);
  return sum / static_cast<double>(values.size());
}

inline Options with(Options options, const Options& more) {
  options.insert(options.end(), more.begin(), more.end());
  return options;
}

}  // namespace lucarium::test
