// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>
#include <vector>

#include "lucarium/scene/scene.h"

namespace lucarium {

/// A whole number that may be given behind the name of a built-in scene, as in "debris:pieces=500".
struct BuiltinParameter {
  std::string name, doc;
  int value, min, max;  ///< default and range
};

/// "cornell", "atrium", … without the "builtin:" prefix.
std::vector<std::string> builtin_scene_names();
/// What may be given behind a name; nothing of a scene that does not exist.
std::vector<BuiltinParameter> builtin_scene_parameters(const std::string& name);
/// From "NAME" or "NAME:key=value,…". Throws Error{usage} that names what may be given instead.
Scene make_builtin_scene(const std::string& text);

}  // namespace lucarium
