// SPDX-License-Identifier: Apache-2.0
#include "lucarium/scene/builtin/scenes.h"

#include <algorithm>
#include <charconv>
#include <functional>

#include "lucarium/base/error.h"
#include "lucarium/base/text/nearest_name.h"
#include "lucarium/base/text/text_values.h"
#include "lucarium/scene/builtin/builder.h"

namespace lucarium {

namespace {

struct BuiltinScene {
  std::string name;
  std::function<Scene(const std::vector<int>&)> make;  ///< from the values of its parameters
  std::vector<BuiltinParameter> parameters;
};

const std::vector<BuiltinScene>& builtin_scenes() {
  const auto fixed = [](auto make, auto... arguments) {
    return [=](const std::vector<int>&) { return make(arguments...); };
  };
  static const std::vector<BuiltinScene> scenes = {
      {"cornell", fixed(make_cornell, ""), {}},
      {"cornell-mirror", fixed(make_cornell, "mirror"), {}},
      {"cornell-glossy", fixed(make_cornell, "glossy"), {}},
      {"furnace", fixed(make_furnace), {}},
      {"room",
       [](const std::vector<int>& values) { return make_room(values[0]); },
       {{"lamp", "0 a point light, 1 a lamp of 4 cm, 2 a point light 2 cm from a wall, 3 a spot at the ceiling", 0, 0,
         3}}},
      {"fixture",
       [](const std::vector<int>& values) { return make_fixture(values[0]); },
       {{"lamp", "in the box: 0 a point light, 1 a lamp of 4 cm", 0, 0, 1}}},
      {"caustic", fixed(make_caustic), {}},
      {"statue",
       [](const std::vector<int>& values) { return make_statue(values[0], values[1]); },
       {{"levels", "subdivisions: 20 times 4 to that power triangles", 5, 0, 8},
        {"roughness", "of its bronze, in hundredths", 30, 0, 100}}},
      {"atrium", fixed(make_atrium), {}},
      {"lamps-1", fixed(make_lamps, 1), {}},
      {"lamps-10", fixed(make_lamps, 10), {}},
      {"lamps-100", fixed(make_lamps, 100), {}},
      {"picture-lamp", fixed(make_picture_lamp), {}},
      {"spheres", fixed(make_spheres), {}},
      {"mirror-hall", fixed(make_mirror_hall), {}},
      {"blocks",
       [](const std::vector<int>& values) { return make_blocks(values[0], values[1]); },
       {{"triangles", "of the whole scene, with a lamp of two; the blocks' area stays the same", 3000, 100, 10'000'000},
        {"lights", "triangles of the lamp, apart where they are not two; their area stays the same", 2, 1, 100'000}}},
      {"solids", fixed(make_solids), {}},
      {"debris",
       [](const std::vector<int>& values) { return make_debris(values[0]); },
       {{"pieces", "closed pieces, of about 50 triangles each", 4000, 1, 100'000}}},
  };
  return scenes;
}

const BuiltinScene* find_scene(const std::string& name) {
  for (const BuiltinScene& scene : builtin_scenes()) {
    if (scene.name == name) return &scene;
  }
  return nullptr;
}

/// Sets one parameter from "key=value".
void apply_assignment(const BuiltinScene& scene, const std::string& assignment, std::vector<int>& values) {
  const size_t equals = assignment.find('=');
  const std::string key = assignment.substr(0, equals);
  const auto found =
      std::find_if(scene.parameters.begin(), scene.parameters.end(), [&](const auto& p) { return p.name == key; });
  if (found == scene.parameters.end()) {
    std::vector<std::string> names;
    for (const BuiltinParameter& parameter : scene.parameters) names.push_back(parameter.name);
    throw_error(ErrorClass::usage, "builtin:{}: there is no parameter '{}'{}", scene.name, key,
                suggest_name(key, names));
  }
  const std::string text = equals == std::string::npos ? "" : assignment.substr(equals + 1);
  int value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (text.empty() || error != std::errc() || end != text.data() + text.size() || value < found->min ||
      value > found->max) {
    throw_error(ErrorClass::usage, "builtin:{}: {}='{}' is not a whole number from {} to {}; for example {}={}",
                scene.name, key, text, found->min, found->max, key, found->value);
  }
  values[static_cast<size_t>(found - scene.parameters.begin())] = value;
}

}  // namespace

std::vector<std::string> builtin_scene_names() {
  std::vector<std::string> names;
  for (const BuiltinScene& scene : builtin_scenes()) names.push_back(scene.name);
  return names;
}

std::vector<BuiltinParameter> builtin_scene_parameters(const std::string& name) {
  const BuiltinScene* scene = find_scene(name);
  return scene ? scene->parameters : std::vector<BuiltinParameter>{};
}

Scene make_builtin_scene(const std::string& text) {
  const size_t colon = text.find(':');
  const std::string name = text.substr(0, colon);
  const BuiltinScene* found = find_scene(name);
  if (!found) {
    throw_error(ErrorClass::usage, "builtin:{}: there is no such built-in scene{}", name,
                suggest_name(name, builtin_scene_names()));
  }
  if (colon != std::string::npos && found->parameters.empty()) {
    throw_error(ErrorClass::usage, "builtin:{}: this scene has no parameters; leave out '{}'", name,
                text.substr(colon));
  }
  std::vector<int> values;
  for (const BuiltinParameter& parameter : found->parameters) values.push_back(parameter.value);
  if (colon != std::string::npos) {
    for (const std::string& assignment : split(text.substr(colon + 1), ','))
      apply_assignment(*found, assignment, values);
  }
  Scene scene = found->make(values);
  scene.source = "builtin:" + text;
  return scene;
}

}  // namespace lucarium
