// SPDX-License-Identifier: Apache-2.0
#include "lucarium/services/bvh/moving_parts.h"

#include <algorithm>

#include "lucarium/scene/animation.h"

namespace lucarium {
namespace {

/// Calls visit(instance) for what a change moves.
template <class Visit>
void for_each_touched(const SceneChange& change, Visit&& visit) {
  for (const int instance : change.moved_instances) visit(static_cast<size_t>(instance));
  for (const int instance : change.deformed_instances) visit(static_cast<size_t>(instance));
}

}  // namespace

void WorldGeometry::read_all(const SceneBuffers& buffers) {
  vertices = buffers.scene_vertices.download();
  triangles = buffers.scene_triangles.download(0, buffers.info().triangle_count);
}

void WorldGeometry::read_instances(const SceneBuffers& buffers, const SceneChange& change) {
  if (vertices.empty()) {
    read_all(buffers);
    return;
  }
  for_each_touched(change, [&](size_t index) {
    const Instance instance = buffers.scene_instances.download(index, 1).front();
    const std::vector<Vertex> moved = buffers.scene_vertices.download(instance.world_vertex, instance.vertex_count);
    std::copy(moved.begin(), moved.end(), vertices.begin() + instance.world_vertex);
    const std::vector<Triangle> turned =
        buffers.scene_triangles.download(instance.world_triangle, instance.triangle_count);
    std::copy(turned.begin(), turned.end(), triangles.begin() + instance.world_triangle);
  });
}

MovingParts::MovingParts(const Scene& scene) : part_of_(scene.instances.size(), resting) {
  const std::vector<bool> moving = animated_nodes(scene);
  for (size_t i = 0; i < scene.instances.size(); ++i) {
    const SceneInstance& instance = scene.instances[i];
    const bool moves = instance.pose || (instance.node != none && moving[static_cast<size_t>(instance.node)]);
    if (moves) part_of_[i] = count_++;
  }
}

std::vector<TwoLevelBvh::Part> MovingParts::ranges(const SceneBuffers& buffers) const {
  std::vector<TwoLevelBvh::Part> parts(count_);
  if (part_of_.empty()) return parts;
  const std::vector<Instance> instances = buffers.scene_instances.download(0, part_of_.size());
  for (size_t i = 0; i < part_of_.size(); ++i) {
    TwoLevelBvh::Part& part = parts[part_of_[i]];
    const TriangleRange range{instances[i].world_triangle, instances[i].triangle_count};
    if (!part.empty() && part.back().first + part.back().count == range.first)
      part.back().count += range.count;
    else
      part.push_back(range);
  }
  return parts;
}

std::vector<size_t> MovingParts::touched(const SceneChange& change) const {
  std::vector<size_t> parts;
  for_each_touched(change, [&](size_t instance) { parts.push_back(part_of_[instance]); });
  std::sort(parts.begin(), parts.end());
  parts.erase(std::unique(parts.begin(), parts.end()), parts.end());
  return parts;
}

void MovingParts::separate(const SceneChange& change) {
  for_each_touched(change, [&](size_t instance) {
    if (part_of_[instance] == resting) part_of_[instance] = count_++;
  });
}

}  // namespace lucarium
