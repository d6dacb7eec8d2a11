// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>
#include <vector>

#include "lucarium/scene/device/scene_layout.h"
#include "lucarium/shared/scene_buffers.h"

namespace lucarium {

struct MemoryRequirement {
  std::string name;  ///< of the buffer, for people
  size_t bytes;
};

/// Elements of every scene buffer: the kernels' (LUCARIUM_SCENE_BUFFERS) and the object-space meshes.
struct SceneBufferCounts {
#define LUCARIUM_DECLARE_COUNT(type, name, meaning) size_t name = 0;
  LUCARIUM_SCENE_BUFFERS(LUCARIUM_DECLARE_COUNT)
#undef LUCARIUM_DECLARE_COUNT
  size_t scene_mesh_vertices = 0, scene_mesh_triangles = 0;
};

/// Entries that scene_lights can ever have while geometry and materials stay: punctual lights, triangles of emissive
/// instances, the environment.
size_t light_capacity(const Scene& scene);

/// Texels of all images that textures use.
size_t texel_count(const Scene& scene);

SceneBufferCounts count_elements(const Scene& scene, const SceneLayout& layout);

/// Sizes of the scene's device buffers.
std::vector<MemoryRequirement> memory_requirements(const Scene& scene, const SceneLayout& layout);

}  // namespace lucarium
