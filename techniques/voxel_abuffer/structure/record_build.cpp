// SPDX-License-Identifier: Apache-2.0
// The passes of a build, for a grid and lists of some sizes.
#include <algorithm>

#include "voxel_abuffer/base/name.h"
#include "voxel_abuffer/structure/state.h"

namespace lucarium::abuffer {

namespace {

constexpr uint32_t views_of_exact = 0, views_of_parity = 3;

}  // namespace

void VoxelAbuffer::State::record_build() {
  ScheduleRecorder recorder = scheduler->record("voxel_abuffer build", technique_name);
  recorder.fill_zero("clear_voxels", voxels);
  recorder.fill_zero("clear_counts", counts);
  const auto cell_capacity = static_cast<uint32_t>(cells.count() / ABUFFER_CELL_WORDS);
  const AbufferLists::Sources sources{grid_buffer, views, triangle_classes, planes,       triangles, counts,
                                      voxels,      cells, facing,           cell_capacity};
  const LayeredStoreOptions store{.variant = options.list};
  if (parity) recorder.fill_zero("clear_facing", facing);
  if (exact) exact->record(recorder, grid, sources, views_of_exact, store);
  if (parity) parity->record(recorder, grid, sources, views_of_parity, store);
  record_voxels(recorder, sources);
  if (parity) record_axes(recorder);
  record_cells(recorder, sources);
  if (options.count_work) {
    if (exact) exact->record_measures(recorder, sources);
    if (parity) parity->record_measures(recorder, sources);
  }
  build_schedule = recorder.compile();
}

/// Which voxels are occupied: those that triangles touch, or those that hold fragments.
void VoxelAbuffer::State::record_voxels(ScheduleRecorder& recorder, const AbufferLists::Sources& sources) {
  if (!options.conservative_voxels) {
    if (exact) exact->record_voxels(recorder, grid, sources);
    if (parity) parity->record_voxels(recorder, grid, sources);
    return;
  }
  recorder.pass("mark_voxels", voxel_program, "abuffer_mark_voxels")
      .global(std::max(1u, grid.triangles))
      .arg("abuffer_grid", grid_buffer)
      .arg("abuffer_classes", triangle_classes)
      .arg("abuffer_triangles", triangles)
      .arg("abuffer_voxels", voxels);
}

/// Bricks, the cells that exact fragments touch, and those in which states change. Search by planes looks at no states.
void VoxelAbuffer::State::record_cells(ScheduleRecorder& recorder, const AbufferLists::Sources& sources) {
  const auto brick_total = static_cast<uint32_t>(brick_count(grid));
  const bool walls = parity && options.intersect != Intersect::plane;
  const uint32_t kinds = walls ? ABUFFER_OCCUPIED : ABUFFER_EXACT_AXES;
  const BufferRef cell_first = recorder.transient<uint32_t>("cell_first", brick_total, coarser_grid);
  const BufferRef cell_count = recorder.transient<uint32_t>("cell_count", 1);
  recorder.pass("count_cells", voxel_program, "abuffer_count_cells")
      .global(brick_total)
      .arg("abuffer_voxels", voxels)
      .arg("count", brick_total)
      .arg("kinds", kinds)
      .arg("abuffer_cell_first", cell_first);
  primitives.record_exclusive_scan(recorder, "scan_cells", cell_first, cell_first, cell_count, brick_total);
  recorder.pass("mark_bricks", voxel_program, "abuffer_mark_bricks")
      .global(brick_total)
      .arg("abuffer_cell_first", cell_first)
      .arg("count", brick_total)
      .arg("kinds", kinds)
      .arg("abuffer_voxels", voxels)
      .arg("abuffer_bricks", bricks);
  recorder.pass("mark_empty", voxel_program, "abuffer_mark_empty")
      .global(8)
      .local(1)
      .arg("abuffer_grid", grid_buffer)
      .arg("abuffer_bricks", bricks);
  if (walls && with_reaches())
    recorder.pass("mark_reaches", voxel_program, "abuffer_mark_reaches")
        .global(8)
        .local(1)
        .arg("abuffer_grid", grid_buffer)
        .arg("abuffer_voxels", voxels)
        .arg("abuffer_bricks", bricks);
  recorder.pass("keep_cell_count", voxel_program, "abuffer_keep_cell_count")
      .global(1)
      .local(1)
      .arg("abuffer_cell_count", cell_count)
      .arg("abuffer_counts", counts);
  recorder.fill_zero("clear_cells", cells);
  if (exact) exact->record_cells(recorder, grid, sources);
  if (walls) parity->record_cells(recorder, grid, sources);
  if (!walls) return;
  recorder.pass("turn_cells", voxel_program, "abuffer_turn_cells")
      .global(64 * brick_total)
      .arg("abuffer_voxels", voxels)
      .arg("count", 64 * brick_total)
      .arg("abuffer_counts", counts)
      .arg("cell_capacity", sources.cell_capacity)
      .arg("abuffer_cells", cells);
}

void VoxelAbuffer::State::record_axes(ScheduleRecorder& recorder) {
  const auto columns = static_cast<uint32_t>(grid.bricks.w - 1);
  const auto voxel_count = static_cast<uint32_t>(64 * brick_count(grid));
  recorder.pass("choose_axes", voxel_program, "abuffer_choose_axes")
      .global(voxel_count)
      .arg("abuffer_facing", facing)
      .arg("count", voxel_count)
      .arg("average", options.axis_rule == AxisRule::average_normal ? 1u : 0u)
      .arg("abuffer_voxels", voxels);
  if (options.intersect != Intersect::automatic) return;
  recorder.fill_zero("clear_marked", marked);
  recorder.pass("check_columns", voxel_program, "abuffer_check_columns")
      .global(columns, 3)
      .arg("abuffer_grid", grid_buffer)
      .arg("abuffer_start", parity->start())
      .arg("abuffer_depths", parity->depths())
      .arg("abuffer_fragments", parity->fragments())
      .arg("abuffer_triangles", triangles)
      .arg("abuffer_component_of", component_of)
      .arg("abuffer_counts", counts)
      .arg("first", ABUFFER_COUNT_EXACT + 1)
      .arg("capacity", static_cast<uint32_t>(parity->capacity()))
      .arg("components", static_cast<uint32_t>(classes.parity.size()))
      .arg("abuffer_marked", marked);
}

}  // namespace lucarium::abuffer
