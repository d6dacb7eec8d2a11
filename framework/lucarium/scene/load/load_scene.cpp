// SPDX-License-Identifier: Apache-2.0
#include "lucarium/scene/load/load_scene.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>

#include "lucarium/base/error.h"
#include "lucarium/base/files/missing_file.h"
#include "lucarium/base/log.h"
#include "lucarium/base/text/nearest_name.h"
#include "lucarium/base/text/text_values.h"
#include "lucarium/scene/builtin/scenes.h"
#include "lucarium/scene/exposure.h"
#include "lucarium/scene/gltf/import.h"
#include "lucarium/scene/image/environment_file.h"
#include "lucarium/scene/import_options.h"
#include "lucarium/scene/inside_out.h"
#include "lucarium/scene/load/camera_path_text.h"
#include "lucarium/scene/load/frame_camera.h"
#include "lucarium/scene/load/scene_overrides.h"

namespace lucarium {

namespace {

constexpr std::string_view builtin_prefix = "builtin:";

bool all_digits(const std::string& text) {
  return !text.empty() && text.size() < 9 && text.find_first_not_of("0123456789") == std::string::npos;
}

/// Index of the element with that name, or written as a number; none when there is neither.
template <class T>
int find_by_name_or_index(const std::vector<T>& elements, const std::string& text) {
  for (size_t i = 0; i < elements.size(); ++i) {
    if (elements[i].name == text) return static_cast<int>(i);
  }
  if (all_digits(text) && std::stoul(text) < elements.size()) return std::stoi(text);
  return none;
}

template <class T>
[[noreturn]] void fail_to_find(const Scene& scene, const char* what, const std::vector<T>& elements,
                               const std::string& text) {
  std::vector<std::string> names;
  for (const T& element : elements) names.push_back(element.name);
  if (elements.empty())
    throw_error(ErrorClass::usage, "{}: there is no {} '{}': it has none", scene.source, what, text);
  throw_error(ErrorClass::usage, "{}: there is no {} '{}'{}", scene.source, what, text, suggest_name(text, names));
}

void apply_lights(Scene& scene, const std::vector<std::string>& texts) {
  for (const std::string& text : texts) {
    if (const auto light = parse_light(text)) {
      scene.lights.push_back(*light);
    } else {
      scene.lights.clear();
    }
  }
}

void apply_environment(Scene& scene, const std::string& text, const ImportOptions& options) {
  const EnvironmentChoice choice = parse_environment(text);
  if (choice.none) {
    scene.environment.reset();
    return;
  }
  Environment environment;
  if (choice.file.empty()) {
    environment.name = text;
    environment.factor = choice.radiance;
  } else {
    environment = load_environment(choice.file, options);
  }
  environment.factor *= choice.factor;
  // Turning the picture by +a about Y takes world directions back by -a.
  environment.environment_from_world =
      glm::mat3(glm::rotate(glm::mat4(1.f), -glm::radians(choice.rotation_degrees), glm::vec3(0, 1, 0))) *
      environment.environment_from_world;
  scene.environment = std::move(environment);
}

/// Puts the chosen camera first; frames one where there is none.
void choose_camera(Scene& scene, const std::optional<std::string>& choice) {
  if (choice) {
    int index = find_by_name_or_index(scene.cameras, *choice);
    if (index == none) {
      const auto camera = parse_look_at(*choice);
      if (!camera && choice->find(':') != std::string::npos) {
        throw_error(ErrorClass::usage,
                    "{}: no camera has the name '{}', and it is not EYE:TARGET or EYE:TARGET:VFOV with finite numbers, "
                    "as in 0,1,5:0,1,0:40",
                    scene.source, *choice);
      }
      if (!camera) fail_to_find(scene, "camera", scene.cameras, *choice);
      scene.cameras.insert(scene.cameras.begin(), *camera);
      index = 0;
    }
    std::rotate(scene.cameras.begin(), scene.cameras.begin() + index, scene.cameras.begin() + index + 1);
  }
  if (!scene.cameras.empty()) return;
  scene.cameras.push_back(frame_camera(scene.bounds(), 16.f / 9.f));
  scene.warnings.push_back("the scene has no camera: it was framed from outside; choose a view with --camera");
}

/// Puts a camera in front that follows the chosen path.
void choose_camera_path(Scene& scene, const std::optional<std::string>& choice) {
  if (!choice) return;
  scene.camera_path = find_camera_path(scene, *choice);
  if (scene.camera_path) scene.cameras.insert(scene.cameras.begin(), camera_on_path(*scene.camera_path, scene.time));
}

bool is_finite(const SceneInstance& instance, const Mesh& shape) {
  for (const glm::vec3& p : shape.positions) {
    const glm::vec3 world(instance.world_from_object * glm::vec4(p, 1.f));
    if (!std::isfinite(world.x + world.y + world.z)) return false;
  }
  return true;
}

/// What evaluation can break even in a file that was read correctly.
void validate_evaluated(const Scene& scene) {
  if (scene.triangle_count() == 0) {
    throw_error(ErrorClass::input,
                "{}: there is no triangle in the scene; give a node of its default scene a mesh with triangles",
                scene.source);
  }
  for (size_t i = 0; i < scene.instances.size(); ++i) {
    const SceneInstance& instance = scene.instances[i];
    if (is_finite(instance, instance.shape(scene))) continue;
    throw_error(ErrorClass::input, "{}: mesh '{}' (instance {}) has positions that are not finite at {} s",
                scene.source, scene.meshes[instance.mesh].name, i, scene.time);
  }
}

Scene read_scene(const std::string& source, const ImportOptions& options) {
  if (source.starts_with(builtin_prefix)) return make_builtin_scene(source.substr(builtin_prefix.size()));
  std::error_code ignored;
  if (!std::filesystem::exists(source, ignored)) {
    const std::string advice = advice_for_missing(source);
    if (!advice.empty()) throw_error(ErrorClass::input, "{}: no such file{}", source, advice);
    throw_error(ErrorClass::input, "{}: no such file; give a .gltf or .glb file, or one of builtin:{}", source,
                fmt::join(builtin_scene_names(), ", builtin:"));
  }
  return import_gltf(source, options);
}

}  // namespace

Scene load_scene(const std::string& source, const SceneOverrides& overrides, const ImportOptions& options) {
  Scene scene = read_scene(source, options);
  SceneOverrides all = overrides;
  const std::filesystem::path sidecar = source + ".lucarium.json";
  std::error_code ignored;
  if (overrides.use_sidecar && !source.starts_with(builtin_prefix) && std::filesystem::exists(sidecar, ignored)) {
    all = merge_overrides(read_sidecar(sidecar), overrides);
  }
  for (const std::string& text : all.materials) apply_material(scene, parse_material(text));
  apply_lights(scene, all.lights);
  if (all.environment) apply_environment(scene, *all.environment, options);
  // A built-in scene that states an exposure has one other than 0.
  if (all.exposure || scene.exposure == 0) scene.exposure = all.exposure.value_or(exposure_automatic);
  int animation = 0;
  if (all.animation) {
    animation = find_by_name_or_index(scene.animations, *all.animation);
    if (animation == none) fail_to_find(scene, "animation", scene.animations, *all.animation);
  }
  evaluate(scene, all.at_seconds.value_or(0.0), animation);
  validate_evaluated(scene);
  choose_camera_path(scene, all.camera_path);
  if (!scene.camera_path) choose_camera(scene, all.camera);
  if (all.at_seconds.value_or(0) != 0 && scene.animations.empty() && !scene.camera_path)
    scene.warnings.push_back("the scene has no animation: it is the same at all times");
  if (const std::vector<std::string> names = meshes_inside_out(scene); !names.empty()) {
    scene.warnings.push_back(fmt::format(
        "closed but wound inside out, black seen from outside: {}; flip their triangles, or show both sides "
        "with --material NAME:double_sided=true",
        list_names(names)));
  }
  log_info("scene {}: {} in {}, {}{}, {}, {}, {}", source, counted(scene.triangle_count(), "triangle"),
           counted(scene.instances.size(), "instance"), counted(scene.lights.size(), "punctual light"),
           scene.environment ? " and a sky" : "", counted(scene.cameras.size(), "camera"),
           counted(scene.materials.size(), "material"), counted(scene.images.size(), "image"));
  return scene;
}

}  // namespace lucarium
