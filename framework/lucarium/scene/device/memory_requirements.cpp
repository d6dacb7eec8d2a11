// SPDX-License-Identifier: Apache-2.0
#include "lucarium/scene/device/memory_requirements.h"

#include <algorithm>

#include "lucarium/scene/device/light_tree.h"
#include "lucarium/scene/device/specular_albedo.h"
#include "lucarium/shared/light_tree.h"

namespace lucarium {
namespace {

/// "scene_light_table" → "light table".
std::string readable(std::string name) {
  name.erase(0, std::string_view("scene_").size());
  std::replace(name.begin(), name.end(), '_', ' ');
  return name;
}

}  // namespace

size_t light_capacity(const Scene& scene) {
  size_t count = scene.lights.size() + (scene.environment ? 1 : 0);
  for (const SceneInstance& instance : scene.instances) {
    if (scene.materials[instance.material].emits()) count += scene.meshes[instance.mesh].triangles.size();
  }
  return count;
}

size_t texel_count(const Scene& scene) {
  std::vector<bool> used(scene.images.size(), false);
  size_t count = 0;
  for (const SceneTexture& texture : scene.textures) {
    if (texture.image == none || used[texture.image]) continue;
    used[texture.image] = true;
    count += size_t(scene.images[texture.image].width) * scene.images[texture.image].height;
  }
  return count;
}

SceneBufferCounts count_elements(const Scene& scene, const SceneLayout& layout) {
  SceneBufferCounts counts;
  if (scene.environment && scene.environment->width > 0) {
    const size_t w = scene.environment->width, h = scene.environment->height;
    counts.scene_environment = w * h;
    counts.scene_environment_cdf = (h + 1) + h * (w + 1);
  }
  counts.scene_mesh_vertices = layout.mesh_vertices;
  counts.scene_mesh_triangles = layout.mesh_triangles;
  counts.scene_info = 1;
  counts.scene_vertices = layout.world_vertices;
  counts.scene_triangles = counts.scene_triangle_lights = layout.world_triangles;
  counts.scene_alpha = (layout.world_triangles + 31) / 32;
  counts.scene_instances = scene.instances.size();
  counts.scene_materials = scene.materials.size();
  counts.scene_textures = scene.textures.size();
  counts.scene_texels = texel_count(scene);
  counts.scene_srgb_table = 256;
  counts.scene_albedo_table = specular_albedo_table().size();
  counts.scene_lights = counts.scene_light_table = counts.scene_light_places = light_capacity(scene);
  counts.scene_light_trees = LUCARIUM_LIGHT_TREES_WORDS;
  counts.scene_light_nodes = light_tree_capacity(light_capacity(scene));
  return counts;
}

std::vector<MemoryRequirement> memory_requirements(const Scene& scene, const SceneLayout& layout) {
  const SceneBufferCounts counts = count_elements(scene, layout);
  std::vector<MemoryRequirement> list = {{"mesh vertices", counts.scene_mesh_vertices * sizeof(Vertex)},
                                         {"mesh triangles", counts.scene_mesh_triangles * sizeof(uint4)}};
#define LUCARIUM_ADD_REQUIREMENT(type, name, meaning) list.push_back({readable(#name), counts.name * sizeof(type)});
  LUCARIUM_SCENE_BUFFERS(LUCARIUM_ADD_REQUIREMENT)
#undef LUCARIUM_ADD_REQUIREMENT
  return list;
}

}  // namespace lucarium
