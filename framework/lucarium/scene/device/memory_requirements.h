// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>
#include <vector>

#include "lucarium/scene/device/scene_layout.h"

namespace lucarium {

struct BufferNeed {
  std::string name;
  size_t bytes;
};

/// Entries that scene_lights can ever have while geometry and materials stay: punctual lights, triangles of emissive
/// instances, the environment.
size_t light_capacity(const Scene& scene);

/// Texels of all images that textures use.
size_t texel_count(const Scene& scene);

/// Sizes of the scene's large device buffers.
std::vector<BufferNeed> scene_need(const Scene& scene, const SceneLayout& layout);

}  // namespace lucarium
