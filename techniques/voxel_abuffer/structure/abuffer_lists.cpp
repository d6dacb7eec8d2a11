// SPDX-License-Identifier: Apache-2.0
#include "voxel_abuffer/structure/abuffer_lists.h"

#include "lucarium/compute/program/source_library.h"
#include "lucarium/services/dealt_rows/dealt_rows.h"
#include "voxel_abuffer/base/name.h"

const lucarium::EmbeddedSources& voxel_abuffer_kernels();

namespace lucarium::abuffer {

namespace {

constexpr const char* smaller_abuffer = "lower abuffer_size";

uint32_t axis_rows(const AbufferGrid& grid, int k) {
  return k == 0 ? grid.voxels.z : k == 1 ? grid.voxels.x : grid.voxels.y;
}

/// A program that rounds as the search does, whose numbers it makes.
Program exact_program(Device& device, const std::string& file) {
  ProgramSpec spec{.name = file, .files = {file + ".cl"}};
  spec.mad_enable = false;
  SourceLibrary library;
  library.add(voxel_abuffer_kernels());
  return {device, library, spec};
}

/// A program whose private arrays have room for grids of at most `size`, in steps so that few are compiled.
Program sized_program(Device& device, const std::string& file, const GridSize& size) {
  const auto room = [](uint32_t count, uint32_t step) { return std::to_string((count + step - 1) / step * step); };
  return make_program(device, voxel_abuffer_kernels(), {file},
                      {{"ABUFFER_GRID_VOXELS", room(size.voxels, 32)},
                       {"ABUFFER_GRID_VOXEL_EDGE", room(size.pixels / size.voxels, 8)}});
}

size_t start_count(const AbufferGrid& grid) { return size_t{3} * grid.bricks.w; }

}  // namespace

AbufferLists::AbufferLists(KernelScheduler& scheduler, const SceneBuffers& buffers, Kind kind, const GridSize& size,
                           bool stored)
    : kind_(kind),
      stored_(stored),
      device_(&scheduler.device()),
      raster_(scheduler, buffers,
              {.max_width = size.pixels,
               .max_height = size.pixels,
               .conservative = kind == Kind::exact,
               .classes = true,
               .keep_alpha = true,
               .remedy = "lower abuffer_size"},
              technique_name),
      primitives_(scheduler.device()),
      buffers_(&buffers),
      pack_(sized_program(scheduler.device(), "voxel_abuffer/structure/pack_lists", size)),
      cells_(sized_program(
          scheduler.device(),
          kind == Kind::exact ? "voxel_abuffer/structure/mark_cells" : "voxel_abuffer/structure/mark_walls", size)),
      voxels_(make_program(scheduler.device(), voxel_abuffer_kernels(), {"voxel_abuffer/structure/mark_fragments"})) {
  if (stored) attributes_program_ = exact_program(scheduler.device(), "voxel_abuffer/structure/store_attributes");
}

size_t AbufferLists::estimate_bytes(const AbufferGrid& grid, size_t fragments, bool stored) {
  return sizeof(uint32_t) * (start_count(grid) + 2 * (fragments + ABUFFER_PADDING)) +
         (stored ? sizeof(AbufferAttributes) * fragments : 0);
}

void AbufferLists::reserve(const AbufferGrid& grid, size_t fragments) {
  if (start_.count() < start_count(grid) || !start_) {
    start_ = {};
    start_ = TypedBuffer<uint32_t>(*device_, technique_name, "starts of columns", start_count(grid), smaller_abuffer);
    ++generation_;
  }
  if (fragments <= capacity_ && depths_) return;
  capacity_ = fragments + fragments / 16;
  depths_ = fragments_ = {};
  depths_ = TypedBuffer<uint32_t>(*device_, technique_name, "depths", capacity_ + ABUFFER_PADDING, smaller_abuffer);
  fragments_ =
      TypedBuffer<uint32_t>(*device_, technique_name, "fragments", capacity_ + ABUFFER_PADDING, smaller_abuffer);
  if (stored_) {
    attributes_ = {};
    attributes_ = TypedBuffer<AbufferAttributes>(*device_, technique_name, "attributes of fragments", capacity_,
                                                 "set attributes=pixel, or lower abuffer_size");
  }
  ++generation_;
}

void AbufferLists::record(ScheduleRecorder& recorder, const AbufferGrid& grid, const Sources& sources,
                          uint32_t first_view, const LayeredStoreOptions& store) {
  for (uint32_t k = 0; k < 3; ++k) {
    const Axis axis(kind_, k);
    const LayeredRaster::ViewRef view{sources.views, recorder.variable(axis.name + ".view", first_view + k),
                                      sources.classes};
    if (kind_ == Kind::exact && store.variant == LayeredVariant::tiles)
      record_touched(recorder, grid, sources, axis, view);
    else
      record_packed(recorder, grid, sources, axis, view, store);
    if (stored_) record_attributes(recorder, grid, sources, axis);
  }
}

/// Where the lists of an axis begin. `total[index]`: the number of its fragments.
void AbufferLists::record_base(ScheduleRecorder& recorder, const Sources& sources, const Axis& axis,
                               const BufferRef& total, uint32_t index) const {
  recorder.pass(axis.name + ".add_base", pack_, "abuffer_add_base")
      .global(1)
      .local(1)
      .arg("pixel_start", total)
      .arg("pixels", index)
      .arg("axis", axis.index)
      .arg("first", first_count())
      .arg("abuffer_counts", sources.counts);
}

void AbufferLists::bind_lists(PassBuilder& pass, const Sources& sources, const Axis& axis) const {
  pass.arg("abuffer_grid", sources.grid)
      .arg("abuffer_counts", sources.counts)
      .arg("axis", axis.index)
      .arg("first", first_count())
      .arg("capacity", static_cast<uint32_t>(capacity_))
      .arg("abuffer_start", start_)
      .arg("abuffer_depths", depths_)
      .arg("abuffer_fragments", fragments_);
}

void AbufferLists::record_touched(ScheduleRecorder& recorder, const AbufferGrid& grid, const Sources& sources,
                                  const Axis& axis, const LayeredRaster::ViewRef& view) {
  if (!touched_ || touched_generation_ != raster_.generation()) {
    touched_ =
        make_program(*device_, voxel_abuffer_kernels(), {"voxel_abuffer/structure/fill_touched"}, raster_.defines());
    touched_generation_ = raster_.generation();
  }
  const uint32_t column_count = axis_pixels(grid, static_cast<int>(axis.index));
  const BufferRef columns = recorder.transient<uint32_t>(axis.name + ".columns", column_count, smaller_abuffer);
  const BufferRef total = recorder.transient<uint32_t>(axis.name + ".fragment_count", 1);
  const std::shared_ptr<const LayeredBins> bins = raster_.record_bins(recorder, axis.name, view);
  raster_.record_tiles(recorder, axis.name + ".count", view, *bins, touched_, "abuffer_count_touched",
                       [&](PassBuilder& pass) {
                         pass.arg("abuffer_grid", sources.grid).arg("axis", axis.index).arg("abuffer_columns", columns);
                       });
  primitives_.record_exclusive_scan(recorder, axis.name + ".scan", columns, columns, total, column_count);
  record_base(recorder, sources, axis, total, 0);
  raster_.record_tiles(recorder, axis.name + ".fill", view, *bins, touched_, "abuffer_fill_touched",
                       [&](PassBuilder& pass) {
                         bind_lists(pass, sources, axis);
                         pass.arg("abuffer_columns", columns).arg("abuffer_planes", sources.planes);
                       });
}

void AbufferLists::record_packed(ScheduleRecorder& recorder, const AbufferGrid& grid, const Sources& sources,
                                 const Axis& axis, const LayeredRaster::ViewRef& view,
                                 const LayeredStoreOptions& store) const {
  const bool exact = kind_ == Kind::exact;
  const LayeredRaster::Stored stored = raster_.record_stored(recorder, axis.name, view, store);
  record_base(recorder, sources, axis, stored.pixel_start, axis_pixels(grid, static_cast<int>(axis.index)));
  PassBuilder pass = recorder.pass(axis.name + ".pack", pack_, exact ? "abuffer_pack_exact" : "abuffer_pack_parity");
  deal_rows(pass, axis_rows(grid, static_cast<int>(axis.index)), *device_);
  pass.arg("pixel_start", stored.pixel_start).arg("fragments", stored.fragments);
  bind_lists(pass, sources, axis);
  if (exact)
    pass.arg("abuffer_planes", sources.planes);
  else
    pass.arg("abuffer_facing", sources.facing).arg("abuffer_classes", sources.classes);
}

void AbufferLists::record_voxels(ScheduleRecorder& recorder, const AbufferGrid& grid, const Sources& sources) const {
  for (uint32_t k = 0; k < 3; ++k) {
    const Axis axis(kind_, k);
    PassBuilder pass = recorder.pass(axis.name + ".mark_voxels", voxels_, "abuffer_mark_fragment_voxels");
    deal_rows(pass, axis_rows(grid, static_cast<int>(k)), *device_);
    pass.arg("abuffer_grid", sources.grid)
        .arg("abuffer_start", start_)
        .arg("abuffer_depths", depths_)
        .arg("abuffer_counts", sources.counts)
        .arg("axis", k)
        .arg("first", first_count())
        .arg("capacity", static_cast<uint32_t>(capacity_))
        .arg("bits", kind_ == Kind::exact ? ABUFFER_EXACT(k) : ABUFFER_PARITY)
        .arg("abuffer_voxels", sources.voxels);
  }
}

void AbufferLists::record_measures(ScheduleRecorder& recorder, const Sources& sources) const {
  const Program program = make_program(*device_, voxel_abuffer_kernels(), {"voxel_abuffer/structure/measure_lists"});
  recorder.pass(kind_ == Kind::exact ? "exact.measure" : "parity.measure", program, "abuffer_measure_lists")
      .global(256, 3)
      .arg("abuffer_grid", sources.grid)
      .arg("abuffer_start", start_)
      .arg("first", first_count())
      .arg("capacity", static_cast<uint32_t>(capacity_))
      .arg("abuffer_counts", sources.counts);
}

void AbufferLists::record_cells(ScheduleRecorder& recorder, const AbufferGrid& grid, const Sources& sources) const {
  const bool exact = kind_ == Kind::exact;
  for (uint32_t k = 0; k < 3; ++k) {
    const Axis axis(kind_, k);
    PassBuilder pass = recorder.pass(axis.name + (exact ? ".mark_cells" : ".mark_walls"), cells_,
                                     exact ? "abuffer_mark_cells_of_row" : "abuffer_mark_walls_of_row");
    deal_rows(pass, axis_rows(grid, static_cast<int>(k)), *device_);
    pass.arg("abuffer_grid", sources.grid)
        .arg("abuffer_start", start_)
        .arg("abuffer_depths", depths_)
        .arg("abuffer_counts", sources.counts)
        .arg("axis", k)
        .arg("first", first_count())
        .arg("capacity", static_cast<uint32_t>(capacity_))
        .arg("abuffer_voxels", sources.voxels)
        .arg("cell_capacity", sources.cell_capacity)
        .arg("abuffer_cells", sources.cells);
    if (!exact) pass.arg("abuffer_fragments", fragments_);
  }
}

void AbufferLists::record_attributes(ScheduleRecorder& recorder, const AbufferGrid& grid, const Sources& sources,
                                     const Axis& axis) const {
  PassBuilder pass = recorder.pass(axis.name + ".store_attributes", attributes_program_, "abuffer_store_attributes");
  buffers_->bind(pass);
  bind_lists(pass, sources, axis);
  deal_rows(pass, axis_rows(grid, static_cast<int>(axis.index)), *device_);
  pass.arg("abuffer_triangles", sources.triangles).arg("abuffer_attributes", attributes_);
}

}  // namespace lucarium::abuffer
