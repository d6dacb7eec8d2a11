// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <utility>

#include "lucarium/services/layered_raster/layered_raster.h"
#include "lucarium/services/primitives/primitives.h"

namespace lucarium {

/// Triangles of one view, set up and sorted into tiles.
struct LayeredBins {
  BufferRef records;               ///< LayeredRecord per world triangle
  BufferRef extra;                 ///< LayeredRecord per part of a clipped triangle
  BufferRef clips;                 ///< LayeredClip likewise
  BufferRef starts;                ///< per tile, and one more: where its triangles begin in `pairs`
  BufferRef bounds, extra_bounds;  ///< tiles of each record, packed
  BufferRef clipped;               ///< number of clipped triangles
  BufferRef pairs;                 ///< records, those in `extra` counted on
};

struct LayeredRaster::State {
  State(KernelScheduler& scheduler, const SceneBuffers& scene, const LayeredRasterOptions& options,
        const std::string& owner);
  void follow();
  /// Takes the triangles that have no area out of `geometry`.
  void leave_out_degenerate();
  std::map<std::string, std::string> defines() const;
  LayeredBins record_bins(ScheduleRecorder& recorder, const std::string& name, const ViewRef& view) const;
  void record_tiles(ScheduleRecorder& recorder, const std::string& name, const ViewRef& view, const LayeredBins& bins,
                    const Program& consumer, std::string_view kernel,
                    const std::function<void(PassBuilder&)>& bind) const;
  /// A work-item for each tile: for kernels that write to their own tiles alone (LAYERED_RUN_TILE).
  void record_each_tile(ScheduleRecorder& recorder, const std::string& name, const ViewRef& view,
                        const LayeredBins& bins, const Program& consumer, std::string_view kernel,
                        const std::function<void(PassBuilder&)>& bind) const;
  void record_rows(ScheduleRecorder& recorder, const std::string& name, const ViewRef& view, const LayeredBins& bins,
                   const Program& consumer, std::string_view kernel, uint32_t parity, uint32_t rows,
                   const std::function<void(PassBuilder&)>& bind) const;
  /// Binds LAYERED_TILE_PARAMETERS (and the scene, if the kernel wants it).
  void bind_tiles(PassBuilder& pass, const ViewRef& view, const LayeredBins& bins, uint32_t parity) const;
  Stored record_tile_store(ScheduleRecorder& recorder, const std::string& name, const ViewRef& view,
                           uint32_t keep) const;
  void record_nearest(ScheduleRecorder& recorder, const std::string& name, const ViewRef& view, const BufferRef& depth,
                      const BufferRef& triangle) const;
  /// Compiled when first wanted. `keep` above 0: LAYERED_KEEP.
  const Program& consumer(const std::string& file, uint32_t keep = 0) const;

  KernelScheduler& scheduler;
  const SceneBuffers& scene;
  LayeredRasterOptions options;
  std::string owner;
  Primitives primitives;
  Program program;
  mutable std::map<std::pair<std::string, uint32_t>, Program> consumers;
  TypedBuffer<float> geometry;   ///< blocks of 16 de-indexed triangles
  TypedBuffer<float4> boxes;     ///< of each block: centre and half its size
  TypedBuffer<uint32_t> unsure;  ///< per block, those (bits) that may have no area
  Schedule gather;
  uint32_t triangles = 0;
  bool alpha = false;
  uint64_t scene_generation = 0, generation = 0;
};

}  // namespace lucarium
