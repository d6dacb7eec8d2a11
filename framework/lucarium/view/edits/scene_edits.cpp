// SPDX-License-Identifier: Apache-2.0
#include "lucarium/view/edits/scene_edits.h"

#include "lucarium/base/error.h"
#include "lucarium/base/json.h"
#include "lucarium/scene/load/scene_overrides.h"

namespace lucarium {

using nlohmann::ordered_json;

namespace {

constexpr size_t max_materials = 400;  // in a message

ordered_json to_json(const glm::vec3& v) { return {v.x, v.y, v.z}; }

ordered_json describe_material(const SceneMaterial& material) {
  return {{"name", material.name},
          {"base_color", to_json(glm::vec3(material.base_color))},
          {"metallic", material.metallic},
          {"roughness", material.roughness},
          {"emissive_factor", to_json(material.emissive_factor)},
          {"emissive_strength", material.emissive_strength},
          {"transmission", material.transmission},
          {"ior", material.ior}};
}

}  // namespace

void check_scene_edits(const SceneEdits& edits) {
  if (edits.lights)
    for (const std::string& light : *edits.lights) parse_light(light);
  for (const std::string& material : edits.materials) parse_material(material);
  if (!edits.environment.empty() && !parse_environment(edits.environment).file.empty())
    throw_error(ErrorClass::usage, "an environment is R,G,B or none here: the page opens no file");
}

std::vector<std::string> light_words(const SceneEdits& edits) {
  if (!edits.lights) return {};
  std::vector<std::string> words = {"none"};
  words.insert(words.end(), edits.lights->begin(), edits.lights->end());
  return words;
}

std::string sidecar_text(const SceneEdits& edits, const std::string& camera) {
  ordered_json sidecar = ordered_json::object();
  if (!camera.empty()) sidecar["camera"] = camera;
  if (!edits.environment.empty()) sidecar["environment"] = edits.environment;
  if (edits.lights) sidecar["lights"] = light_words(edits);
  if (edits.seconds) sidecar["at_seconds"] = *edits.seconds;
  ordered_json materials = ordered_json::object();
  for (const std::string& text : edits.materials) {
    const MaterialEdit edit = parse_material(text);
    for (const auto& [key, value] : edit.values) materials[edit.pattern][key] = value;
  }
  if (!materials.empty()) sidecar["materials"] = std::move(materials);
  return sidecar.dump(2) + "\n";
}

std::string describe_scene(const Scene& scene, const SceneEdits& edits) {
  ordered_json lights = ordered_json::array(), materials = ordered_json::array();
  for (const SceneLight& light : scene.lights)
    lights.push_back({{"name", light.node == none ? "" : light.name}, {"text", light_text(light)}});
  for (size_t i = 0; i < std::min(scene.materials.size(), max_materials); ++i)
    materials.push_back(describe_material(scene.materials[i]));
  ordered_json json = {{"lights", std::move(lights)}, {"materials", std::move(materials)}};
  json["environment"] = !scene.environment ? "none" : edits.environment.empty() ? "" : edits.environment;
  json["edits"] = {{"lights", edits.lights ? ordered_json(*edits.lights) : ordered_json(nullptr)},
                   {"materials", edits.materials},
                   {"environment", edits.environment}};
  json["time"] = scene.time;
  const bool moves = scene.animation >= 0 && static_cast<size_t>(scene.animation) < scene.animations.size();
  json["duration"] = moves ? scene.animations[static_cast<size_t>(scene.animation)].duration : 0.0;
  return ordered_json{{"scene", json}}.dump(-1, ' ', false, ordered_json::error_handler_t::replace);
}

}  // namespace lucarium
