// SPDX-License-Identifier: Apache-2.0
#include "lucarium/scene/load/camera_path_text.h"

#include <fmt/ranges.h>

#include <charconv>
#include <cmath>
#include <filesystem>

#include "lucarium/base/error.h"
#include "lucarium/base/files/missing_file.h"
#include "lucarium/base/text/nearest_name.h"
#include "lucarium/base/text/text_values.h"
#include "lucarium/scene/scene.h"

namespace lucarium {

namespace {

using nlohmann::json;

std::optional<CameraPath::Interpolation> interpolation_of(std::string_view name) {
  for (const auto kind : {CameraPath::Interpolation::linear, CameraPath::Interpolation::spline})
    if (interpolation_name(kind) == name) return kind;
  return std::nullopt;
}

std::optional<double> parse_seconds(const std::string& text) {
  double value = 0;
  const auto [end, failure] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (failure != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

/// SECONDS@EX,EY,EZ:TX,TY,TZ[:VFOV]
std::optional<CameraKey> parse_key(const std::string& text) {
  const size_t at = text.find('@');
  if (at == std::string::npos) return std::nullopt;
  const std::optional<double> seconds = parse_seconds(text.substr(0, at));
  const std::vector<std::string> parts = split(std::string_view(text).substr(at + 1), ':');
  if (!seconds || parts.size() < 2 || parts.size() > 3) return std::nullopt;
  const auto eye = parse_point(parts[0]), target = parse_point(parts[1]);
  const std::optional<float> vfov = parts.size() == 3 ? parse_number(parts[2]) : CameraKey{}.vfov_degrees;
  if (!eye || !target || !vfov) return std::nullopt;
  return CameraKey{*seconds, *eye, *target, *vfov};
}

glm::vec3 point(const JsonFile& file, const json& object, const std::string& pointer, const char* key) {
  if (!object.contains(key)) file.fail(pointer, fmt::format("\"{}\" is missing", key));
  const std::string at = pointer + "/" + key;
  const json& list = object[key];
  if (!list.is_array() || list.size() != 3) file.fail(at, "must be three numbers");
  glm::vec3 result;
  for (int i = 0; i < 3; ++i)
    result[i] = static_cast<float>(file.number(list[static_cast<size_t>(i)], at + "/" + std::to_string(i)));
  return result;
}

CameraKey read_key(const JsonFile& file, const json& object, const std::string& pointer) {
  file.check_keys(object, pointer, {"seconds", "eye", "target", "vfov_degrees"});
  CameraKey key;
  if (!object.contains("seconds")) file.fail(pointer, "\"seconds\" is missing");
  key.seconds = file.number(object["seconds"], pointer + "/seconds");
  key.eye = point(file, object, pointer, "eye");
  key.target = point(file, object, pointer, "target");
  if (object.contains("vfov_degrees"))
    key.vfov_degrees = static_cast<float>(file.number(object["vfov_degrees"], pointer + "/vfov_degrees"));
  return key;
}

}  // namespace

std::optional<CameraPath> parse_camera_path(std::string_view text) {
  const size_t colon = text.find(':');
  const auto kind = colon == std::string_view::npos ? std::nullopt : interpolation_of(text.substr(0, colon));
  if (!kind) return std::nullopt;
  CameraPath path{.name = "", .interpolation = *kind, .keys = {}};
  for (const std::string& key : split(text.substr(colon + 1), ';')) {
    const std::optional<CameraKey> parsed = parse_key(key);
    if (!parsed)
      throw_error(ErrorClass::usage, "camera path: '{}' is not SECONDS@EX,EY,EZ:TX,TY,TZ[:VFOV] with finite numbers",
                  key);
    path.keys.push_back(*parsed);
  }
  if (const std::string mistake = camera_path_mistake(path); !mistake.empty())
    throw_error(ErrorClass::usage, "camera path: {}", mistake);
  return path;
}

std::string camera_path_text(const CameraPath& path) {
  std::vector<std::string> keys;
  for (const CameraKey& key : path.keys) keys.push_back(fmt::format("{}@{}", key.seconds, camera_text(key)));
  return fmt::format("{}:{}", interpolation_name(path.interpolation), fmt::join(keys, ";"));
}

CameraPath read_camera_path(const JsonFile& file, const json& object, const std::string& pointer) {
  file.check_keys(object, pointer, {"interpolation", "keys"});
  CameraPath path;
  if (object.contains("interpolation")) {
    const std::string at = pointer + "/interpolation";
    const auto kind = interpolation_of(file.text(object["interpolation"], at));
    if (!kind) file.fail(at, "must be \"linear\" or \"spline\"");
    path.interpolation = *kind;
  }
  if (!object.contains("keys") || !object["keys"].is_array()) file.fail(pointer + "/keys", "must be an array of keys");
  const json& keys = object["keys"];
  for (size_t i = 0; i < keys.size(); ++i)
    path.keys.push_back(read_key(file, keys[i], fmt::format("{}/keys/{}", pointer, i)));
  if (const std::string mistake = camera_path_mistake(path); !mistake.empty()) file.fail(pointer + "/keys", mistake);
  return path;
}

std::optional<CameraPath> find_camera_path(const Scene& scene, const std::string& text) {
  if (text == "none") return std::nullopt;
  std::vector<std::string> names;
  for (const CameraPath& path : scene.camera_paths) {
    if (path.name == text) return path;
    names.push_back(path.name);
  }
  if (auto path = parse_camera_path(text)) return path;
  std::error_code ignored;
  if (!std::filesystem::exists(text, ignored)) {
    if (text.find('@') != std::string::npos)  // of a key
      throw_error(ErrorClass::usage, "camera path: '{}' begins neither with linear: nor with spline:, nor is it a file",
                  text);
    const std::string advice = nearest_name(text, names).empty() ? advice_for_missing(text) : "";
    if (names.empty() || !advice.empty())
      throw_error(ErrorClass::input, "{}: no such file of a camera path{}", text,
                  advice.empty() ? fmt::format("; {} brings none by name", scene.source) : advice);
    throw_error(ErrorClass::usage, "{}: there is no camera path '{}', nor such a file{}", scene.source, text,
                suggest_name(text, names));
  }
  const JsonFile file(text);
  return read_camera_path(file, file.root(), "");
}

}  // namespace lucarium
