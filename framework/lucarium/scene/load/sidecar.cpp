// SPDX-License-Identifier: Apache-2.0
// FILE.lucarium.json: turned into the same strings that the command line takes, so that each form is defined once.
#include "lucarium/scene/load/sidecar.h"

#include <fmt/ranges.h>

#include "lucarium/base/error.h"
#include "lucarium/base/files/json_file.h"
#include "lucarium/scene/exposure.h"
#include "lucarium/scene/load/camera_path_text.h"
#include "lucarium/scene/load/scene_overrides.h"

namespace lucarium {

namespace {

using nlohmann::json;

/// Reads the members of one object that say something about a scene; complaints name file, line and key.
class OverridesReader {
 public:
  OverridesReader(const JsonFile& file, std::string prefix) : file_(file), prefix_(std::move(prefix)) {}

  SceneOverrides read(const json& root) {
    SceneOverrides result;
    if (root.contains("camera")) result.camera = camera(root["camera"]);
    if (root.contains("camera_path")) result.camera_path = camera_path(root["camera_path"]);
    if (root.contains("environment")) result.environment = environment(root["environment"]);
    if (root.contains("lights")) result.lights = lights(root["lights"]);
    if (root.contains("exposure")) result.exposure = exposure(root["exposure"]);
    if (root.contains("at_seconds")) result.at_seconds = number(root["at_seconds"], "/at_seconds");
    if (root.contains("animation")) result.animation = name_or_index(root["animation"], "/animation");
    if (root.contains("materials")) result.materials = materials(root["materials"]);
    return result;
  }

 private:
  [[noreturn]] void fail(const std::string& pointer, const std::string& what) const {
    file_.fail(prefix_ + pointer, what);
  }
  void check_keys(const json& object, const std::string& pointer, const std::vector<std::string>& allowed) const {
    file_.check_keys(object, prefix_ + pointer, allowed);
  }
  double number(const json& value, const std::string& pointer) const { return file_.number(value, prefix_ + pointer); }

  /// Runs `check`, turning its complaint into one about this place.
  template <class F>
  void checked(const std::string& pointer, F&& check) const {
    try {
      check();
    } catch (const Error& error) {
      fail(pointer, error.what());
    }
  }

  float exposure(const json& value) const {
    if (value == "auto") return exposure_automatic;
    if (!value.is_number()) fail("/exposure", "must be a number of stops or \"auto\"");
    return static_cast<float>(number(value, "/exposure"));
  }

  std::string name_or_index(const json& value, const std::string& pointer) const {
    if (value.is_string()) return value.get<std::string>();
    if (value.is_number_unsigned()) return std::to_string(value.get<uint64_t>());
    fail(pointer, "must be a name or an index");
  }

  /// A number, or an array of numbers, as the command line writes it.
  std::string numbers(const json& value, const std::string& pointer) const {
    if (value.is_number()) return fmt::format("{}", value.get<double>());
    if (!value.is_array() || value.empty()) fail(pointer, "must be a number or an array of numbers");
    std::vector<double> list;
    for (size_t i = 0; i < value.size(); ++i) list.push_back(number(value[i], pointer + "/" + std::to_string(i)));
    return fmt::format("{}", fmt::join(list, ","));
  }

  std::string member(const json& object, const std::string& pointer, const std::string& key) const {
    if (!object.contains(key)) fail(pointer, fmt::format("\"{}\" is missing", key));
    return numbers(object[key], pointer + "/" + key);
  }

  std::string camera(const json& value) const {
    if (!value.is_object()) return name_or_index(value, "/camera");
    check_keys(value, "/camera", {"eye", "target", "vfov_degrees"});
    std::string text = member(value, "/camera", "eye") + ":" + member(value, "/camera", "target");
    if (value.contains("vfov_degrees")) text += ":" + member(value, "/camera", "vfov_degrees");
    checked("/camera", [&] {
      if (!parse_look_at(text)) throw_error(ErrorClass::usage, "eye and target must be three numbers each");
    });
    return text;
  }

  /// An object becomes the text of it; of a text, files are relative to this one.
  std::string camera_path(const json& value) const {
    if (value.is_object()) return camera_path_text(read_camera_path(file_, value, prefix_ + "/camera_path"));
    const std::string text = file_.text(value, prefix_ + "/camera_path");
    bool inline_path = false;
    checked("/camera_path", [&] { inline_path = parse_camera_path(text).has_value(); });
    const std::filesystem::path beside = file_.path().parent_path() / text;
    std::error_code ignored;
    return !inline_path && std::filesystem::exists(beside, ignored) ? beside.string() : text;
  }

