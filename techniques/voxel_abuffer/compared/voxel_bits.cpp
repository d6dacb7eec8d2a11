// SPDX-License-Identifier: Apache-2.0
#include "voxel_abuffer/compared/voxel_bits.h"

#include "lucarium/compute/program/source_library.h"
#include "voxel_abuffer/base/name.h"
#include "voxel_abuffer/structure/grid_layout.h"

const lucarium::EmbeddedSources& voxel_abuffer_kernels();

namespace lucarium::abuffer {

VoxelBits::VoxelBits(KernelScheduler& scheduler, const SceneBuffers& buffers, uint32_t size)
    : ComparedStructure(scheduler, buffers,
                        {.name = "voxel", .needs_scene = true, .pad = occupied_pad, .remedy = "lower abuffer_size"}),
      fill_program_(
          make_program(scheduler.device(), voxel_abuffer_kernels(), {"voxel_abuffer/compared/fill_structures"})) {
  statistics_.voxels = size;
  rebuild();
}

AbufferGrid VoxelBits::layout() const {
  return make_grid({statistics_.voxels, statistics_.voxels}, bounds(), triangle_count());
}

void VoxelBits::fill() {
  const VoxelPairs& p = pairs();
  make_room(bricks_, "voxels", VoxelPairs::brick_slots(layout()));
  make_room(leaves_, "triangles of voxels", p.voxels());
  ScheduleRecorder recorder = scheduler().record("voxel_abuffer voxels", technique_name);
  recorder.fill_zero("clear_voxels", bricks_);
  recorder.pass("place_bricks", fill_program_, "compared_place_bricks")
      .global(std::max(1u, p.bricks()))
      .arg("compared_brick_keys", p.brick_keys())
      .arg("compared_brick_masks", p.brick_masks())
      .arg("count", p.bricks())
      .arg("compared_bricks", bricks_);
  p.record_leaves(recorder, fill_program_, leaves_);
  Schedule fill = recorder.compile();
  scheduler().run_to_end(fill);
  scheduler().finish();
  statistics_.bytes = bricks_.bytes() + leaves_.bytes() + p.brick_keys().bytes() + p.brick_first().bytes();
}

void VoxelBits::bind(PassBuilder& pass) const {
  pass.arg("compared_bricks", bricks_)
      .arg("compared_brick_keys", pairs().brick_keys())
      .arg("compared_brick_first", pairs().brick_first())
      .arg("compared_brick_count", pairs().brick_count())
      .arg("compared_leaves", leaves_);
}

}  // namespace lucarium::abuffer
