// SPDX-License-Identifier: Apache-2.0
#include "lucarium/compare/run/comparison_plan.h"

#include <algorithm>

#include "lucarium/base/error.h"
#include "lucarium/compare/reference/reference_identity.h"
#include "lucarium/scene/exposure.h"
#include "lucarium/scene/import_options.h"
#include "lucarium/session/session.h"

namespace lucarium {
namespace {

/// Overrides as words of the command line.
std::vector<std::string> override_words(const SceneOverrides& overrides, const ImportOptions& import) {
  std::vector<std::string> list;
  // "=" keeps values that begin with a minus sign from being read as options.
  const auto add = [&list](const char* option, const std::string& value) {
    list.push_back(fmt::format("{}={}", option, value));
  };
  if (overrides.camera) add("--camera", *overrides.camera);
  if (overrides.environment) add("--environment", *overrides.environment);
  for (const std::string& light : overrides.lights) add("--light", light);
  if (overrides.exposure) add("--exposure", exposure_text(*overrides.exposure));
  for (const std::string& material : overrides.materials) add("--material", material);
  if (overrides.at_seconds) add("--at", fmt::format("{}", *overrides.at_seconds));
  if (overrides.animation) add("--animation", *overrides.animation);
  if (!overrides.use_sidecar) list.push_back("--no-sidecar");
  if (import.max_texture_size != ImportOptions().max_texture_size)
    add("--texture-size", std::to_string(import.max_texture_size));
  return list;
}

RenderSettings settings_of(const ComparisonSpec& spec, const Scene& scene) {
  RenderSettings settings;
  settings.width = spec.width;
  settings.height = spec.height;
  settings.max_bounces = spec.max_bounces;
  settings.pixel_sampling = spec.pixel_sampling;
  settings.camera = scene.cameras.front();
  return settings;
}

/// The scene with its overrides, or the fallback environment where it has no light.
Scene load(const ComparisonSpec& spec, const ComparisonScene& request, ScenePlan& plan) {
  SceneOverrides overrides = request.overrides;
  Scene scene = load_scene(request.source, overrides, request.import);
  if (!scene.has_light() && !spec.fallback_environment.empty()) {
    overrides.environment = spec.fallback_environment;
    scene = load_scene(request.source, overrides, request.import);
    scene.warnings.push_back("no light in the file: lit by a uniform environment of " + spec.fallback_environment);
  }
  require_light(scene);
  plan.scene_words = override_words(overrides, request.import);
  return scene;
}

/// Index of the reference with these light paths; a new one is made when none has them.
size_t find_reference(ScenePlan& plan, const PathSet& set, const Scene& scene, RenderSettings settings,
                      const TechniqueRegistry& registry) {
  std::vector<ReferenceResult>& references = plan.result.references;
  for (size_t i = 0; i < references.size(); ++i) {
    if (references[i].path_set == set.to_string()) return i;
  }
  settings.max_bounces = set.max_bounces;
  settings.seed = reference_seed;
  ReferenceResult reference;
  reference.path_set = set.to_string();
  references.push_back(reference);
  plan.reference_files.push_back(ReferenceIdentity(scene, settings, set, registry).hash() + ".exr");
  return references.size() - 1;
}

SceneVariant plan_variant(const TechniqueVariant& variant, const Scene& scene, const RenderSettings& settings,
                          const TechniqueRegistry& registry, ScenePlan& plan) {
  SceneVariant result;
  const TechniqueType& type = registry.find(variant.technique);
  const std::unique_ptr<Technique> technique = type.create();
  try {
    technique->parameters().set_all(variant.parameters);
  } catch (const Error& error) {
    throw error.with_context(variant.technique);
  }
  try {
    check_settings(type.info(), settings);
  } catch (const Error& error) {
    if (error.error_class() == ErrorClass::usage) throw;
    result.refused = error.what();
    return result;
  }
  result.limitations = technique->limitations(scene, settings);
  result.device_bytes = needed_bytes(type.info(), *technique, scene, settings);
  result.reference = find_reference(plan, technique->path_set(scene, settings), scene, settings, registry);
  ++plan.pieces;
  return result;
}

}  // namespace

ScenePlan plan_scene(const ComparisonSpec& spec, const ComparisonScene& request, const TechniqueRegistry& registry) {
  ScenePlan plan;
  SceneResult& entry = plan.result;
  entry.name = request.label();
  try {
    const Scene scene = load(spec, request, plan);
    entry.triangles = scene.triangle_count();
    entry.hash = scene.hash().hex();
    plan.automatic_exposure = is_automatic(scene.exposure);
    entry.exposure = plan.automatic_exposure ? 0 : scene.exposure;
    entry.warnings = scene.warnings;
    const RenderSettings settings = settings_of(spec, scene);
    for (const TechniqueVariant& variant : spec.variants) {
      entry.variants.push_back(plan_variant(variant, scene, settings, registry, plan));
    }
  } catch (const Error& error) {
    // A scene that cannot be used is reported and the others go on.
    if (error.error_class() != ErrorClass::input || spec.scenes.size() == 1) throw;
    entry.failure = error.what();
    entry.variants.resize(spec.variants.size());
  }
  return plan;
}

std::vector<std::string> scene_command(const ComparisonSpec& spec, const ScenePlan& plan, const std::string& source,
                                       const std::filesystem::path& program, const char* command, uint64_t seed) {
  std::vector<std::string> words = {program.string(), command,
                                    source,           "--json",
                                    "--seed",         std::to_string(seed),
                                    "--size",         fmt::format("{}x{}", spec.width, spec.height)};
  if (spec.pixel_sampling != 0) {
    words.insert(words.end(),
                 {"--pixel-sampling", spec.pixel_sampling == 1 ? "centre" : std::to_string(spec.pixel_sampling)});
  }
  words.insert(words.end(), plan.scene_words.begin(), plan.scene_words.end());
  words.insert(words.end(), spec.device_arguments.begin(), spec.device_arguments.end());
  words.insert(words.end(), spec.folder_arguments.begin(), spec.folder_arguments.end());
  return words;
}

}  // namespace lucarium
