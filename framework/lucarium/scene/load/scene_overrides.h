// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "lucarium/scene/load/load_scene.h"

namespace lucarium {

// The strings in which users state things about a scene; docs/scenes.md is their manual. All functions throw
// Error{usage} that quotes the text and says the expected form.

/// A camera by name or index ("2"), or a new one ("ex,ey,ez:tx,ty,tz[:vfov_degrees]").
std::optional<SceneCamera> parse_look_at(std::string_view text);  ///< empty: it is not of that form, but a name

/// nullopt for "none".
std::optional<SceneLight> parse_light(std::string_view text);
/// The text that gives the light again, where it stands at the scene's time.
std::string light_text(const SceneLight& light);

struct EnvironmentChoice {
  bool none = false;           ///< remove the scene's own
  std::filesystem::path file;  ///< empty: constant
  glm::vec3 radiance{1};       ///< the constant [cd/m²]
  float factor = 1;
  float rotation_degrees = 0;  ///< about +Y, counter-clockwise seen from above
};
EnvironmentChoice parse_environment(std::string_view text);

struct MaterialEdit {
  std::string pattern;  ///< material name, * matches any text
  std::vector<std::pair<std::string, std::string>> values;
};
MaterialEdit parse_material(std::string_view text);
/// Checks key and value without a scene.
void check_material_value(const std::string& key, const std::string& value);
std::vector<std::string> material_keys();

/// Sets values of all materials that match.
void apply_material(Scene& scene, const MaterialEdit& edit);

/// Whether `name` matches `pattern`, in which * stands for any text.
bool matches_pattern(std::string_view name, std::string_view pattern);

/// `first`, over which `second` wins; lists are joined.
SceneOverrides merge_overrides(const SceneOverrides& first, const SceneOverrides& second);

/// The JSON file beside a scene, as overrides; relative file names in it are resolved against its folder. Throws
/// Error{input} naming file, line and key.
SceneOverrides read_sidecar(const std::filesystem::path& file);

}  // namespace lucarium
