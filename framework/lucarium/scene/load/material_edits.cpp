// SPDX-License-Identifier: Apache-2.0
// Material tweaks by name: one table of keys, used by the command line and by the JSON beside a scene. Declared in
// scene_overrides.h.
#include <fmt/ranges.h>

#include <algorithm>
#include <functional>
#include <limits>

#include "lucarium/base/error.h"
#include "lucarium/base/text/nearest_name.h"
#include "lucarium/base/text/spelling.h"
#include "lucarium/base/text/text_values.h"
#include "lucarium/scene/load/scene_overrides.h"

namespace lucarium {

namespace {

struct MaterialKey {
  const char* name;
  const char* expected;
  std::function<bool(SceneMaterial&, const std::string&)> set;  ///< false: the value is not as expected
};

MaterialKey number_key(const char* name, const char* expected, float SceneMaterial::*member, float low, float high) {
  return {name, expected, [=](SceneMaterial& material, const std::string& text) {
            const auto value = parse_number(text);
            if (!value || *value < low || *value > high) return false;
            material.*member = *value;
            return true;
          }};
}

MaterialKey color_key(const char* name, const char* expected, glm::vec3 SceneMaterial::*member, float high) {
  return {name, expected, [=](SceneMaterial& material, const std::string& text) {
            const auto value = parse_color(text);
            if (!value || std::max({value->r, value->g, value->b}) > high) return false;
            material.*member = *value;
            return true;
          }};
}

MaterialKey flag_key(const char* name, bool SceneMaterial::*member) {
  return {name, "true or false", [=](SceneMaterial& material, const std::string& text) {
            if (text != "true" && text != "false") return false;
            material.*member = text == "true";
            return true;
          }};
}

bool set_base_color(SceneMaterial& material, const std::string& text) {
  const auto v = parse_numbers(text);
  if (!v || (v->size() != 1 && v->size() != 3 && v->size() != 4)) return false;
  for (const float c : *v) {
    if (c < 0 || c > 1) return false;
  }
  const float alpha = v->size() == 4 ? (*v)[3] : material.base_color.a;
  material.base_color =
      v->size() == 1 ? glm::vec4(glm::vec3((*v)[0]), alpha) : glm::vec4((*v)[0], (*v)[1], (*v)[2], alpha);
  return true;
}

bool set_alpha_mode(SceneMaterial& material, const std::string& text) {
  if (text == "opaque")
    material.alpha_mode = AlphaMode::opaque;
  else if (text == "mask")
    material.alpha_mode = AlphaMode::mask;
  else if (text == "blend")
    material.alpha_mode = AlphaMode::blend;
  else
    return false;
  return true;
}

bool set_textures(SceneMaterial& material, const std::string& text) {
  if (text != "none") return false;
  for (TextureUse* use : {&material.base_color_texture, &material.metallic_roughness_texture, &material.normal_texture,
                          &material.emissive_texture, &material.transmission_texture}) {
    *use = {};
  }
  return true;
}

const std::vector<MaterialKey>& keys() {
  constexpr float infinity = std::numeric_limits<float>::infinity();
  static const std::vector<MaterialKey> table = {
      {"base_color", "R,G,B, R,G,B,A or one grey value, each 0 to 1", set_base_color},
      number_key("metallic", "a number from 0 to 1", &SceneMaterial::metallic, 0, 1),
      number_key("roughness", "a number from 0 to 1", &SceneMaterial::roughness, 0, 1),
      color_key("emissive_factor", "R,G,B or one grey value, not negative", &SceneMaterial::emissive_factor, infinity),
      number_key("emissive_strength", "a number that is not negative", &SceneMaterial::emissive_strength, 0, infinity),
      number_key("ior", "a number from 1 to 5", &SceneMaterial::ior, 1, 5),
      number_key("transmission", "a number from 0 to 1", &SceneMaterial::transmission, 0, 1),
      number_key("thickness", "a number that is not negative", &SceneMaterial::thickness, 0, infinity),
      number_key("attenuation_distance", "a positive number [m]", &SceneMaterial::attenuation_distance,
                 std::numeric_limits<float>::min(), infinity),
      color_key("attenuation_color", "R,G,B or one grey value, each 0 to 1", &SceneMaterial::attenuation_color, 1),
      {"alpha_mode", "opaque, mask or blend", set_alpha_mode},
      number_key("alpha_cutoff", "a number from 0 to 1", &SceneMaterial::alpha_cutoff, 0, 1),
      flag_key("double_sided", &SceneMaterial::double_sided),
      flag_key("unlit", &SceneMaterial::unlit),
      {"textures", "none, which removes them", set_textures},
  };
  return table;
}

void set_value(SceneMaterial& material, const std::string& key, const std::string& value) {
  const std::string american = american_spelling(key);
  for (const MaterialKey& known : keys()) {
    if (american != known.name) continue;
    if (known.set(material, value)) return;
    throw_error(ErrorClass::usage, "material value {}={}: expected {}", key, value, known.expected);
  }
  throw_error(ErrorClass::usage, "material key '{}' does not exist{}", key, suggest_name(american, material_keys()));
}

}  // namespace

std::vector<std::string> material_keys() {
  std::vector<std::string> names;
  for (const MaterialKey& key : keys()) names.emplace_back(key.name);
  return names;
}

void check_material_value(const std::string& key, const std::string& value) {
  SceneMaterial scratch;
  set_value(scratch, key, value);
}

MaterialEdit parse_material(std::string_view text) {
  MaterialEdit edit;
  // The name may hold colons; keys and values do not.
  const size_t first_equals = text.find('=');
  const size_t colon = text.substr(0, first_equals).rfind(':');
  if (first_equals == std::string_view::npos || colon == std::string_view::npos || colon == 0) {
    throw_error(ErrorClass::usage, "material '{}': expected NAME:key=value[,key=value]; keys are {}", text,
                fmt::join(material_keys(), ", "));
  }
  edit.pattern = std::string(text.substr(0, colon));
  // A piece without '=' continues the value before it ("base_color=.5,.4,.3").
  for (const std::string& piece : split(text.substr(colon + 1), ',')) {
    const size_t equals = piece.find('=');
    if (equals == std::string::npos && edit.values.empty()) {
      throw_error(ErrorClass::usage, "material '{}': expected key=value instead of '{}'", text, piece);
    }
    if (equals == std::string::npos) {
      edit.values.back().second += "," + piece;
    } else {
      edit.values.emplace_back(piece.substr(0, equals), piece.substr(equals + 1));
    }
  }
  for (const auto& [key, value] : edit.values) check_material_value(key, value);
  return edit;
}

void apply_material(Scene& scene, const MaterialEdit& edit) {
  bool found = false;
  std::vector<std::string> names;
  for (SceneMaterial& material : scene.materials) {
    names.push_back(material.name);
    if (!matches_pattern(material.name, edit.pattern)) continue;
    found = true;
    for (const auto& [key, value] : edit.values) set_value(material, key, value);
  }
  if (found) return;
  throw_error(ErrorClass::usage, "{}: no material is named '{}'{}", scene.source, edit.pattern,
              suggest_name(edit.pattern, names));
}

}  // namespace lucarium
