// SPDX-License-Identifier: Apache-2.0
#include "lucarium/scene/load/scene_overrides.h"

#include "lucarium/base/error.h"
#include "lucarium/base/text/nearest_name.h"
#include "lucarium/base/text/text_values.h"
#include "lucarium/scene/builtin/builder.h"

namespace lucarium {

namespace {

/// Cuts "<mark><number>" off the end of the text when it is there.
std::optional<float> take_suffix(std::string_view& text, char mark) {
  const size_t at = text.rfind(mark);
  if (at == std::string_view::npos) return std::nullopt;
  const std::optional<float> value = parse_number(text.substr(at + 1));
  if (value) text = text.substr(0, at);
  return value;
}

}  // namespace

std::optional<SceneCamera> parse_look_at(std::string_view text) {
  const std::vector<std::string> parts = split(text, ':');
  if (parts.size() != 2 && parts.size() != 3) return std::nullopt;
  const auto eye = parse_point(parts[0]), target = parse_point(parts[1]);
  if (!eye || !target) return std::nullopt;
  const std::optional<float> vfov = parts.size() == 3 ? parse_number(parts[2]) : 40.f;
  if (!vfov || *vfov <= 0 || *vfov >= 180) {
    throw_error(ErrorClass::usage, "camera '{}': the vertical field of view must be between 0 and 180 degrees", text);
  }
  if (*eye == *target) throw_error(ErrorClass::usage, "camera '{}': eye and target are the same point", text);
  return look_at_camera("look-at", *eye, *target, *vfov);
}

std::optional<SceneLight> parse_light(std::string_view text) {
  if (text == "none") return std::nullopt;
  const std::vector<std::string> parts = split(text, ':');
  SceneLight light;
  light.name = std::string(text);
  const std::string& kind = parts[0];
  std::optional<glm::vec3> position = glm::vec3(0), direction = glm::vec3(0, -1, 0), intensity;
  bool well_formed = false;
  if (kind == "point" && parts.size() == 3) {
    light.type = LightType::point;
    position = parse_point(parts[1]), intensity = parse_color(parts[2]);
    well_formed = true;
  } else if (kind == "directional" && parts.size() == 3) {
    light.type = LightType::directional;
    direction = parse_point(parts[1]), intensity = parse_color(parts[2]);
    well_formed = true;
  } else if (kind == "spot" && parts.size() >= 4 && parts.size() <= 6) {
    light.type = LightType::spot;
    position = parse_point(parts[1]), direction = parse_point(parts[2]), intensity = parse_color(parts[3]);
    const std::optional<float> outer = parts.size() > 4 ? parse_number(parts[4]) : 45.f;
    const std::optional<float> inner = parts.size() > 5 ? parse_number(parts[5]) : 0.f;
    well_formed = outer && inner && 0 <= *inner && *inner < *outer && *outer <= 90;
    if (well_formed) light.outer_angle = glm::radians(*outer), light.inner_angle = glm::radians(*inner);
  }
  if (!well_formed || !position || !direction || !intensity || *direction == glm::vec3(0)) {
    throw_error(ErrorClass::usage,
                "light '{}': expected point:X,Y,Z:R,G,B [cd], directional:DX,DY,DZ:R,G,B [lx], "
                "spot:X,Y,Z:DX,DY,DZ:R,G,B[:OUTER_DEGREES[:INNER_DEGREES]] [cd] with 0 <= inner < outer <= 90, or none",
                text);
  }
  light.intensity = *intensity;
  light.world_from_light = frame_along(*position, *direction);
  return light;
}

std::string light_text(const SceneLight& light) {
  const auto text = [](const glm::vec3& v) { return fmt::format("{},{},{}", v.x, v.y, v.z); };
  const std::string position = text(glm::vec3(light.world_from_light[3])), intensity = text(light.intensity),
                    direction = text(-glm::normalize(glm::vec3(light.world_from_light[2])));
  switch (light.type) {
    case LightType::point: return fmt::format("point:{}:{}", position, intensity);
    case LightType::directional: return fmt::format("directional:{}:{}", direction, intensity);
    case LightType::spot: break;
  }
  return fmt::format("spot:{}:{}:{}:{}:{}", position, direction, intensity, glm::degrees(light.outer_angle),
                     glm::degrees(light.inner_angle));
}

EnvironmentChoice parse_environment(std::string_view text) {
  EnvironmentChoice choice;
  if (text == "none") {
    choice.none = true;
    return choice;
  }
  std::string_view rest = text;
  choice.rotation_degrees = take_suffix(rest, '@').value_or(0.f);
  choice.factor = take_suffix(rest, '*').value_or(1.f);
  if (rest.empty() || choice.factor < 0) {
    throw_error(ErrorClass::usage,
                "environment '{}': expected FILE.hdr, FILE.exr, R,G,B [cd/m2] or none, optionally followed by *FACTOR "
                "(not negative) and @DEGREES",
                text);
  }
  if (const auto color = parse_color(rest)) {
    choice.radiance = *color;
  } else if (parse_numbers(rest)) {
    throw_error(ErrorClass::usage, "environment '{}': a color is R,G,B or one number for all three, none negative",
                text);
  } else {
    choice.file = std::string(rest);
  }
  return choice;
}

bool matches_pattern(std::string_view name, std::string_view pattern) {
  // Greedy matching with one point to come back to: the last star.
  size_t n = 0, p = 0, star = std::string_view::npos, resume = 0;
  while (n < name.size()) {
    if (p < pattern.size() && pattern[p] == '*') {
      star = p++;
      resume = n;
    } else if (p < pattern.size() && pattern[p] == name[n]) {
      ++p, ++n;
    } else if (star != std::string_view::npos) {
      p = star + 1;
      n = ++resume;
    } else {
      return false;
    }
  }
  while (p < pattern.size() && pattern[p] == '*') ++p;
  return p == pattern.size();
}

SceneOverrides merge_overrides(const SceneOverrides& first, const SceneOverrides& second) {
  SceneOverrides result = first;
  if (second.camera) result.camera = second.camera, result.camera_path.reset();  // which would hide it
  if (second.camera_path) result.camera_path = second.camera_path;
  if (second.environment) result.environment = second.environment;
  if (second.exposure) result.exposure = second.exposure;
  if (second.at_seconds) result.at_seconds = second.at_seconds;
  if (second.animation) result.animation = second.animation;
  result.lights.insert(result.lights.end(), second.lights.begin(), second.lights.end());
  result.materials.insert(result.materials.end(), second.materials.begin(), second.materials.end());
  return result;
}

}  // namespace lucarium