  std::string environment(const json& value) const {
    std::string text;
    if (value.is_string()) {
      text = value.get<std::string>();
    } else {
      check_keys(value, "/environment", {"file", "radiance", "factor", "rotation_degrees"});
      if (value.contains("file") == value.contains("radiance")) {
        fail("/environment", "needs either \"file\" or \"radiance\"");
      }
      if (value.contains("file") && !value["file"].is_string()) fail("/environment/file", "must be a file name");
      text = value.contains("file") ? value["file"].get<std::string>() : member(value, "/environment", "radiance");
      if (value.contains("factor")) text += "*" + member(value, "/environment", "factor");
      if (value.contains("rotation_degrees")) text += "@" + member(value, "/environment", "rotation_degrees");
    }
    EnvironmentChoice choice;
    checked("/environment", [&] { choice = parse_environment(text); });
    if (choice.file.empty() || choice.file.is_absolute()) return text;
    return (file_.path().parent_path() / text).string();
  }

  std::string light(const json& value, const std::string& pointer) const {
    std::string text;
    if (value.is_string()) {
      text = value.get<std::string>();
    } else {
      check_keys(value, pointer, {"type", "position", "direction", "intensity", "outer_degrees", "inner_degrees"});
      const std::string type = value.contains("type") && value["type"].is_string() ? value["type"] : json("");
      if (type != "point" && type != "spot" && type != "directional") {
        fail(pointer + "/type", "must be \"point\", \"spot\" or \"directional\"");
      }
      text = type;
      if (type != "directional") text += ":" + member(value, pointer, "position");
      if (type != "point") text += ":" + member(value, pointer, "direction");
      text += ":" + member(value, pointer, "intensity");
      if (value.contains("outer_degrees")) text += ":" + member(value, pointer, "outer_degrees");
      if (value.contains("inner_degrees")) {
        if (!value.contains("outer_degrees")) text += ":45";
        text += ":" + member(value, pointer, "inner_degrees");
      }
    }
    checked(pointer, [&] { parse_light(text); });
    return text;
  }

  std::vector<std::string> lights(const json& value) const {
    if (!value.is_array()) fail("/lights", "must be an array");
    std::vector<std::string> result;
    for (size_t i = 0; i < value.size(); ++i) result.push_back(light(value[i], "/lights/" + std::to_string(i)));
    return result;
  }

  std::vector<std::string> materials(const json& value) const {
    std::vector<std::string> result;
    if (value.is_array()) {
      for (size_t i = 0; i < value.size(); ++i) {
        const std::string pointer = "/materials/" + std::to_string(i);
        result.push_back(file_.text(value[i], prefix_ + pointer));
        checked(pointer, [&] { parse_material(result.back()); });
      }
      return result;
    }
    if (!value.is_object()) fail("/materials", "must be an object {\"NAME\": {\"key\": value}}");
    for (const auto& [name, edits] : value.items()) {
      const std::string pointer = "/materials/" + name;
      check_keys(edits, pointer, material_keys());
      std::vector<std::string> pairs;
      for (const auto& [key, edit] : edits.items()) {
        std::string text;
        if (edit.is_boolean())
          text = edit.get<bool>() ? "true" : "false";
        else
          text = edit.is_string() ? edit.get<std::string>() : numbers(edit, pointer + "/" + key);
        checked(pointer + "/" + key, [&, &name_of = key] { check_material_value(name_of, text); });
        pairs.push_back(key + "=" + text);
      }
      if (!pairs.empty()) result.push_back(fmt::format("{}:{}", name, fmt::join(pairs, ",")));
    }
    return result;
  }

  const JsonFile& file_;
  std::string prefix_;
};

}  // namespace

const std::vector<std::string>& override_keys() {
  static const std::vector<std::string> keys = {"camera",   "camera_path", "environment", "lights",
                                                "exposure", "at_seconds",  "animation",   "materials"};
  return keys;
}

SceneOverrides read_overrides(const JsonFile& file, const json& object, const std::string& pointer) {
  return OverridesReader(file, pointer).read(object);
}

SceneOverrides read_sidecar(const std::filesystem::path& path) {
  const JsonFile file(path);
  file.check_keys(file.root(), "", override_keys());
  return read_overrides(file, file.root(), "");
}

}  // namespace lucarium
