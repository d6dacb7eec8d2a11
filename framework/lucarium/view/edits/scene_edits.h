// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "lucarium/scene/scene.h"

namespace lucarium {

/// What a page has changed of the scene, in the words of the command line (scene_overrides.h).
struct SceneEdits {
  std::optional<std::vector<std::string>> lights;  ///< all punctual lights; empty: the scene's own
  std::vector<std::string> materials;              ///< "NAME:key=value[,key=value]"
  std::string environment;                         ///< "R,G,B", "none"; "": the scene's own
  std::optional<double> seconds;                   ///< of the animation; empty: as at the start
  bool any() const { return lights || !materials.empty() || !environment.empty() || seconds; }
  bool operator==(const SceneEdits&) const = default;
};

/// The scene as it was named at the start, with these edits.
using EditedScene = std::function<Scene(const SceneEdits&)>;

/// Throws Error{usage} that quotes what is malformed, or names a file: pages open none.
void check_scene_edits(const SceneEdits& edits);

/// `--light` for each: "none" first.
std::vector<std::string> light_words(const SceneEdits& edits);

/// As a sidecar file (docs/scenes.md).
std::string sidecar_text(const SceneEdits& edits, const std::string& camera);

/// What can be edited: {"lights": [{"text"}], "materials": [{"name", "base_color", …}], "environment", "animation",
/// "duration", "time"}, and what was: "edits": {"lights" or null, "materials", "environment"}
std::string describe_scene(const Scene& scene, const SceneEdits& edits);

}  // namespace lucarium
