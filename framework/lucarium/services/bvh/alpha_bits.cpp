// SPDX-License-Identifier: Apache-2.0
#include "lucarium/services/bvh/alpha_bits.h"

#include <utility>

namespace lucarium {
namespace {

std::vector<uint32_t> alpha_words(const Scene& scene, const SceneBuffers& buffers) {
  std::vector<uint32_t> words((buffers.info().triangle_count + 31) / 32);
  const std::vector<Instance> instances = buffers.scene_instances.download(0, scene.instances.size());
  for (size_t i = 0; i < instances.size(); ++i) {
    if (scene.materials[static_cast<size_t>(scene.instances[i].material)].alpha_mode == AlphaMode::opaque) continue;
    const uint32_t first = instances[i].world_triangle, end = first + instances[i].triangle_count;
    for (uint32_t triangle = first; triangle < end; ++triangle) words[triangle / 32] |= 1u << triangle % 32;
  }
  return words;
}

}  // namespace

bool AlphaBits::update(Device& device, const Scene& scene, const SceneBuffers& buffers) {
  if (!(buffers.info().flags & LUCARIUM_SCENE_HAS_ALPHA)) return false;
  std::vector<uint32_t> words = alpha_words(scene, buffers);
  if (buffer_ && words == words_) return false;
  const bool is_new = !buffer_ || buffer_.count() < words.size();
  if (is_new)
    buffer_ = TypedBuffer<uint32_t>(device, "bvh", "alpha bits", words, "use a scene with fewer triangles");
  else
    buffer_.upload(words);
  words_ = std::move(words);
  return is_new;
}

}  // namespace lucarium
