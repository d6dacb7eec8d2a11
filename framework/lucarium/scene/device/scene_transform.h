// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <vector>

#include "lucarium/compute/device/buffer.h"
#include "lucarium/compute/program/program.h"
#include "lucarium/shared/scene_types.h"

namespace lucarium {

/// What the kernels of transform_vertices.cl read and write.
struct SceneTransformBuffers {
  const TypedBuffer<Instance>& instances;
  const TypedBuffer<Vertex>& mesh_vertices;
  const TypedBuffer<uint4>& mesh_triangles;
  const TypedBuffer<Vertex>& vertices;
  const TypedBuffer<Triangle>& triangles;
};

struct VertexRange {
  uint32_t first, count;  ///< world vertices
};

/// Derives world-space vertices and triangles on the device; waits for the result.
class SceneTransform {
 public:
  explicit SceneTransform(Device& device);
  void run(const std::vector<VertexRange>& ranges, const SceneTransformBuffers& buffers, bool triangles) const;

 private:
  Program program_;
};

}  // namespace lucarium
