// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>
#include <vector>

#include "lucarium/base/files/json_file.h"
#include "lucarium/scene/load/load_scene.h"

namespace lucarium {

/// Keys of the object that read_overrides() reads (docs/scenes.md).
const std::vector<std::string>& override_keys();
/// What the members of an object at `pointer` say about a scene; relative file names are resolved against the file's
/// folder.
SceneOverrides read_overrides(const JsonFile& file, const nlohmann::json& object, const std::string& pointer);

}  // namespace lucarium
