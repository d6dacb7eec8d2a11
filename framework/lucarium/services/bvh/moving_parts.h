// SPDX-License-Identifier: Apache-2.0
// Which instances of a scene move by themselves, and its geometry on the host.
#pragma once
#include <cstddef>
#include <vector>

#include "lucarium/scene/device/scene_buffers.h"
#include "lucarium/services/bvh/two_level_bvh.h"

namespace lucarium {

/// The scene's world-space geometry as the device derived it.
struct WorldGeometry {
  std::vector<Vertex> vertices;
  std::vector<Triangle> triangles;

  void read_all(const SceneBuffers& buffers);
  /// What belongs to moved or deformed instances; everything if nothing was read yet.
  void read_instances(const SceneBuffers& buffers, const SceneChange& change);
};

/// Assigns instances to parts of a TwoLevelBvh: part 0 holds what is at rest, each other part one instance that moves.
class MovingParts {
 public:
  static constexpr size_t resting = 0;

  MovingParts() = default;
  /// Instances that hang on a node which some animation moves, and skinned or morphed ones, get parts of their own.
  explicit MovingParts(const Scene& scene);

  /// Triangles of every part.
  std::vector<TwoLevelBvh::Part> ranges(const SceneBuffers& buffers) const;
  /// Parts of the moved and deformed instances, ascending.
  std::vector<size_t> touched(const SceneChange& change) const;
  /// Gives the moved and deformed instances that are at rest parts of their own.
  void separate(const SceneChange& change);

 private:
  std::vector<size_t> part_of_;  // by instance
  size_t count_ = 1;
};

}  // namespace lucarium
