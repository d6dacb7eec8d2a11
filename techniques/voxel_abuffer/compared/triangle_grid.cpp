// SPDX-License-Identifier: Apache-2.0
#include "voxel_abuffer/compared/triangle_grid.h"

#include "lucarium/compute/program/source_library.h"
#include "lucarium/shared/bvh_layout.h"
#include "voxel_abuffer/base/name.h"

const lucarium::EmbeddedSources& voxel_abuffer_kernels();

namespace lucarium::abuffer {

namespace {

constexpr uint32_t lanes = 8;  // COMPARED_LANES
constexpr float pad = 0.1f;    // as ABUFFER_VOXEL_PAD

}  // namespace

TriangleGrid::TriangleGrid(KernelScheduler& scheduler, const SceneBuffers& buffers, uint32_t abuffer_size,
                           uint32_t grid_size)
    : ComparedStructure(scheduler, buffers, {.name = "grid", .pad = pad, .remedy = "lower grid_size"}),
      size_(choose_grid_size(abuffer_size, grid_size)),
      fill_program_(
          make_program(scheduler.device(), voxel_abuffer_kernels(), {"voxel_abuffer/compared/fill_structures"})),
      block_count_(scheduler.device(), technique_name, "number of blocks", 1) {
  statistics_.voxels = size_.voxels;
  rebuild();
}

AbufferGrid TriangleGrid::layout() const { return make_grid(size_, bounds(), triangle_count()); }

void TriangleGrid::fill() {
  const VoxelPairs& p = pairs();
  make_room(bricks_, "bricks", VoxelPairs::brick_slots(layout()));
  make_room(first_of_brick_, "first voxels of bricks", VoxelPairs::brick_slots(layout()));
  make_room(block_start_, "first blocks of voxels", p.voxels() + 1);
  ScheduleRecorder recorder = scheduler().record("voxel_abuffer grid", technique_name);
  recorder.fill_zero("clear_bricks", bricks_);
  recorder.pass("place_bricks", fill_program_, "compared_place_bricks")
      .global(std::max(1u, p.bricks()))
      .arg("compared_brick_keys", p.brick_keys())
      .arg("compared_brick_masks", p.brick_masks())
      .arg("count", p.bricks())
      .arg("compared_bricks", bricks_);
  recorder.pass("place_first_voxels", fill_program_, "compared_place_first_voxels")
      .global(std::max(1u, p.bricks()))
      .arg("compared_brick_keys", p.brick_keys())
      .arg("compared_brick_first", p.brick_first())
      .arg("count", p.bricks())
      .arg("compared_first_of_brick", first_of_brick_);
  recorder.fill_zero("clear_counts", block_start_);
  p.bind_runs(recorder.pass("count_blocks", fill_program_, "compared_count_blocks"))
      .arg("compared_block_counts", block_start_);
  p.primitives().record_exclusive_scan(recorder, "place_blocks", block_start_, block_start_, block_count_,
                                       p.voxels() + 1);
  Schedule count = recorder.compile();
  scheduler().run_to_end(count);
  scheduler().finish();

  make_room(blocks_, "blocks of triangles", size_t{LUCARIUM_BVH_BLOCK_WORDS(lanes)} * block_count_.download()[0]);
  ScheduleRecorder filler = scheduler().record("voxel_abuffer grid", technique_name);
  PassBuilder pass = p.bind_runs(filler.pass("fill_blocks", fill_program_, "compared_fill_blocks"));
  bind_scene(pass);
  pass.arg("compared_triangles", p.triangles())
      .arg("compared_block_start", block_start_)
      .arg("compared_blocks", blocks_);
  Schedule fill = filler.compile();
  scheduler().run_to_end(fill);
  scheduler().finish();
  statistics_.bytes = bricks_.bytes() + first_of_brick_.bytes() + block_start_.bytes() + blocks_.bytes();
}

void TriangleGrid::bind(PassBuilder& pass) const {
  pass.arg("compared_bricks", bricks_)
      .arg("compared_first_of_brick", first_of_brick_)
      .arg("compared_block_start", block_start_)
      .arg("compared_blocks", blocks_);
}

}  // namespace lucarium::abuffer
