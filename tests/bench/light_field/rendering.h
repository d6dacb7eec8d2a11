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

inline constexpr uint32_t kFrames = 16;  // of a walk

inline SceneCamera camera_of_frame(const Scene& scene, uint32_t frame, uint32_t frames) {
  const auto& keys = scene.camera_paths.front().keys;
  const double first = keys.front().seconds, last = keys.back().seconds;
  return camera_on_path(scene.camera_paths.front(), first + (last - first) * frame / (frames - 1));
}

/// A session whose light is finished, one sample of pixels at a time.
inline std::unique_ptr<RenderSession> settled(const Scene& scene, const Sizes& sizes, const Parameters& parameters,
                                              int max_bounces = -1) {
  auto session = make_session("virtual_light_field", scene, sizes.width, parameters, max_bounces);
  session->finish_light();
  return session;
}

/// The next frame of a walk, of one sample.
inline void next_frame(RenderSession& session, uint32_t* frame) {
  session.set_camera(camera_of_frame(session.scene(), (*frame)++ % kFrames, kFrames));
  session.run({.samples = 1});
  session.scheduler().finish();
}

}  // namespace lucarium::bench
