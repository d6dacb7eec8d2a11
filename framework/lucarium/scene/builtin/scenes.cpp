// SPDX-License-Identifier: Apache-2.0
#include "lucarium/scene/builtin/scenes.h"

#include <functional>

#include "lucarium/base/error.h"
#include "lucarium/base/nearest_name.h"
#include "lucarium/scene/builtin/builder.h"

namespace lucarium {

namespace {

struct BuiltinScene {
  const char* name;
  std::function<Scene()> make;
};

const std::vector<BuiltinScene>& builtin_scenes() {
  static const std::vector<BuiltinScene> scenes = {
      {"cornell", [] { return make_cornell(""); }},
      {"cornell-mirror", [] { return make_cornell("mirror"); }},
      {"cornell-glossy", [] { return make_cornell("glossy"); }},
      {"furnace", make_furnace},
      {"room", make_room},
      {"atrium", make_atrium},
      {"lamps-1", [] { return make_lamps(1); }},
      {"lamps-10", [] { return make_lamps(10); }},
      {"lamps-100", [] { return make_lamps(100); }},
      {"picture-lamp", make_picture_lamp},
      {"spheres", make_spheres},
  };
  return scenes;
}

}  // namespace

std::vector<std::string> builtin_scene_names() {
  std::vector<std::string> names;
  for (const BuiltinScene& scene : builtin_scenes()) names.emplace_back(scene.name);
  return names;
}

Scene make_builtin_scene(const std::string& name) {
  for (const BuiltinScene& builtin : builtin_scenes()) {
    if (name != builtin.name) continue;
    Scene scene = builtin.make();
    scene.source = "builtin:" + name;
    return scene;
  }
  throw_error(ErrorClass::usage, "builtin:{}: there is no such built-in scene{}", name,
              suggest_name(name, builtin_scene_names()));
}

}  // namespace lucarium
