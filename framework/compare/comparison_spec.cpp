// SPDX-License-Identifier: Apache-2.0
// JSON form of a comparison.
#include <algorithm>
#include <nlohmann/json.hpp>

#include "lucarium/base/error.h"
#include "lucarium/base/nearest_name.h"
#include "lucarium/compare/comparison.h"

namespace lucarium {

using nlohmann::ordered_json;

std::string TechniqueVariant::label() const {
  std::string text = technique;
  for (size_t i = 0; i < parameters.size(); ++i) {
    text += fmt::format("{}{}={}", i ? "," : ":", parameters[i].first, parameters[i].second);
  }
  return text;
}

namespace {

ordered_json variant_json(const TechniqueVariant& variant) {
  ordered_json parameters = ordered_json::object();
  for (const auto& [name, value] : variant.parameters) parameters[name] = value;
  return {{"technique", variant.technique}, {"parameters", parameters}};
}

TechniqueVariant parse_variant(const ordered_json& json) {
  TechniqueVariant variant{json.at("technique").get<std::string>(), {}};
  if (json.contains("parameters")) {
    for (const auto& [name, value] : json.at("parameters").items()) {
      variant.parameters.emplace_back(name, value.is_string() ? value.get<std::string>() : value.dump());
    }
  }
  return variant;
}

const std::vector<std::string>& known_keys() {
  static const std::vector<std::string> keys = {
      "scenes",          "variants",         "seconds",  "iterations",        "seeds",    "width",
      "height",          "max_bounces",      "reference", "reference_samples", "exposure", "pixel_sampling",
      "scene_arguments", "device_arguments", "fallback_environment"};
  return keys;
}

}  // namespace

std::string ComparisonSpec::to_json() const {
  ordered_json json;
  json["scenes"] = scenes;
  json["variants"] = ordered_json::array();
  for (const TechniqueVariant& variant : variants) json["variants"].push_back(variant_json(variant));
  if (budget.seconds > 0) json["seconds"] = budget.seconds;
  if (budget.iterations > 0) json["iterations"] = budget.iterations;
  json["seeds"] = seeds;
  json["width"] = width;
  json["height"] = height;
  json["max_bounces"] = max_bounces;
  json["pixel_sampling"] = pixel_sampling;
  json["reference_samples"] = reference_samples;
  if (reference) json["reference"] = reference->string();
  if (exposure) json["exposure"] = *exposure;
  if (!fallback_environment.empty()) json["fallback_environment"] = fallback_environment;
  json["scene_arguments"] = scene_arguments;
  json["device_arguments"] = device_arguments;
  return json.dump(2);
}

ComparisonSpec ComparisonSpec::parse(const std::string& text, const std::string& shown_name) {
  try {
    const ordered_json json = ordered_json::parse(text);
    for (const auto& [key, value] : json.items()) {
      if (std::find(known_keys().begin(), known_keys().end(), key) == known_keys().end()) {
        throw_error(ErrorClass::usage, "{}: unknown key '{}'{}", shown_name, key, suggest_name(key, known_keys()));
      }
    }
    ComparisonSpec spec;
    spec.scenes = json.at("scenes").get<std::vector<std::string>>();
    for (const ordered_json& variant : json.at("variants")) spec.variants.push_back(parse_variant(variant));
    spec.budget.seconds = json.value("seconds", 0.0);
    spec.budget.iterations = json.value("iterations", uint64_t{0});
    spec.seeds = json.value("seeds", spec.seeds);
    spec.width = json.value("width", spec.width);
    spec.height = json.value("height", spec.height);
    spec.max_bounces = json.value("max_bounces", spec.max_bounces);
    spec.pixel_sampling = json.value("pixel_sampling", spec.pixel_sampling);
    spec.reference_samples = json.value("reference_samples", spec.reference_samples);
    if (json.contains("reference")) spec.reference = json.at("reference").get<std::string>();
    if (json.contains("exposure")) spec.exposure = json.at("exposure").get<float>();
    spec.fallback_environment = json.value("fallback_environment", std::string());
    spec.scene_arguments = json.value("scene_arguments", std::vector<std::string>());
    spec.device_arguments = json.value("device_arguments", std::vector<std::string>());
    return spec;
  } catch (const nlohmann::json::exception& error) {
    throw_error(ErrorClass::usage, "{}: {}", shown_name, error.what());
  }
}

}  // namespace lucarium
