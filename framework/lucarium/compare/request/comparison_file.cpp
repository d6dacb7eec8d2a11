// SPDX-License-Identifier: Apache-2.0
// Reading a comparison file; every complaint names file, line and key.
#include "lucarium/compare/request/comparison_file.h"

#include <tuple>

#include "lucarium/base/error.h"
#include "lucarium/base/request_limits.h"
#include "lucarium/compare/request/comparison_spec.h"
#include "lucarium/compare/request/device_arguments.h"
#include "lucarium/scene/load/sidecar.h"
#include "lucarium/services/path_set.h"
#include "lucarium/session/walk.h"

namespace lucarium {
namespace fs = std::filesystem;
using nlohmann::json;

namespace {

class ComparisonReader {
 public:
  ComparisonReader(const JsonFile& file, const json& object, std::string pointer)
      : file_(file), object_(object), pointer_(std::move(pointer)) {}

  ComparisonSpec read() const {
    const json& root = object_;
    file_.check_keys(root, pointer_,
                     {"scenes", "techniques", "budgets", "seeds", "size", "max_bounces", "pixel_sampling", "reference",
                      "walk", "fallback_environment", "device_arguments"});
    ComparisonSpec spec;
    each("scenes", [&](const json& value, const std::string& at) { spec.scenes.push_back(scene(value, at)); });
    each("techniques",
         [&](const json& value, const std::string& at) { spec.variants.push_back(technique(value, at)); });
    each("budgets", [&](const json& value, const std::string& at) { spec.budgets.push_back(budget(value, at)); });
    if (root.contains("seeds")) spec.seeds = static_cast<uint32_t>(bounded(root, "seeds", pointer_, 1, 1000));
    if (root.contains("size")) std::tie(spec.width, spec.height) = size(root["size"], place("size"));
    if (root.contains("max_bounces"))
      spec.max_bounces = static_cast<int>(bounded(root, "max_bounces", pointer_, -1, PathSet::kMaxBounces));
    if (root.contains("pixel_sampling"))
      spec.pixel_sampling = static_cast<uint32_t>(bounded(root, "pixel_sampling", pointer_, 0, finest_pixel_grid));
    if (root.contains("reference")) spec.reference = reference(root["reference"]);
    if (root.contains("walk")) spec.walk = walk(root["walk"]);
    if (root.contains("fallback_environment")) {
      spec.fallback_environment = file_.text(root["fallback_environment"], place("fallback_environment"));
      if (const std::string what = fallback_mistake(spec.fallback_environment); !what.empty()) {
        file_.fail(place("fallback_environment"), what);
      }
    }
    if (root.contains("device_arguments")) {
      each("device_arguments",
           [&](const json& value, const std::string& at) { spec.device_arguments.push_back(file_.text(value, at)); });
      DeviceOptions unused;
      if (const auto mistake = read_device_arguments(spec.device_arguments, unused)) {
        file_.fail(fmt::format("{}/{}", place("device_arguments"), mistake->index), mistake->what);
      }
    }
    return spec;
  }

 private:
  std::string place(const std::string& key) const { return pointer_ + "/" + key; }

  /// Calls visit(element, pointer) for the elements of the array `key`, which must hold one at least.
  template <class Visit>
  void each(const std::string& key, Visit&& visit) const {
    if (!object_.contains(key) || !object_[key].is_array() || object_[key].empty()) {
      file_.fail(place(key), "must be an array with at least one element");
    }
    for (size_t i = 0; i < object_[key].size(); ++i) visit(object_[key][i], fmt::format("{}/{}", place(key), i));
  }

  int64_t bounded(const json& object, const std::string& key, const std::string& pointer, int64_t low,
                  int64_t high) const {
    const json& value = object[key];
    if (!value.is_number_integer() || value.get<int64_t>() < low || value.get<int64_t>() > high) {
      file_.fail(pointer + "/" + key, fmt::format("must be a whole number from {} to {}", low, high));
    }
    return value.get<int64_t>();
  }

