// SPDX-License-Identifier: Apache-2.0
#include "lucarium/services/path_set.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "lucarium/base/error.h"
#include "lucarium/base/text/nearest_name.h"
#include "lucarium/scene/scene.h"

namespace lucarium {
namespace {

/// Visits (key, value) of every field: the one list of them. V is called with a reference to bool, int or double.
template <class Set, class V>
void visit_fields(Set& set, V&& visit) {
  visit("max_bounces", set.max_bounces);
  visit("emission", set.emission);
  visit("direct", set.direct);
  visit("indirect", set.indirect);
  visit("point_lights", set.point_lights);
  visit("spot_lights", set.spot_lights);
  visit("directional_lights", set.directional_lights);
  visit("emissive_triangles", set.emissive_triangles);
  visit("environment", set.environment);
  visit("eye_deltas", set.eye_deltas);
  visit("light_delta", set.light_delta);
  visit("secondary_lambert_only", set.secondary_lambert_only);
  visit("geometric_normals", set.geometric_normals);
  visit("blend", set.blend);
  visit("indirect_clamp", set.indirect_clamp);
}

std::string text_of(bool value) { return value ? "on" : "off"; }
std::string text_of(int value) { return std::to_string(value); }
std::string text_of(double value) { return fmt::format("{}", value); }  // reads back as the same

bool parse_value(std::string_view text, bool& value) {
  value = text == "on";
  return text == "on" || text == "off";
}
template <class T>
bool parse_value(std::string_view text, T& value) {
  const auto [end, failure] = std::from_chars(text.data(), text.data() + text.size(), value);
  return failure == std::errc() && end == text.data() + text.size();
}

const char* values_of(bool) { return "on or off"; }
const char* values_of(int) { return "a whole number"; }
const char* values_of(double) { return "a number"; }

/// Throws a usage error for numbers that no path set can have (NaN fails every comparison).
void check_ranges(const PathSet& set) {
  if (set.max_bounces < -1 || set.max_bounces > PathSet::kMaxBounces)
    throw_error(ErrorClass::usage, "path set: max_bounces {} is not -1 (unlimited) or 0 to {}", set.max_bounces,
                PathSet::kMaxBounces);
  if (set.eye_deltas < -1 || set.eye_deltas > PathSet::kMaxEyeDeltas)
    throw_error(ErrorClass::usage, "path set: eye_deltas {} is not -1 (unlimited) or 0 to {}", set.eye_deltas,
                PathSet::kMaxEyeDeltas);
  if (!(set.indirect_clamp >= 0 && std::isfinite(set.indirect_clamp)))
    throw_error(ErrorClass::usage, "path set: indirect_clamp {} is not a finite radiance of at least 0",
                set.indirect_clamp);
}

std::vector<std::pair<std::string, std::string>> fields(const PathSet& set) {
  std::vector<std::pair<std::string, std::string>> list;
  visit_fields(set, [&](const char* key, const auto& value) { list.emplace_back(key, text_of(value)); });
  return list;
}

}  // namespace

std::string PathSet::to_string() const {
  std::string text;
  for (const auto& [key, value] : fields(*this)) text += fmt::format("{}{}={}", text.empty() ? "" : ",", key, value);
  return text;
}

PathSet PathSet::parse(const std::string& text) {
  PathSet set;
  for (size_t begin = 0; begin < text.size();) {
    const size_t end = std::min(text.find(',', begin), text.size());
    const std::string item = text.substr(begin, end - begin);
    const size_t equals = item.find('=');
    const std::string key = item.substr(0, equals), value = equals == std::string::npos ? "" : item.substr(equals + 1);
    bool known = false, valid = false;
    const char* expected = "";
    std::vector<std::string> keys;
    visit_fields(set, [&](const char* name, auto& field) {
      keys.emplace_back(name);
      if (key != name) return;
      known = true;
      valid = parse_value(value, field);
      expected = values_of(field);
    });
    if (!known) throw_error(ErrorClass::usage, "path set: no key is called '{}'{}", key, suggest_name(key, keys));
    if (!valid) throw_error(ErrorClass::usage, "path set: '{}' is not a value of {}: {}", value, key, expected);
    begin = end + 1;
  }
  check_ranges(set);
  return set;
}

std::vector<std::pair<std::string, std::string>> PathSet::technique_parameters() const {
  auto list = fields(*this);
  list.erase(list.begin());  // max_bounces
  return list;
}

PathSet PathSet::simplified(const Scene& scene) const {
  PathSet set = *this;
  if (set.max_bounces == 0 && set.light_transport()) set.indirect = true;
  const auto any_material = [&](auto&& has) {
    return std::any_of(scene.materials.begin(), scene.materials.end(), has);
  };
  if (!any_material([](const SceneMaterial& m) { return m.has_specular_lobes(); })) set.secondary_lambert_only = false;
  if (!any_material([](const SceneMaterial& m) { return m.may_be_ideal(); })) {
    set.light_delta = true;
    set.eye_deltas = -1;
  }
  if (!any_material([](const SceneMaterial& m) { return m.alpha_mode == AlphaMode::blend; })) set.blend = true;
  if (!any_material([](const SceneMaterial& m) { return m.emits(); })) set.emissive_triangles = true;
  const auto no_light = [&](LightType type) {
    return std::none_of(scene.lights.begin(), scene.lights.end(), [&](const SceneLight& l) { return l.type == type; });
  };
  if (no_light(LightType::point)) set.point_lights = true;
  if (no_light(LightType::spot)) set.spot_lights = true;
  if (no_light(LightType::directional)) set.directional_lights = true;
  if (!scene.environment) set.environment = true;
  return set;
}

std::vector<std::string> PathSet::differences(const PathSet& other) const {
  const auto mine = fields(*this), theirs = fields(other);
  std::vector<std::string> lines;
  for (size_t i = 0; i < mine.size(); ++i) {
    if (mine[i].second == theirs[i].second) continue;
    lines.push_back(fmt::format("{}: {} against {}", mine[i].first, mine[i].second, theirs[i].second));
  }
  return lines;
}

}  // namespace lucarium
