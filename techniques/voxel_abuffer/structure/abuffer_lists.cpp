// SPDX-License-Identifier: Apache-2.0
#include "voxel_abuffer/structure/abuffer_lists.h"

namespace lucarium::abuffer {

namespace {

constexpr const char* owner = "voxel_abuffer";
constexpr const char* remedy = "lower abuffer_size";

size_t start_count(const AbufferGrid& grid) { return size_t{3} * grid.bricks.w; }

}  // namespace

AbufferLists::AbufferLists(KernelScheduler& scheduler, const SceneBuffers& buffers, Kind kind, uint32_t pixels)
    : kind_(kind),
      device_(&scheduler.device()),
      raster_(scheduler, buffers,
              {.max_width = pixels,
               .max_height = pixels,
               .conservative = kind == Kind::exact,
               .classes = true,
               .keep_alpha = true},
              owner) {}

size_t AbufferLists::estimate_bytes(const AbufferGrid& grid, size_t fragments) {
  return sizeof(uint32_t) * (start_count(grid) + 2 * (fragments + ABUFFER_PADDING));
}

void AbufferLists::reserve(const AbufferGrid& grid, size_t fragments) {
  if (start_.count() < start_count(grid) || !start_) {
    start_ = {};
    start_ = TypedBuffer<uint32_t>(*device_, owner, "starts of columns", start_count(grid), remedy);
    ++generation_;
  }
  if (fragments <= capacity_ && depths_) return;
  capacity_ = fragments + fragments / 16;
  depths_ = fragments_ = {};
  depths_ = TypedBuffer<uint32_t>(*device_, owner, "depths", capacity_ + ABUFFER_PADDING, remedy);
  fragments_ = TypedBuffer<uint32_t>(*device_, owner, "fragments", capacity_ + ABUFFER_PADDING, remedy);
  ++generation_;
}

void AbufferLists::record(ScheduleRecorder& recorder, const AbufferGrid& grid, const Sources& sources,
                          uint32_t first_view, const LayeredStoreOptions& store, const Program& pack) const {
  const bool exact = kind_ == Kind::exact;
  const uint32_t first = exact ? 0 : ABUFFER_COUNT_EXACT + 1;
  for (uint32_t k = 0; k < 3; ++k) {
    const std::string name = std::string(exact ? "exact_" : "parity_") + "xyz"[k];
    const LayeredRaster::ViewRef view{sources.views, recorder.variable(name + ".view", first_view + k),
                                      sources.classes};
    const LayeredRaster::Stored stored = raster_.record_stored(recorder, name, view, store);
    recorder.pass(name + ".add_base", pack, "abuffer_add_base")
        .global(1)
        .local(1)
        .arg("pixel_start", stored.pixel_start)
        .arg("pixels", axis_pixels(grid, static_cast<int>(k)))
        .arg("axis", k)
        .arg("first", first)
        .arg("abuffer_counts", sources.counts);
    PassBuilder pass = recorder.pass(name + ".pack", pack, exact ? "abuffer_pack_exact" : "abuffer_pack_parity");
    const uint32_t rows = k == 0 ? grid.voxels.z : k == 1 ? grid.voxels.x : grid.voxels.y;
    pass.global(rows)
        .local(1)
        .arg("abuffer_grid", sources.grid)
        .arg("pixel_start", stored.pixel_start)
        .arg("fragments", stored.fragments)
        .arg("abuffer_counts", sources.counts)
        .arg("axis", k)
        .arg("first", first)
        .arg("capacity", static_cast<uint32_t>(capacity_))
        .arg("abuffer_start", start_)
        .arg("abuffer_depths", depths_)
        .arg("abuffer_fragments", fragments_);
    if (!exact) {
      pass.arg("abuffer_facing", sources.facing);
      continue;
    }
    pass.arg("abuffer_planes", sources.planes)
        .arg("abuffer_voxels", sources.voxels)
        .arg("cell_capacity", sources.cell_capacity)
        .arg("abuffer_cells", sources.cells);
  }
}

}  // namespace lucarium::abuffer