  bool flag(const json& object, const std::string& key, const std::string& pointer) const {
    if (!object[key].is_boolean()) file_.fail(pointer + "/" + key, "must be true or false");
    return object[key].get<bool>();
  }

  double positive(const json& object, const std::string& key, const std::string& pointer) const {
    const double value = file_.number(object[key], pointer + "/" + key);
    if (!(value > 0)) file_.fail(pointer + "/" + key, "must be above 0");
    return value;
  }

  /// A scene's name as it is, or a file name resolved against the comparison file's folder.
  std::string source(const json& value, const std::string& pointer) const {
    const std::string& text = file_.text(value, pointer);
    if (text.starts_with("builtin:") || fs::path(text).is_absolute()) return text;
    const std::string path = (file_.path().parent_path() / text).string();
    return path.starts_with('-') ? "./" + path : path;  // never an option of the runs
  }

  ComparisonScene scene(const json& value, const std::string& pointer) const {
    ComparisonScene result;
    if (value.is_string()) {
      result.source = source(value, pointer);
      return result;
    }
    std::vector<std::string> keys = override_keys();
    keys.insert(keys.end(), {"scene", "name", "sidecar", "texture_size", "optional", "size", "max_bounces", "threads"});
    file_.check_keys(value, pointer, keys);
    if (!value.contains("scene")) file_.fail(pointer, "\"scene\" is missing");
    result.source = source(value["scene"], pointer + "/scene");
    result.overrides = read_overrides(file_, value, pointer);
    if (value.contains("name")) result.name = file_.text(value["name"], pointer + "/name");
    if (value.contains("sidecar")) result.overrides.use_sidecar = flag(value, "sidecar", pointer);
    if (value.contains("optional")) result.optional = flag(value, "optional", pointer);
    if (value.contains("size")) result.size = size(value["size"], pointer + "/size");
    if (value.contains("max_bounces"))
      result.max_bounces = static_cast<int>(bounded(value, "max_bounces", pointer, -1, PathSet::kMaxBounces));
    if (value.contains("threads"))
      result.threads = static_cast<int>(bounded(value, "threads", pointer, 1, max_threads));
    const std::string& named = file_.text(value["scene"], pointer + "/scene");
    if (result.optional && !fs::exists(result.source) && fs::exists(named)) result.source = named;
    if (value.contains("texture_size")) {
      const uint64_t size = file_.count(value["texture_size"], pointer + "/texture_size");
      if (size < 1 || size > largest_texture_size)
        file_.fail(pointer + "/texture_size", fmt::format("must be from 1 to {}", largest_texture_size));
      result.import.max_texture_size = static_cast<uint32_t>(size);
    }
    return result;
  }

  TechniqueVariant technique(const json& value, const std::string& pointer) const {
    TechniqueVariant result;
    if (value.is_string()) {
      result.technique = value.get<std::string>();
      return result;
    }
    file_.check_keys(value, pointer, {"technique", "parameters", "name"});
    if (!value.contains("technique")) file_.fail(pointer, "\"technique\" is missing");
    result.technique = file_.text(value["technique"], pointer + "/technique");
    if (value.contains("name")) result.name = file_.text(value["name"], pointer + "/name");
    if (!value.contains("parameters")) return result;
    const json& parameters = value["parameters"];
    if (!parameters.is_object()) file_.fail(pointer + "/parameters", "must be an object {\"name\": value}");
    for (const auto& [name, parameter] : parameters.items()) {
      std::string text;
      if (parameter.is_boolean()) {
        text = parameter.get<bool>() ? "on" : "off";
      } else if (parameter.is_string() || parameter.is_number()) {
        text = parameter.is_string() ? parameter.get<std::string>() : parameter.dump();
      } else {
        file_.fail(pointer + "/parameters/" + name, "must be a number, a string, true or false");
      }
      result.parameters.emplace_back(name, text);
    }
    return result;
  }

