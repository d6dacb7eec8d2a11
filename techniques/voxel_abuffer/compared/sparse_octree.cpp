// SPDX-License-Identifier: Apache-2.0
#include "voxel_abuffer/compared/sparse_octree.h"

#include <algorithm>
#include <bit>

#include "lucarium/compute/program/source_library.h"
#include "voxel_abuffer/base/name.h"
#include "voxel_abuffer/shared/octree_layout.h"
#include "voxel_abuffer/structure/grid_layout.h"

const lucarium::EmbeddedSources& voxel_abuffer_kernels();

namespace lucarium::abuffer {

SparseOctree::SparseOctree(KernelScheduler& scheduler, const SceneBuffers& buffers, uint32_t size)
    : ComparedStructure(
          scheduler, buffers,
          {.name = "octree", .morton = true, .needs_scene = true, .pad = occupied_pad, .remedy = "lower abuffer_size"}),
      levels_(std::clamp(static_cast<uint32_t>(std::bit_width(size - 1)), 4u, OCTREE_MAX_LEVELS + 2) - 2),
      fill_program_(
          make_program(scheduler.device(), voxel_abuffer_kernels(), {"voxel_abuffer/compared/fill_structures"})),
      build_program_(
          make_program(scheduler.device(), voxel_abuffer_kernels(), {"voxel_abuffer/compared/build_octree"})) {
  statistics_.voxels = 1u << depth();
  for (uint32_t level = 0; level < levels_; ++level) {
    codes_.emplace_back();
    counts_.emplace_back(scheduler.device(), technique_name, "number of nodes", 1);
  }
  rebuild();
}

AbufferGrid SparseOctree::layout() const {
  return make_grid({statistics_.voxels, statistics_.voxels}, bounds(), triangle_count());
}

/// Bottom-up. A level may have as many nodes as the one below, or as the whole tree.
void SparseOctree::record_levels(ScheduleRecorder& recorder) {
  const VoxelPairs& p = pairs();
  const auto room = [&](uint32_t level) {
    return static_cast<uint32_t>(std::min<uint64_t>(uint64_t{1} << (3 * level), std::max(1u, p.bricks())));
  };
  std::vector<uint32_t> base(levels_ + 1, 0);  // of the bricks: 0
  uint32_t sum = 0;
  for (uint32_t level = 0; level < levels_; ++level) {
    base[level] = sum;
    sum += room(level);
    make_room(codes_[level], "codes of nodes", room(level));
  }
  make_room(nodes_, "nodes", sum);
  make_room(starts_, "first children", room(levels_));
  make_room(begins_, "beginnings of nodes", room(levels_));
  recorder.fill_zero("clear_nodes", nodes_);
  for (uint32_t level = levels_; level-- > 0;) {
    const bool lowest = level + 1 == levels_;
    const TypedBuffer<uint32_t>& codes = lowest ? p.brick_keys() : codes_[level + 1];
    const TypedBuffer<uint32_t>& count = lowest ? p.brick_count() : counts_[level + 1];
    const std::string name = "level_" + std::to_string(level);
    recorder.pass(name + ".mark_parents", build_program_, "octree_mark_parents")
        .global(room(level + 1))
        .arg("codes", codes)
        .arg("count", count)
        .arg("capacity", room(level + 1))
        .arg("begins", begins_);
    p.primitives().record_compact(recorder, name + ".find_parents", begins_, starts_, counts_[level], 0, count, 0,
                                  room(level + 1));
    recorder.pass(name + ".make_nodes", build_program_, "octree_make_nodes")
        .global(room(level))
        .arg("codes", codes)
        .arg("count", count)
        .arg("starts", starts_)
        .arg("parent_count", counts_[level])
        .arg("capacity", room(level))
        .arg("child_base", base[level + 1])
        .arg("base", base[level])
        .arg("parent_codes", codes_[level])
        .arg("nodes", nodes_);
  }
}

void SparseOctree::fill() {
  const VoxelPairs& p = pairs();
  make_room(leaves_, "triangles of leaves", p.voxels());
  ScheduleRecorder recorder = scheduler().record("voxel_abuffer octree", technique_name);
  record_levels(recorder);
  p.record_leaves(recorder, fill_program_, leaves_);
  Schedule fill = recorder.compile();
  scheduler().run_to_end(fill);
  scheduler().finish();
  node_count_ = 0;
  for (const TypedBuffer<uint32_t>& count : counts_) node_count_ += count.download()[0];
  statistics_.bytes = nodes_.bytes() + leaves_.bytes() + p.brick_masks().bytes() + p.brick_first().bytes();
}

void SparseOctree::bind(PassBuilder& pass) const {
  pass.arg("levels", levels_)
      .arg("compared_nodes", nodes_)
      .arg("compared_brick_masks", pairs().brick_masks())
      .arg("compared_brick_first", pairs().brick_first())
      .arg("compared_leaves", leaves_);
}

}  // namespace lucarium::abuffer
