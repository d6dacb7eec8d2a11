// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "voxel_abuffer/compared/compared_structure.h"

namespace lucarium::abuffer {

/// Occupied voxels, a bit each (262 MB for 1280³): of those that a ray enters, the first one whose triangle MASK and
/// BLEND do not leave out is its hit. Rays begin and end a voxel's diagonal off the surfaces at their ends (RayEnds);
/// the closest hits of those are ahead of their origins. The triangle of a hit is the one with the lowest index in the
/// voxel, its distance that of the triangle's plane within the voxel.
class VoxelBits final : public ComparedStructure {
 public:
  /// `size`: voxels along the longest side. Throws Error{device} naming abuffer_size and the numbers where memory does
  /// not suffice. `scheduler` and `buffers` must outlive this.
  VoxelBits(KernelScheduler& scheduler, const SceneBuffers& buffers, uint32_t size = 1280);
  bool wants_ends() const override { return true; }

 private:
  AbufferGrid layout() const override;
  void fill() override;
  void bind(PassBuilder& pass) const override;

  Program fill_program_;
  TypedBuffer<uint64_t> bricks_;
  TypedBuffer<uint32_t> leaves_;
};

}  // namespace lucarium::abuffer
