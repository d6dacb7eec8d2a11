// SPDX-License-Identifier: Apache-2.0
#include "lucarium/scene/device/memory_requirements.h"

namespace lucarium {

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

std::vector<BufferNeed> scene_need(const Scene& scene, const SceneLayout& layout) {
  size_t environment = 0, cdf = 0;
  if (scene.environment && scene.environment->width > 0) {
    const size_t w = scene.environment->width, h = scene.environment->height;
    environment = w * h, cdf = (h + 1) + h * (w + 1);
  }
  const size_t lights = light_capacity(scene);
  return {{"mesh vertices", layout.mesh_vertices * sizeof(Vertex)},
          {"mesh triangles", layout.mesh_triangles * sizeof(uint4)},
          {"vertices", layout.world_vertices * sizeof(Vertex)},
          {"triangles", layout.world_triangles * sizeof(Triangle)},
          {"triangle lights", layout.world_triangles * sizeof(uint)},
          {"instances", scene.instances.size() * sizeof(Instance)},
          {"materials", scene.materials.size() * sizeof(Material)},
          {"textures", scene.textures.size() * sizeof(Texture)},
          {"texels", texel_count(scene) * sizeof(uint)},
          {"lights", lights * sizeof(Light)},
          {"light table", lights * sizeof(AliasEntry)},
          {"environment", environment * sizeof(float4)},
          {"environment distribution", cdf * sizeof(float)}};
}

}  // namespace lucarium
