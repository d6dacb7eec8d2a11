// SPDX-License-Identifier: Apache-2.0
#include "lucarium/scene/report/scene_report.h"

#include <glm/gtc/constants.hpp>

#include "lucarium/scene/device/degenerate_triangle.h"
#include "lucarium/scene/device/environment_tables.h"
#include "lucarium/scene/device/light_list.h"
#include "lucarium/scene/device/memory_requirements.h"
#include "lucarium/scene/device/scene_buffers.h"

namespace lucarium {

namespace {

const char* type_name(LightType type) {
  return type == LightType::point ? "point" : type == LightType::spot ? "spot" : "directional";
}

void add_emission(const Scene& scene, SceneReport& report) {
  const float radius = report.bounds.radius();
  for (const SceneLight& light : scene.lights) {
    report.lamps.push_back({light.name, type_name(light.type), light.intensity, light_flux(light, radius),
                            glm::vec3(light.world_from_light[3]), -glm::vec3(light.world_from_light[2])});
  }
  LightListBuilder builder;
  glm::dvec3 flux(0);
  for (const Light& light : builder.build(scene, radius, LightChoice::power).lights) {
    if (light.kind != LUCARIUM_LIGHT_TRIANGLE) continue;
    const glm::dvec3 radiance(light.intensity.xyz());
    ++report.emissive_triangles;
    report.emissive_area += static_cast<double>(light.position.w);
    flux += radiance * (3 * static_cast<double>(light.intensity.w) / (radiance.x + radiance.y + radiance.z));
  }
  report.emissive_flux = glm::vec3(flux);
  if (!scene.environment) return;
  report.has_environment = true;
  report.environment_width = scene.environment->width;
  report.environment_height = scene.environment->height;
  report.environment_radiance = environment_integral(*scene.environment) / (4 * glm::pi<float>());
}

}  // namespace

const char* alpha_mode_name(AlphaMode mode) {
  return mode == AlphaMode::opaque ? "opaque" : mode == AlphaMode::mask ? "mask" : "blend";
}

SceneReport make_scene_report(const Scene& scene) {
  SceneReport report;
  report.source = scene.source;
  report.triangles = scene.triangle_count();
  report.instances = scene.instances.size();
  report.meshes = scene.meshes.size();
  report.textures = scene.textures.size();
  report.images = scene.images.size();
  report.texels = texel_count(scene);
  report.skins = scene.skins.size();
  for (const SceneInstance& instance : scene.instances) {
    report.vertices += scene.meshes[instance.mesh].positions.size();
    report.deformed_instances += instance.pose != nullptr;
  }
  report.degenerate_triangles = degenerate_triangle_count(scene);
  report.materials = scene.materials;
  report.cameras = scene.cameras;
  report.camera_path = scene.camera_path;
  for (const CameraPath& path : scene.camera_paths) report.camera_path_names.push_back(path.name);
  report.animations = scene.animations;
  report.bounds = scene.bounds();
  report.extensions_used = scene.extensions_used;
  report.extensions_ignored = scene.extensions_ignored;
  report.device_bytes = SceneBuffers::estimate_bytes(scene);
  report.warnings = scene_warnings(scene);
  add_emission(scene, report);
  return report;
}

}  // namespace lucarium
