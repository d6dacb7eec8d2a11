// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "lucarium/compute/buffer.h"
#include "lucarium/compute/program.h"
#include "lucarium/shared/scene_types.h"

namespace lucarium {

/// Launches the kernels of transform_vertices.cl on the device's in-order queue and waits for them. Scene updates
/// happen between runs of schedules, so they are not passes of one.
class SceneTransform {
 public:
  SceneTransform() = default;
  explicit SceneTransform(Device& device);

  /// World vertices [first, first + count) from the object-space ones.
  void transform_vertices(uint32_t first, uint32_t count, const TypedBuffer<Instance>& instances,
                          const TypedBuffer<Vertex>& mesh_vertices, const TypedBuffer<Vertex>& vertices) const;
  void derive_triangles(const TypedBuffer<Instance>& instances, const TypedBuffer<uint4>& mesh_triangles,
                        const TypedBuffer<Triangle>& triangles) const;

 private:
  Program program_;
};

}  // namespace lucarium
