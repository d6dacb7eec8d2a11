// SPDX-License-Identifier: Apache-2.0
#include "lucarium/compare/run/comparison_plan.h"

#include <algorithm>

#include "lucarium/base/error.h"
#include "lucarium/base/log.h"
#include "lucarium/compare/reference/reference_identity.h"
#include "lucarium/compare/request/device_arguments.h"
#include "lucarium/scene/exposure.h"
#include "lucarium/scene/import_options.h"
#include "lucarium/scene/load/scene_overrides.h"
#include "lucarium/session/memory_needs.h"
#include "lucarium/session/session.h"

namespace lucarium {
namespace fs = std::filesystem;
namespace {

RenderSettings settings_of(const ComparisonSpec& spec, const ComparisonScene& request, const Scene& scene) {
  const SceneSettings own = spec.settings_of(request);
  RenderSettings settings;
  settings.width = own.width;
  settings.height = own.height;
  settings.max_bounces = own.max_bounces;
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
  plan.overrides = overrides;
  return scene;
}

/// Index of the reference with these light paths; a new one is made when none has them.
size_t find_reference(ScenePlan& plan, const PathSet& declared, const Scene& scene, RenderSettings settings,
                      const TechniqueRegistry& registry) {
  const PathSet set = declared.simplified(scene);
  std::vector<ReferenceResult>& references = plan.result.references;
  for (size_t i = 0; i < references.size(); ++i) {
    if (references[i].path_set != set.to_string()) continue;
    references[i].also_said.push_back(declared.to_string());
    return i;
  }
  settings.max_bounces = set.max_bounces;
  settings.seed = reference_seed;
  ReferenceResult reference;
  reference.path_set = set.to_string();
  reference.also_said = {declared.to_string()};
  references.push_back(reference);
  plan.reference_files.push_back(ReferenceIdentity(scene, settings, set, registry).hash() + ".exr");
  plan.walk_files.emplace_back();
  for (const std::string& camera : plan.walk_cameras) {
    settings.camera = *parse_look_at(camera);
    plan.walk_files.back().push_back(ReferenceIdentity(scene, settings, set, registry).hash() + ".exr");
  }
  return references.size() - 1;
}

SceneVariant plan_variant(const TechniqueVariant& variant, const Scene& scene, const RenderSettings& settings,
                          const TechniqueRegistry& registry, ScenePlan& plan) {
  SceneVariant result;
  const TechniqueType& type = registry.find(variant.technique);
  const std::unique_ptr<Technique> technique = type.create();
  set_parameters(*technique, variant);
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

/// The frames of a walk that have references.
void plan_walk(const WalkRequest& request, const Scene& scene, ScenePlan& plan) {
  if (!scene.camera_path)
    throw_error(ErrorClass::input, "{}: there is no camera path to walk along; give the scene a \"camera_path\"",
                scene.source);
  plan.walk_frames = walk_reference_frames(request.frames, request.references);
  for (const uint32_t frame : plan.walk_frames)
    plan.walk_cameras.push_back(camera_text(walk_camera(*scene.camera_path, frame, request.frames)));
}

uint64_t emissive_triangles(const Scene& scene) {
  uint64_t count = 0;
  for (const SceneInstance& instance : scene.instances) {
    if (scene.materials[instance.material].emits()) count += scene.meshes[instance.mesh].triangles.size();
  }
  return count;
}

}  // namespace

void set_parameters(Technique& technique, const TechniqueVariant& variant) {
  try {
    technique.parameters().set_all(variant.parameters);
  } catch (const Error& error) {
    throw error.with_context(variant.technique);
  }
}

ScenePlan plan_scene(const ComparisonSpec& spec, const ComparisonScene& request, const TechniqueRegistry& registry) {
  ScenePlan plan;
  SceneResult& entry = plan.result;
  entry.name = request.label();
  if (request.optional && !fs::exists(request.source)) {
    entry.failure = fmt::format("left out: there is no file {}", fs::path(request.source).lexically_normal().string());
    entry.left_out = true;
    entry.variants.resize(spec.variants.size());
    return plan;
  }
  try {
    const Scene scene = load(spec, request, plan);
    entry.triangles = scene.triangle_count();
    entry.emissive_triangles = emissive_triangles(scene);
    entry.hash = scene.hash().hex();
    plan.automatic_exposure = is_automatic(scene.exposure);
    entry.exposure = plan.automatic_exposure ? 0 : scene.exposure;
    entry.warnings = scene.warnings;
    const RenderSettings settings = settings_of(spec, request, scene);
    if (spec.walk) plan_walk(*spec.walk, scene, plan);
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

Job scene_job(const ComparisonSpec& spec, const ComparisonScene& scene, const ScenePlan& plan,
              const ComparisonOptions& options, uint64_t seed) {
  Job job;
  job.scene = scene.source;
  job.overrides = plan.overrides;
  job.import = scene.import;
  const SceneSettings own = spec.settings_of(scene);
  job.width = own.width;
  job.height = own.height;
  job.pixel_sampling = spec.pixel_sampling;
  job.max_bounces = own.max_bounces;
  job.seed = seed;
  if (const auto mistake = read_device_arguments(own.device_arguments, job.device))
    throw_error(ErrorClass::usage, "device_arguments/{}: {}", mistake->index, mistake->what);
  job.device.cache_dir = options.cache_dir;
  job.device.use_cache = options.use_cache;
  job.technique_folders = options.technique_folders;
  job.verbose = log_level() >= LogLevel::info;
  return job;
}

}  // namespace lucarium
