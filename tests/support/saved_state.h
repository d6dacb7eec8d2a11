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
