// SPDX-License-Identifier: Apache-2.0
// Light that does not depend on the camera, saved and loaded: what tests of techniques with states share.
#pragma once
#include <doctest/doctest.h>

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "lucarium/base/error.h"
#include "lucarium/technique/state_file.h"
#include "technique_session.h"

namespace lucarium::test {

inline std::vector<float> picture(RenderSession& session) {
  session.run({.samples = 3});
  return session.resolve().image();
}

/// A session that begins with a state.
inline std::unique_ptr<RenderSession> loaded(const std::string& technique, const std::filesystem::path& file,
                                             Scene scene, const Options& options, const SessionStart& start = {}) {
  const StateFile state(file);
  return session(technique, std::move(scene), start, options, &state);
}

/// The finished light of a session, and that session.
struct SavedLight {
  TemporaryFolder folder;
  std::filesystem::path file = folder.path() / "a.state";
  std::unique_ptr<RenderSession> by;
  SavedLight(const std::string& technique, const Scene& scene, const Options& options, int max_bounces = -1)
      : by(session(technique, scene, max_bounces, options)) {
    by->finish_light();
    by->save_state(file, false);
  }
};

/// Light is finished beside an image of 64 pixels along an edge, and has the bits of light beside the whole one.
inline void check_light_beside_small_image(const std::string& technique, const Scene& scene, const Options& options) {
  const SessionStart start = {.width = 96};
  const auto small = session(technique, scene, start, options), whole = session(technique, scene, start, options);
  CHECK_THROWS(small->finish_light([](const IterationResult&) { throw Error(ErrorClass::usage, "no more"); }));
  CHECK(small->settings().width == 96);
  uint32_t width = 0;
  small->finish_light([&](const IterationResult&) { width = small->settings().width; });
  CHECK(width == 64);
  CHECK(small->settings().width == 96);
  whole->run({}, [](const IterationResult& now) { return !now.light_done; });
  whole->set_camera(scene.cameras.front());
  const std::vector<float> seen = picture(*small);
  CHECK(mean(seen) > 0);
  CHECK(seen == picture(*whole));
}

/// `load` throws an Error of one line that has `part` in it.
inline void check_refusal(const std::function<void()>& load, ErrorClass error_class, const std::string& part) {
  try {
    load();
    FAIL_CHECK("it was loaded, instead of: " << part);
  } catch (const Error& error) {
    const std::string message = error.what();
    CAPTURE(message);
    CHECK(error.error_class() == error_class);
    CHECK(message.find(part) != std::string::npos);
    CHECK(message.find('\n') == std::string::npos);
  }
}

/// Lamps half as bright.
inline SceneChange dim_lamps(Scene& scene) {
  SceneChange change;
  for (size_t i = 0; i < scene.materials.size(); ++i) {
    if (!scene.materials[i].emits()) continue;
    scene.materials[i].emissive_factor *= 0.5f;
    change.materials.push_back(static_cast<int>(i));
  }
  return change;
}

}  // namespace lucarium::test
