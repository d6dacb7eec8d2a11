// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <vector>

#include "lucarium/compute/device/buffer.h"
#include "lucarium/scene/device/scene_buffers.h"
#include "lucarium/scene/scene.h"

namespace lucarium {

/// One bit per world triangle: whether its material is MASK or BLEND, so that rays look at the materials of only those
/// that they meet. Owner "bvh" in the memory account.
class AlphaBits {
 public:
  /// The bits of the scene's triangles now; nothing where all are opaque. Returns whether buffer() is another one.
  /// Throws Error{device} where memory does not suffice; then all is as it was.
  bool update(Device& device, const Scene& scene, const SceneBuffers& buffers);

  /// Bit t mod 32 of word t / 32 is that of triangle t. Never gets smaller, so that it serves older hierarchies, too.
  const TypedBuffer<uint32_t>& buffer() const { return buffer_; }

 private:
  TypedBuffer<uint32_t> buffer_;
  std::vector<uint32_t> words_;  // in it
};

}  // namespace lucarium
