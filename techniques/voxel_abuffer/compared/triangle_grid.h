// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "voxel_abuffer/compared/compared_structure.h"
#include "voxel_abuffer/structure/grid_layout.h"

namespace lucarium::abuffer {

/// Uniform grid with the triangles of each voxel as blocks of eight, as the hierarchy's leaves have them: the same hits
/// as Bvh, to the bit. An empty brick of 4 × 4 × 4 voxels is one step.
class TriangleGrid final : public ComparedStructure {
 public:
  /// Voxels as those of a VoxelAbuffer of that size. Throws Error{device} naming grid_size and the numbers where memory
  /// does not suffice. `scheduler` and `buffers` must outlive this.
  TriangleGrid(KernelScheduler& scheduler, const SceneBuffers& buffers, uint32_t abuffer_size = 1280,
               uint32_t grid_size = 0);

 private:
  AbufferGrid layout() const override;
  void fill() override;
  void bind(PassBuilder& pass) const override;

  GridSize size_;
  Program fill_program_;
  TypedBuffer<uint64_t> bricks_;
  TypedBuffer<uint32_t> first_of_brick_, block_start_, block_count_;
  TypedBuffer<float> blocks_;
};

}  // namespace lucarium::abuffer
