// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <memory>
#include <span>

#include "lucarium/services/intersector.h"

namespace lucarium {

struct BvhStatistics {
  uint32_t triangles = 0;          ///< that can be hit
  uint32_t ignored_triangles = 0;  ///< without area, or with coordinates that are not finite or beyond 10¹² m
  uint32_t nodes = 0, leaf_blocks = 0;
  double build_seconds = 0;
  size_t bytes = 0;          ///< on the device; schedules recorded before these buffers replaced others keep those, too
  size_t host_bytes = 0;     ///< kept for refits: none while all is at rest, about 2 · bytes when parts can move
  uint32_t parts = 0;        ///< hierarchies that move by themselves, the resting one included
  uint64_t part_builds = 0;  ///< built since the beginning; a motion of a part alone is none
  uint64_t part_refits = 0;
  double sah_cost = 0;  ///< expected node + leaf block tests of a random line that crosses the root box
};

/// How rays are traversed. All compute hits by the same operations, so that they find the same ones to the bit on one
/// device (except for needle-thin triangles, whose computed distance may lie in front of the boxes that hold them).
enum class BvhTraversal {
  automatic,         ///< what the environment variable LUCARIUM_BVH names; else wide on CPU devices, scalar on others
  wide,              ///< wide_16 where the device's vectors have 16 floats, else wide_8
  wide_portable,     ///< the same without built-ins of an instruction set
  wide_16,           ///< 16-wide nodes, 8-triangle leaves, a chunk of rays per work-item: coherent runs of 16 as
                     ///< packets, others interleaved; with compiler built-ins where the device has AVX-512
  wide_8,            ///< 8-wide nodes, 4-triangle leaves, likewise; with compiler built-ins where it has AVX2
  wide_16_portable,  ///< without built-ins
  wide_8_portable,   ///< without built-ins
  scalar,            ///< 4-wide nodes, 4-triangle leaves, one ray per work-item
};

/// Wide bounding-volume hierarchy over the scene's world-space triangles. Built on the host (SAH, all cores), traversed
/// on the device. Owner "bvh" in the memory account. Both sides of a triangle are hit; equal distances go to the lower
/// triangle index; closed meshes with shared vertices are watertight. Results do not depend on the number of threads.
class Bvh : public Intersector {
 public:
  /// Refuses with Error{device} and the numbers when the device's memory does not suffice. `buffers` must outlive this.
  Bvh(Device& device, const Scene& scene, const SceneBuffers& buffers,
      BvhTraversal traversal = BvhTraversal::automatic);
  /// The same over any opaque triangles, without a scene (Triangle::instance and all of Vertex but the position are
  /// unused).
  Bvh(Device& device, std::span<const Vertex> vertices, std::span<const Triangle> triangles,
      BvhTraversal traversal = BvhTraversal::automatic);
  ~Bvh() override;

  /// Follows a change; to be called after buffers.update(). Instances that an animation, skin or morph can move have
  /// hierarchies of their own below a small one: when they move only these are refitted, or rebuilt when their
  /// quality fell (SAH cost above 1.5× built). An instance moved by the program is refitted with the static part
  /// and gets its own hierarchy once refitting degrades it. Changed topology, also where it shows in the
  /// counts only, rebuilds everything. To be called for changed materials, too: the kernels are compiled for whether
  /// any is MASK or BLEND. Recorded schedules stay valid unless generation() changes. If memory runs out it throws;
  /// the old BVH stays valid.
  void update(const Scene& scene, const SceneBuffers& buffers, const SceneChange& change);
  /// The same for any triangles; without `topology` only vertices have moved and triangles are those of the
  /// build (another number of them is taken for changed topology).
  void update(std::span<const Vertex> vertices, std::span<const Triangle> triangles, bool topology);

  /// Grows when update() had to replace device buffers: passes recorded before must then be recorded again.
  uint64_t generation() const;

  std::string name() const override { return "bvh"; }
  void record_closest(ScheduleRecorder& recorder, const std::string& pass_name, const RayBuffers& rays,
                      const BufferRef& hits) const override;
  void record_any(ScheduleRecorder& recorder, const std::string& pass_name, const RayBuffers& rays,
                  const BufferRef& occluded) const override;

  BvhTraversal traversal() const;  ///< the one chosen: never automatic, wide or wide_portable
  const BvhStatistics& statistics() const;
  /// Expected need, for statements before anything is built; the constructor states the exact one.
  static size_t estimate_bytes(const Scene& scene);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace lucarium