  uint64_t positive_count(const json& value, const std::string& key, const std::string& pointer) const {
    const uint64_t count = file_.count(value[key], pointer + "/" + key);
    if (count == 0) file_.fail(pointer + "/" + key, "must be above 0");
    return count;
  }

  ComparisonBudget budget(const json& value, const std::string& pointer) const {
    file_.check_keys(value, pointer, {"seconds", "iterations", "samples", "relmse", "limit_seconds"});
    int modes = 0;
    for (const char* mode : {"seconds", "iterations", "samples", "relmse"}) modes += value.contains(mode);
    if (modes != 1)
      file_.fail(pointer, "must have exactly one of \"seconds\", \"iterations\", \"samples\" and \"relmse\"");
    if (value.contains("relmse") != value.contains("limit_seconds")) {
      file_.fail(pointer, "\"relmse\" and \"limit_seconds\" must be given together");
    }
    ComparisonBudget result;
    if (value.contains("seconds")) result.seconds = positive(value, "seconds", pointer);
    if (value.contains("iterations")) result.iterations = positive_count(value, "iterations", pointer);
    if (value.contains("samples")) result.samples = positive_count(value, "samples", pointer);
    if (value.contains("relmse")) {
      result.relmse = positive(value, "relmse", pointer);
      result.limit_seconds = positive(value, "limit_seconds", pointer);
    }
    return result;
  }

  std::pair<uint32_t, uint32_t> size(const json& value, const std::string& pointer) const {
    if (!value.is_array() || value.size() != 2) file_.fail(pointer, "must be [width, height]");
    const uint64_t width = file_.count(value[0], pointer + "/0"), height = file_.count(value[1], pointer + "/1");
    if (width < 1 || height < 1 || width > largest_image_side || height > largest_image_side) {
      file_.fail(pointer, fmt::format("must be from 1 to {} pixels a side", largest_image_side));
    }
    return {static_cast<uint32_t>(width), static_cast<uint32_t>(height)};
  }

  ReferenceRequest reference(const json& value) const {
    const std::string at = place("reference");
    file_.check_keys(value, at, {"file", "samples", "relmse"});
    ReferenceRequest result;
    if (value.contains("file")) {
      if (value.size() > 1) file_.fail(at, "a file is used as it is; leave out the other keys");
      result.file = file_.path().parent_path() / file_.text(value["file"], at + "/file");
    }
    if (value.contains("samples")) result.samples = file_.count(value["samples"], at + "/samples");
    if (result.samples < 32) file_.fail(at + "/samples", "must be at least 32");
    if (value.contains("relmse")) result.relmse = positive(value, "relmse", at);
    return result;
  }

  uint32_t whole(const json& value, const std::string& pointer, uint32_t low, uint32_t high) const {
    if (!value.is_number_unsigned() || value.get<uint64_t>() < low || value.get<uint64_t>() > high)
      file_.fail(pointer, fmt::format("must be a whole number from {} to {}", low, high));
    return value.get<uint32_t>();
  }

  WalkRequest walk(const json& value) const {
    const std::string at = place("walk");
    file_.check_keys(value, at, {"frames", "samples", "references"});
    WalkRequest result;
    if (!value.contains("frames")) file_.fail(at, "\"frames\" is missing");
    result.frames = whole(value["frames"], at + "/frames", 2, max_walk_frames);
    if (value.contains("samples")) result.samples = whole(value["samples"], at + "/samples", 1, 1 << 24);
    if (value.contains("references"))
      result.references = whole(value["references"], at + "/references", 0, result.frames);
    return result;
  }

  const JsonFile& file_;
  const json& object_;
  std::string pointer_;
};

}  // namespace

ComparisonSpec read_comparison(const JsonFile& file, const json& object, const std::string& pointer) {
  return ComparisonReader(file, object, pointer).read();
}

ComparisonSpec read_comparison(const fs::path& path) {
  const JsonFile file(path);
  check_schema(file, comparison_schema);
  json object = file.root();
  object.erase("schema");
  return read_comparison(file, object, "");
}

}  // namespace lucarium
