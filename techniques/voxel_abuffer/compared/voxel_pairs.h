// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>

#include "lucarium/compute/schedule/scheduler.h"
#include "lucarium/scene/device/scene_buffers.h"
#include "lucarium/services/primitives/primitives.h"
#include "voxel_abuffer/base/name.h"
#include "voxel_abuffer/shared/abuffer_layout.h"

namespace lucarium::abuffer {

/// Replaces a buffer that is too small; whether it did.
template <class T>
bool make_compared_room(Device& device, TypedBuffer<T>& buffer, const std::string& name, size_t count,
                        const std::string& remedy) {
  if (buffer && buffer.count() >= count) return false;
  buffer = {};
  buffer = TypedBuffer<T>(device, technique_name, name, count + count / 8 + 1, remedy);
  return true;
}

/// Which triangle touches which voxel of a grid (conservative), sorted by bricks of 4 × 4 × 4 voxels and within a brick
/// by triangles: what grids, voxels and octrees to compare with are made of. Built on the device; the same with any
/// number of threads.
class VoxelPairs {
 public:
  /// `morton`: bricks are numbered along a Morton curve, else row by row (voxel_keys.clh).
  VoxelPairs(KernelScheduler& scheduler, const SceneBuffers& buffers, bool morton);

  /// Finds them for the scene at present. `pad`: how far beside a triangle voxels count as touched [pixels]. Throws
  /// Error{device} with `remedy` where memory does not suffice.
  void build(const AbufferGrid& grid, float pad, const std::string& remedy);
  /// Grows when build() replaced a buffer.
  uint64_t generation() const { return generation_; }

  uint32_t pairs() const { return pair_count_; }
  uint32_t bricks() const { return brick_count_; }  ///< that hold occupied voxels
  uint32_t voxels() const { return voxel_count_; }  ///< occupied ones
  size_t bytes() const;                             ///< needed while building only
  static size_t brick_slots(const AbufferGrid& grid) { return size_t{grid.bricks.x} * grid.bricks.y * grid.bricks.z; }

  const TypedBuffer<AbufferGrid>& grid() const { return grid_; }
  const TypedBuffer<uint32_t>& total() const { return total_; }          ///< 1: pairs
  const TypedBuffer<uint32_t>& order() const { return order_; }          ///< sorted: indices into the two below
  const TypedBuffer<uint8_t>& within_brick() const { return within_; }   ///< voxel of a pair within its brick
  const TypedBuffer<uint32_t>& triangles() const { return triangles_; }  ///< triangle of a pair
  const TypedBuffer<uint32_t>& brick_count() const { return brick_counter_; }
  const TypedBuffer<uint32_t>& brick_start() const { return brick_start_; }  ///< first of order() of a brick
  const TypedBuffer<uint32_t>& brick_keys() const { return brick_keys_; }    ///< ascending
  const TypedBuffer<uint64_t>& brick_masks() const { return brick_masks_; }  ///< a bit per occupied voxel
  const TypedBuffer<uint32_t>& brick_first() const { return brick_first_; }  ///< occupied voxels of the bricks before
  const Primitives& primitives() const { return primitives_; }
  /// Binds, for a pass over all bricks, what says which pairs are theirs.
  PassBuilder bind_runs(PassBuilder pass) const;
  /// Records leaves[i] = lowest triangle of the occupied voxel i. `fill`: fill_structures.cl.
  void record_leaves(ScheduleRecorder& recorder, const Program& fill, const BufferRef& leaves) const;

 private:
  void count(const std::string& remedy);
  void sort(const std::string& remedy);
  void record_sort(ScheduleRecorder& recorder);
  void record_bricks(ScheduleRecorder& recorder);

  KernelScheduler* scheduler_;
  const SceneBuffers* buffers_;
  Program program_;
  Primitives primitives_;
  bool morton_;
  float pad_ = 0;
  AbufferGrid layout_{};
  uint32_t pair_count_ = 0, brick_count_ = 0, voxel_count_ = 0;
  uint64_t generation_ = 0, scene_generation_ = 0;
  TypedBuffer<AbufferGrid> grid_;
  TypedBuffer<uint32_t> counts_, total_, keys_, order_, triangles_;
  TypedBuffer<float> float_counts_, float_total_;
  TypedBuffer<uint8_t> within_;
  TypedBuffer<uint32_t> brick_counter_, brick_start_, brick_keys_, brick_first_, voxel_counter_;
  TypedBuffer<uint64_t> brick_masks_;
  Schedule count_schedule_, sort_schedule_, brick_schedule_;
  uint32_t recorded_bits_ = 0;
};

}  // namespace lucarium::abuffer
