// SPDX-License-Identifier: Apache-2.0
// Labels, rules and JSON form of what is asked for.
#include "lucarium/compare/request/comparison_spec.h"

#include <algorithm>
#include <set>
#include <tuple>

#include "lucarium/base/error.h"
#include "lucarium/base/json.h"
#include "lucarium/compare/request/comparison_file.h"
#include "lucarium/compare/request/device_arguments.h"
#include "lucarium/scene/exposure.h"
#include "lucarium/scene/import_options.h"
#include "lucarium/scene/load/scene_overrides.h"

namespace lucarium {

using nlohmann::ordered_json;

std::string TechniqueVariant::words() const {
  std::string text = technique;
  for (size_t i = 0; i < parameters.size(); ++i) {
    text += fmt::format("{}{}={}", i ? "," : ":", parameters[i].first, parameters[i].second);
  }
  return text;
}

std::string ComparisonBudget::label() const {
  if (seconds > 0) return fmt::format("{} s", seconds);
  if (iterations > 0) return fmt::format("{} iteration{}", iterations, iterations == 1 ? "" : "s");
  if (samples > 0) return fmt::format("{} spp", samples);
  return fmt::format("relMSE {}", relmse);
}

namespace {

ordered_json overrides_json(const SceneOverrides& overrides) {
  ordered_json json = ordered_json::object();
  if (overrides.camera) json["camera"] = *overrides.camera;
  if (overrides.camera_path) json["camera_path"] = *overrides.camera_path;
  if (overrides.environment) json["environment"] = *overrides.environment;
  if (!overrides.lights.empty()) json["lights"] = overrides.lights;
  if (overrides.exposure) {
    json["exposure"] = is_automatic(*overrides.exposure) ? ordered_json("auto") : ordered_json(*overrides.exposure);
  }
  if (overrides.at_seconds) json["at_seconds"] = *overrides.at_seconds;
  if (overrides.animation) json["animation"] = *overrides.animation;
  if (!overrides.materials.empty()) json["materials"] = overrides.materials;
  if (!overrides.use_sidecar) json["sidecar"] = false;
  return json;
}

ordered_json scene_json(const ComparisonScene& scene) {
  ordered_json json = overrides_json(scene.overrides);
  if (scene.import.max_texture_size != ImportOptions().max_texture_size)
    json["texture_size"] = scene.import.max_texture_size;
  if (!scene.name.empty()) json["name"] = scene.name;
  if (scene.optional) json["optional"] = true;
  if (scene.size) json["size"] = {scene.size->first, scene.size->second};
  if (scene.max_bounces) json["max_bounces"] = *scene.max_bounces;
  if (scene.threads > 0) json["threads"] = scene.threads;
  if (json.empty()) return scene.source;
  json["scene"] = scene.source;
  return json;
}

ordered_json variant_json(const TechniqueVariant& variant) {
  ordered_json json = {{"technique", variant.technique}, {"parameters", ordered_json::object()}};
  for (const auto& [name, value] : variant.parameters) json["parameters"][name] = value;
  if (!variant.name.empty()) json["name"] = variant.name;
  return json;
}

ordered_json budget_json(const ComparisonBudget& budget) {
  if (budget.seconds > 0) return {{"seconds", budget.seconds}};
  if (budget.iterations > 0) return {{"iterations", budget.iterations}};
  if (budget.samples > 0) return {{"samples", budget.samples}};
  return {{"relmse", budget.relmse}, {"limit_seconds", budget.limit_seconds}};
}

ordered_json reference_json(const ReferenceRequest& reference) {
  if (reference.file) return {{"file", reference.file->string()}};
  ordered_json json = {{"samples", reference.samples}};
  if (reference.relmse > 0) json["relmse"] = reference.relmse;
  return json;
}

template <class List, class Label>
void check_different(const List& list, const char* what, Label&& label) {
  std::set<std::string> labels;
  for (const auto& item : list) {
    if (!labels.insert(label(item)).second)
      throw_error(ErrorClass::usage, "the {} {} is given twice", what, label(item));
  }
}

}  // namespace

SceneSettings ComparisonSpec::settings_of(const ComparisonScene& scene) const {
  SceneSettings settings{width, height, scene.max_bounces.value_or(max_bounces), device_arguments};
  if (scene.size) std::tie(settings.width, settings.height) = *scene.size;
  const std::vector<std::string> words = write_device_arguments("", scene.threads, "", "");
  settings.device_arguments.insert(settings.device_arguments.end(), words.begin(), words.end());  // the last one counts
  return settings;
}

std::string ComparisonSpec::to_json() const {
  ordered_json json;
  json["schema"] = comparison_schema;
  json["scenes"] = ordered_json::array();
  for (const ComparisonScene& scene : scenes) json["scenes"].push_back(scene_json(scene));
  json["techniques"] = ordered_json::array();
  for (const TechniqueVariant& variant : variants) json["techniques"].push_back(variant_json(variant));
  json["budgets"] = ordered_json::array();
  for (const ComparisonBudget& budget : budgets) json["budgets"].push_back(budget_json(budget));
  json["seeds"] = seeds;
  json["size"] = {width, height};
  json["max_bounces"] = max_bounces;
  json["pixel_sampling"] = pixel_sampling;
  json["reference"] = reference_json(reference);
  if (walk) json["walk"] = {{"frames", walk->frames}, {"samples", walk->samples}, {"references", walk->references}};
  if (!fallback_environment.empty()) json["fallback_environment"] = fallback_environment;
  if (!device_arguments.empty()) json["device_arguments"] = device_arguments;
  return json.dump(2) + "\n";
}

std::string fallback_mistake(const std::string& environment) {
  try {
    const EnvironmentChoice choice = parse_environment(environment);
    if (!choice.none && choice.file.empty()) return "";
  } catch (const Error&) {  // it has no form at all
  }
  return fmt::format("'{}' is not a sky: R,G,B or one grey value [cd/m2]", environment);
}

void check_comparison(const ComparisonSpec& spec) {
  if (spec.scenes.empty()) throw_error(ErrorClass::usage, "no scene given; name a file or builtin:cornell");
  if (spec.variants.empty()) throw_error(ErrorClass::usage, "no technique given; add -t path_tracing");
  if (spec.budgets.empty()) {
    throw_error(ErrorClass::usage, "give a budget: --time SECONDS, --spp N, --iterations N or --relmse E");
  }
  for (const ComparisonBudget& budget : spec.budgets) {
    if ((budget.seconds > 0) + (budget.iterations > 0) + (budget.samples > 0) + (budget.relmse > 0) != 1) {
      throw_error(ErrorClass::usage, "a budget is exactly one of seconds, iterations, samples and relmse");
    }
    if (budget.relmse > 0 && budget.limit_seconds <= 0) {
      throw_error(ErrorClass::usage, "a budget of relMSE {} needs a limit of seconds above 0", budget.relmse);
    }
  }
  DeviceOptions device;
  if (const auto mistake = read_device_arguments(spec.device_arguments, device))
    throw_error(ErrorClass::usage, "device_arguments/{}: {}", mistake->index, mistake->what);
  if (spec.seeds == 0 || spec.seeds > 1000) throw_error(ErrorClass::usage, "seeds must be from 1 to 1000");
  if (spec.reference.file && spec.scenes.size() > 1) {
    throw_error(ErrorClass::usage, "a reference file fits one scene only; {} were given", spec.scenes.size());
  }
  if (!spec.fallback_environment.empty()) {
    const std::string what = fallback_mistake(spec.fallback_environment);
    if (!what.empty()) throw_error(ErrorClass::usage, "the fallback environment {}", what);
  }
  check_different(spec.scenes, "scene", [](const ComparisonScene& scene) { return scene.label(); });
  check_different(spec.variants, "technique", [](const TechniqueVariant& variant) { return variant.label(); });
  check_different(spec.budgets, "budget", [](const ComparisonBudget& budget) { return budget.label(); });
}

}  // namespace lucarium
