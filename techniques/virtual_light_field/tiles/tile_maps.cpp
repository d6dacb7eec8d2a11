// SPDX-License-Identifier: Apache-2.0
#include "virtual_light_field/tiles/tile_maps.h"

#include <algorithm>

#include "lucarium/base/error.h"
#include "lucarium/compute/device/remedies.h"
#include "lucarium/services/primitives/primitives.h"
#include "virtual_light_field/base/field_program.h"

namespace lucarium::vlf {
namespace {

constexpr const char* kRemedy = "lower dir_n, cells or texels";

/// Sums as 64-bit numbers: what a scan of 32 bits could not hold is refused before it runs.
void check_total(const std::vector<TypedBuffer<uint32_t>>& all, const char* what) {
  uint64_t total = 0;
  for (const TypedBuffer<uint32_t>& counts : all)
    for (const uint32_t count : counts.download()) total += count;
  if (total >= LUCARIUM_NONE)
    throw_error(ErrorClass::device, "virtual_light_field: {} {} are more than 32 bits can number; {}", total, what,
                kRemedy);
}

/// A scan of `counts`, and its total.
uint32_t scan(KernelScheduler& scheduler, const Primitives& primitives, const TypedBuffer<uint32_t>& counts,
              const TypedBuffer<uint32_t>& starts, const TypedBuffer<uint32_t>& total) {
  ScheduleRecorder recorder = scheduler.record("count tiles", technique_name);
  primitives.record_exclusive_scan(recorder, "count tiles", counts, starts, total,
                                   static_cast<uint32_t>(counts.count()));
  Schedule schedule = recorder.compile();
  scheduler.run_to_end(schedule);
  scheduler.finish();
  return total.download().front();
}

float4 row(const glm::dmat3& m, int r) {
  return {static_cast<float>(m[0][r]), static_cast<float>(m[1][r]), static_cast<float>(m[2][r]), 0};
}

}  // namespace

TileMaps::TileMaps(Device& device, KernelScheduler& scheduler, const Scene& host_scene, const SceneBuffers& scene,
                   const DirectionGrid& grid, const Patches& patches, const Options& options)
    : host_lines_(make_lines(grid, host_scene.bounds(), options.subfield, options.cell, options.seed)),
      first_cells_(grid.directions() + 1, 0),
      first_coarse_cells_(grid.directions() + 1, 0),
      lines_(device, technique_name, "lines", host_lines_, kRemedy),
      nodes_(device, technique_name, "nodes of the direction grid", grid.nodes(), kRemedy),
      side_facet_(device, technique_name, "facets of texel sides", patches.side_facet, remedies::lower_texels) {
  info_.rotation0 = row(grid.rotation(), 0);
  info_.rotation1 = row(grid.rotation(), 1);
  info_.rotation2 = row(grid.rotation(), 2);
  info_.grid = grid.n();
  info_.lines = grid.lines();
  info_.facets = static_cast<uint32_t>(patches.facets.size());
  info_.subfield = options.subfield;
  info_.cell = static_cast<float>(options.cell);
  info_.texel_edge = options.texel_edge;
  info_.angle = static_cast<float>(grid.spacing());
  if (patches.empty()) {
    maps_ = TypedBuffer<FieldMap>(device, technique_name, "maps of facets", 1);
    tile_cells_ = tile_list_ = TypedBuffer<uint32_t>(device, technique_name, "tiles", 1);
    return;
  }

  const Primitives primitives(device);
  const Program program = make_field_program(device, "tiles/build_maps");
  const TypedBuffer<FieldFacet> facets(device, technique_name, "facets", patches.facets);
  const TypedBuffer<uint32_t> triangles(device, technique_name, "triangles of facets", patches.triangles);
  const size_t maps = size_t{grid.directions()} * patches.facets.size();
  maps_ = TypedBuffer<FieldMap>(device, technique_name, "maps of facets", maps, "lower dir_n, or raise patch_cone");
  const auto facet_pass = [&](ScheduleRecorder& recorder, const char* kernel) {
    PassBuilder pass = recorder.pass(kernel, program, kernel);
    scene.bind(pass);
    bind(pass);
    pass.global(patches.facets.size(), grid.directions()).arg("facets", facets).arg("facet_triangles", triangles);
    return pass;
  };
  const auto run = [&](ScheduleRecorder& recorder) {
    Schedule schedule = recorder.compile();
    if (scheduler.run(schedule) == RunResult::cancelled)
      throw Error(ErrorClass::interrupted, "virtual_light_field: interrupted while finding tiles; nothing was kept");
    scheduler.finish();
  };

  // Rectangles of tiles.
  TypedBuffer<uint32_t> counts(device, technique_name, "sizes of maps", maps, kRemedy);
  TypedBuffer<uint32_t> total(device, technique_name, "total", 1);
  uint32_t max_level = 0;
  for (const FieldFacet& facet : patches.facets) max_level = std::max(max_level, facet.level);
  const TypedBuffer<uint32_t> levels(device, technique_name, "levels of lines", grid.levels(max_level));
  {
    ScheduleRecorder recorder = scheduler.record("bound maps", technique_name);
    facet_pass(recorder, "bound_maps").arg("line_levels", levels).arg("counts", counts);
    run(recorder);
  }
  check_total({counts}, "entries of tile tables");
  const uint32_t entries = scan(scheduler, primitives, counts, counts, total);
  // Tiles in them, or rows.
  const TypedBuffer<uint32_t> spans(device, technique_name, "rows of cells", options.rows ? entries : 1, kRemedy);
  const TypedBuffer<uint32_t> sizes(device, technique_name, "cells of tiles", entries, kRemedy),
      coarse(device, technique_name, "cells of coarse tiles", entries, kRemedy);
  {
    ScheduleRecorder recorder = scheduler.record("mark tiles", technique_name);
    recorder.fill_zero("no cells", sizes);
    recorder.fill_zero("no coarse cells", coarse);
    PassBuilder pass = facet_pass(recorder, options.rows ? "mark_rows" : "mark_tiles");
    pass.arg("starts", counts).arg("fine", sizes).arg("coarse", coarse);
    if (options.rows) pass.arg("spans", spans);
    run(recorder);
  }
  check_total({sizes, coarse}, "cells");
  const TypedBuffer<uint32_t> offsets(device, technique_name, "cells before tiles", entries, kRemedy),
      coarse_offsets(device, technique_name, "cells before coarse tiles", entries, kRemedy);
  info_.first_coarse = scan(scheduler, primitives, sizes, offsets, total);
  cells_ = info_.first_coarse + scan(scheduler, primitives, coarse, coarse_offsets, total);
  tile_cells_ = TypedBuffer<uint32_t>(device, technique_name, "tiles of maps", entries, kRemedy);
  const TypedBuffer<uint32_t> flags(device, technique_name, "flags of tiles", entries, kRemedy);
  const TypedBuffer<uint32_t> list(device, technique_name, "list of tiles", entries, kRemedy);
  const TypedBuffer<uint32_t> first(device, technique_name, "first cells", first_cells_.size()),
      first_coarse(device, technique_name, "first coarse cells", first_cells_.size());
  const TypedBuffer<uint32_t> all(device, technique_name, "entries", std::vector<uint32_t>{entries});
  {
    ScheduleRecorder recorder = scheduler.record("number tiles", technique_name);
    recorder.pass("number tiles", program, "number_tiles")
        .global(entries)
        .arg("count", entries)
        .arg("rows", options.rows ? 1u : 0u)
        .arg("fine_cells", info_.first_coarse)
        .arg("spans", spans)
        .arg("fine", sizes)
        .arg("coarse", coarse)
        .arg("fine_offsets", offsets)
        .arg("coarse_offsets", coarse_offsets)
        .arg("tile_cells", tile_cells_)
        .arg("flags", flags);
    const auto begin_directions = [&](uint32_t before, uint32_t count, const TypedBuffer<uint32_t>& of,
                                      const TypedBuffer<uint32_t>& result) {
      recorder.pass("begin directions", program, "begin_directions")
          .global(first_cells_.size())
          .arg("facets", info_.facets)
          .arg("directions", grid.directions())
          .arg("entries", entries)
          .arg("before", before)
          .arg("total", count)
          .arg("maps", maps_)
          .arg("offsets", of)
          .arg("first_cells", result);
    };
    begin_directions(0, info_.first_coarse, offsets, first);
    begin_directions(info_.first_coarse, coarse_cells(), coarse_offsets, first_coarse);
    primitives.record_compact(recorder, "list tiles", flags, list, total, 0, all, 0, entries);
    run(recorder);
  }
  first_cells_ = first.download();
  first_coarse_cells_ = first_coarse.download();
  tiles_ = total.download().front();
  tile_list_ = TypedBuffer<uint32_t>(device, technique_name, "list of tiles", list.download(0, tiles_), kRemedy);
}

uint32_t TileMaps::largest_line() const {
  uint32_t result = 0;
  for (uint32_t line = 0; line < info_.lines; ++line)
    result = std::max(result, first_cells_[2 * line + 2] - first_cells_[2 * line]);
  return result;
}

uint32_t TileMaps::largest_survey() const {
  uint32_t result = 0;
  for (uint32_t line = 0; line < info_.lines; ++line)
    result = std::max(result, first_cells_[2 * line + 2] - first_cells_[2 * line] + first_coarse_cells_[2 * line + 2] -
                                  first_coarse_cells_[2 * line]);
  return result;
}

void TileMaps::bind(PassBuilder& pass) const {
  pass.arg_if_present("info", info_)
      .arg_if_present("lines", lines_)
      .arg_if_present("nodes", nodes_)
      .arg_if_present("side_facet", side_facet_)
      .arg_if_present("maps", maps_)
      .arg_if_present("tile_cells", tile_cells_);
}

}  // namespace lucarium::vlf
