// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "lucarium/scene/scene.h"

namespace lucarium {

/// What `lucarium scene FILE` prints about a loaded scene.
struct SceneReport {
  struct Lamp {
    std::string name, type;
    glm::vec3 intensity{0};  ///< [cd] point and spot, [lx] directional
    glm::vec3 flux{0};       ///< [lm]; directional: through the disc of the scene's bounding sphere
    glm::vec3 position{0}, direction{0};
  };

  std::string source;
  uint64_t triangles = 0, vertices = 0, degenerate_triangles = 0;
  size_t instances = 0, meshes = 0, textures = 0, images = 0, skins = 0, deformed_instances = 0;
  uint64_t texels = 0;
  std::vector<SceneMaterial> materials;
  std::vector<Lamp> lamps;
  uint64_t emissive_triangles = 0;
  double emissive_area = 0;    ///< [m²], one side
  glm::vec3 emissive_flux{0};  ///< [lm], all sides that emit
  bool has_environment = false;
  uint32_t environment_width = 0, environment_height = 0;
  glm::vec3 environment_radiance{0};  ///< mean over the sphere [cd/m²]
  std::vector<SceneCamera> cameras;
  std::optional<CameraPath> camera_path;       ///< that the first camera follows
  std::vector<std::string> camera_path_names;  ///< that the scene brings
  std::vector<Animation> animations;           ///< names, channels and durations
  Bounds bounds;
  std::vector<std::string> extensions_used, extensions_ignored;
  size_t device_bytes = 0;  ///< of SceneBuffers
  std::vector<std::string> warnings;

  std::string text() const;
  std::string json() const;  ///< units in the key names
};

const char* alpha_mode_name(AlphaMode mode);  ///< as in materials of glTF files, lower case

SceneReport make_scene_report(const Scene& scene);

/// What looks wrong or will converge badly, one line each: no light, albedos near or above 1, sizes that hint at wrong
/// units, emissive factors outside [0, 1], triangles without area. The importer's own warnings come first.
std::vector<std::string> scene_warnings(const Scene& scene);

}  // namespace lucarium
