// SPDX-License-Identifier: Apache-2.0
// Whole techniques, by sessions on the device of the tests.
#pragma once
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "bars.h"
#include "device_fixture.h"
#include "lucarium/scene/load/load_scene.h"
#include "lucarium/session/session.h"
#include "registry.h"

namespace lucarium::bench {

using Parameters = std::vector<std::pair<std::string, std::string>>;

inline std::unique_ptr<RenderSession> make_session(const std::string& technique, const Scene& scene, uint32_t width,
                                                   const Parameters& parameters = {}, int max_bounces = -1,
                                                   uint64_t seed = 1, const StateFile* state = nullptr) {
  RenderSettings settings;
  settings.width = settings.height = width;
  settings.max_bounces = max_bounces;
  settings.seed = seed;
  settings.camera = scene.cameras.front();
  return std::make_unique<RenderSession>(test::test_device(), scene, test::registry().find(technique), settings,
                                         parameters, RenderSession::OnPreparing{}, TimeBudget(), state);
}

/// A small field that only looks up.
inline Parameters walkthrough(const Sizes& sizes) {
  return {{"preset", "walkthrough"}, {"dir_n", std::to_string(sizes.dir_n)},
          {"cells", "64"},           {"texels", "16384"},
          {"access_rays", "128"},    {"preview", "off"}};
}

}  // namespace lucarium::bench
