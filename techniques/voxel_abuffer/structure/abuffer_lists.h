// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <string>

#include "lucarium/services/layered_raster/layered_raster.h"
#include "lucarium/services/primitives/primitives.h"
#include "voxel_abuffer/structure/grid_layout.h"

namespace lucarium::abuffer {

/// The fragment lists of three axes, in the order of voxel columns: start of each column's list, depths and triangles.
/// Exact lists hold each triangle in the columns of its dominant axis only, every column that it touches
/// (conservative), with intervals of depth; parity lists hold each triangle in all three, where it covers the columns'
/// centres.
class AbufferLists {
 public:
  enum class Kind { exact, parity };
  /// For grids of at most `size`. `stored`: attributes beside fragments for parity.
  AbufferLists(KernelScheduler& scheduler, const SceneBuffers& buffers, Kind kind, const GridSize& size,
               bool stored = false);

  /// Follows a change of the scene; after SceneBuffers::update().
  void update() { raster_.update(); }
  uint64_t generation() const { return generation_ + raster_.generation(); }

  /// Makes room for that many fragments (and more, so that a motion rarely needs more).
  void reserve(const AbufferGrid& grid, size_t fragments);
  size_t capacity() const { return capacity_; }
  size_t bytes() const { return start_.bytes() + depths_.bytes() + fragments_.bytes() + attributes_.bytes(); }
  static size_t estimate_bytes(const AbufferGrid& grid, size_t fragments, bool stored = false);

  /// Records the three views, and their lists. Exact lists are filled straight from the raster's tiles, others packed
  /// from a stored A-buffer; both give the same. `views`: three LayeredView from `first_view` on.
  struct Sources {
    BufferRef grid, views, classes, planes, triangles, counts, voxels, cells, facing;
    uint32_t cell_capacity = 0;  ///< blocks
  };
  void record(ScheduleRecorder& recorder, const AbufferGrid& grid, const Sources& sources, uint32_t first_view,
              const LayeredStoreOptions& store);

  /// Marks the voxels that hold fragments; once all lists are recorded.
  void record_voxels(ScheduleRecorder& recorder, const AbufferGrid& grid, const Sources& sources) const;
  /// Counts how long lists are: ABUFFER_COUNT_LONGEST, ABUFFER_COUNT_FILLED.
  void record_measures(ScheduleRecorder& recorder, const Sources& sources) const;
  /// Marks the cells of voxels that exact fragments touch, or in which states change; once voxels know where theirs
  /// are.
  void record_cells(ScheduleRecorder& recorder, const AbufferGrid& grid, const Sources& sources) const;

  const TypedBuffer<uint32_t>& start() const { return start_; }
  const TypedBuffer<uint32_t>& depths() const { return depths_; }
  const TypedBuffer<uint32_t>& fragments() const { return fragments_; }
  const TypedBuffer<AbufferAttributes>& attributes() const { return attributes_; }  ///< empty unless stored

 private:
  struct Axis {
    explicit Axis(Kind kind, uint32_t k)
        : name(std::string(kind == Kind::exact ? "exact_" : "parity_") + "xyz"[k]), index(k) {}
    std::string name;
    uint32_t index;
  };
  uint32_t first_count() const { return kind_ == Kind::exact ? 0 : ABUFFER_COUNT_EXACT + 1; }
  void record_base(ScheduleRecorder& recorder, const Sources& sources, const Axis& axis, const BufferRef& total,
                   uint32_t index) const;
  void bind_lists(PassBuilder& pass, const Sources& sources, const Axis& axis) const;
  void record_touched(ScheduleRecorder& recorder, const AbufferGrid& grid, const Sources& sources, const Axis& axis,
                      const LayeredRaster::ViewRef& view);
  void record_packed(ScheduleRecorder& recorder, const AbufferGrid& grid, const Sources& sources, const Axis& axis,
                     const LayeredRaster::ViewRef& view, const LayeredStoreOptions& store) const;
  void record_attributes(ScheduleRecorder& recorder, const AbufferGrid& grid, const Sources& sources,
                         const Axis& axis) const;
  Kind kind_;
  bool stored_;
  Device* device_;
  LayeredRaster raster_;
  Primitives primitives_;
  const SceneBuffers* buffers_;
  Program pack_, cells_, voxels_, touched_, attributes_program_;
  uint64_t touched_generation_ = 0;
  TypedBuffer<uint32_t> start_, depths_, fragments_;
  TypedBuffer<AbufferAttributes> attributes_;
  size_t capacity_ = 0;
  uint64_t generation_ = 0;
};

}  // namespace lucarium::abuffer
