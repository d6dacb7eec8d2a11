// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>
#include <vector>

#include "lucarium/scene/scene.h"

namespace lucarium {

/// "cornell", "atrium", … without the "builtin:" prefix.
std::vector<std::string> builtin_scene_names();
Scene make_builtin_scene(const std::string& name);

}  // namespace lucarium
