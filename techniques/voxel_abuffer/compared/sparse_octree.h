// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <vector>

#include "voxel_abuffer/compared/compared_structure.h"

namespace lucarium::abuffer {

/// Sparse octree of depth ⌈log₂ n⌉, whose leaves are occupied voxels, one of which is a ray's hit (Hu et al.
/// 2014, section 5.2, table 1: n² A-buffers are as precise). Which one, triangles, distances and ends of rays as of
/// VoxelBits. A leaf's averaged normal, which cone tracing reads, is not kept. The two lowest levels of the tree are
/// one word.
class SparseOctree final : public ComparedStructure {
 public:
  /// `size`: n, from 16 to 4096. Throws Error{device} naming abuffer_size and the numbers where memory does not
  /// suffice. `scheduler` and `buffers` must outlive this.
  SparseOctree(KernelScheduler& scheduler, const SceneBuffers& buffers, uint32_t size = 1280);
  bool wants_ends() const override { return true; }
  uint32_t depth() const { return levels_ + 2; }
  uint64_t nodes() const { return node_count_; }  ///< those above the bricks

 private:
  AbufferGrid layout() const override;
  void fill() override;
  void bind(PassBuilder& pass) const override;
  void record_levels(ScheduleRecorder& recorder);

  uint32_t levels_;  ///< above the bricks
  uint64_t node_count_ = 0;
  Program fill_program_, build_program_;
  TypedBuffer<uint2> nodes_;
  TypedBuffer<uint32_t> leaves_, starts_, begins_;
  std::vector<TypedBuffer<uint32_t>> codes_, counts_;  ///< per level, from the root
};

}  // namespace lucarium::abuffer
