// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <vector>

#include "lucarium/compute/schedule/scheduler.h"
#include "lucarium/scene/device/scene_buffers.h"
#include "virtual_light_field/directions/direction_grid.h"
#include "virtual_light_field/tiles/patches.h"

namespace lucarium::vlf {

/// The subfields of all lines, and where the cells of every facet are on them.
class TileMaps {
 public:
  struct Options {
    uint32_t subfield = 0;  ///< N
    double cell = 0;        ///< c [m]
    float texel_edge = 0;   ///< [m]
    uint64_t seed = 1;
    bool rows = false;  ///< store=csr: cells in rows, without tiles
  };
  /// Finds the tiles. Refuses with Error{device}, naming dir_n and cells, what 32 bits cannot number or memory cannot
  /// hold. `scene` must outlive this.
  TileMaps(Device& device, KernelScheduler& scheduler, const Scene& host_scene, const SceneBuffers& scene,
           const DirectionGrid& grid, const Patches& patches, const Options& options);

  const FieldInfo& info() const { return info_; }
  uint32_t cells() const { return cells_; }
  /// Of facets with a level, behind all others: from info().first_coarse on.
  uint32_t coarse_cells() const { return cells_ - info_.first_coarse; }
  uint32_t tiles() const { return tiles_; }
  const std::vector<FieldLine>& host_lines() const { return host_lines_; }
  /// First cell of each direction, and the number of cells behind the last: those of a line follow each other. Those of
  /// facets with a level are counted apart.
  const std::vector<uint32_t>& first_cells() const { return first_cells_; }
  const std::vector<uint32_t>& first_coarse_cells() const { return first_coarse_cells_; }
  uint32_t largest_line() const;    ///< cells of facets without a level
  uint32_t largest_survey() const;  ///< all cells

  const TypedBuffer<FieldLine>& lines() const { return lines_; }
  const TypedBuffer<uint32_t>& nodes() const { return nodes_; }
  const TypedBuffer<uint32_t>& side_facet() const { return side_facet_; }
  const TypedBuffer<FieldMap>& maps() const { return maps_; }              ///< [direction][facet]
  const TypedBuffer<uint32_t>& tile_cells() const { return tile_cells_; }  ///< see FieldMap
  const TypedBuffer<uint32_t>& tile_list() const { return tile_list_; }    ///< entries of tile_cells that are tiles
  /// Bytes of maps and tile_cells, which find cells, and of tile_list, which only propagation needs.
  size_t index_bytes() const { return maps_.bytes() + tile_cells_.bytes(); }
  size_t list_bytes() const { return tile_list_ ? tile_list_.bytes() : 0; }
  void end_propagation() { tile_list_ = {}; }
  /// Binds what the kernel has a parameter for: info (by value), lines, nodes, side_facet, maps, tile_cells.
  void bind(PassBuilder& pass) const;

 private:
  FieldInfo info_{};
  std::vector<FieldLine> host_lines_;
  std::vector<uint32_t> first_cells_, first_coarse_cells_;
  uint32_t cells_ = 0, tiles_ = 0;
  TypedBuffer<FieldLine> lines_;
  TypedBuffer<uint32_t> nodes_, side_facet_, tile_cells_, tile_list_;
  TypedBuffer<FieldMap> maps_;
};

}  // namespace lucarium::vlf
