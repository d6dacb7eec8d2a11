// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <array>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "lucarium/compute/schedule/scheduler.h"
#include "lucarium/scene/device/scene_buffers.h"
#include "lucarium/shared/layered_raster.h"

namespace lucarium {

struct LayeredRasterOptions {
  uint32_t max_width = 1024, max_height = 1024;  ///< pixels; views may be smaller; at most LAYERED_MAX_EDGE
  bool perspective = false;                      ///< what views are; all of one raster are of a kind
  bool conservative = false;  ///< every pixel that a triangle touches, not only those whose centre it covers
  bool portable = false;      ///< without compiler built-ins; the same results
  bool classes = false;       ///< a view draws only triangles of some classes: ViewRef::classes, LayeredView::classes
  bool keep_alpha = false;    ///< MASK and BLEND keep all fragments, as if they were opaque: the consumer decides
  /// Layers of a tile's pixel row that are sorted at once: 4, 8, 16, 32 or 64; deeper rows are peeled in parts.
  /// 0: 64 on a processor, 16 on other devices: those set 2 kB per layer aside for every work-item that could ever be
  /// resident. The same fragments; what adds rays of deeper rows may add them in another order.
  uint32_t row_layers = 0;
  std::string remedy = "lower the resolution of the raster";  ///< what to do when memory does not suffice
};

/// Ways to a stored A-buffer. All but k_buffer give the same fragments; all but tiles are there for comparison.
enum class LayeredVariant {
  tiles,        ///< in tiles, without atomics
  exact,        ///< one work-item per triangle: count, scan, fill with atomics, sort
  linked_list,  ///< one work-item per triangle, a linked list per pixel with atomics, collected and sorted
  k_buffer,     ///< in tiles, only the nearest `keep` fragments of a pixel; counts what it drops
};

struct LayeredStoreOptions {
  LayeredVariant variant = LayeredVariant::tiles;
  uint32_t keep = 8;           ///< k_buffer: 1 to LAYERED_MAX_LAYERS
  uint32_t list_capacity = 8;  ///< linked_list: nodes per pixel at first; more when they do not suffice
};

struct LayeredBins;  ///< triangles of one view, set up and sorted into tiles (state.h)

/// Rasterizes the scene's world triangles: all fragments of every pixel in depth order (an A-buffer, Carpenter 1984),
/// or only the nearest (a k-buffer, Bavoil et al. 2007). Vertices are snapped to 1/256 pixel; coverage is exact from
/// there (integer edge functions, top-left rule), so that meshes are watertight and no fragment is ever dropped.
/// Triangles without area, which rays never hit, have none. MASK discards fragments, BLEND keeps them with probability
/// alpha, decided by triangle, pixel and LayeredView::seed (LayeredRasterOptions::keep_alpha: neither does). Order:
/// depth to 1/2²² of the view's range, then fronts that face along the view first, then by triangle (clipped triangles
/// after others). Results do not depend on the number of threads.
///
/// Consumers either walk over sorted fragments while they are in registers (record_tiles(),
/// framework/lucarium/services/layered_raster/tiles.clh), or read a stored A-buffer (record_stored()).
class LayeredRaster {
 public:
  /// `scene` must outlive this. `owner` pays for the memory.
  LayeredRaster(KernelScheduler& scheduler, const SceneBuffers& scene, const LayeredRasterOptions& options,
                const std::string& owner = "layered raster");
  ~LayeredRaster();

  /// Follows a change of the scene; to be called after SceneBuffers::update().
  void update();
  /// Grows when recorded schedules must be recorded again after update().
  uint64_t generation() const;

  /// Compile a program that includes tiles.clh with these (after update(), when generation() grew).
  std::map<std::string, std::string> defines() const;

  /// Records set-up, binning and the consumer's kernel, once for even rows of tiles and once for odd ones. `views`
  /// holds LayeredView; which one is `view`, or `view_variable`. `bind` binds the kernel's own arguments.
  struct ViewRef {
    BufferRef views;
    Variable<uint32_t> index;
    /// With LayeredRasterOptions::classes, else unused: a byte (uchar) per world triangle, in whole blocks of 16
    /// (class_bytes()). Read when the schedule runs, so that a kernel may write it.
    BufferRef classes = {};
  };
  /// Elements of ViewRef::classes for so many triangles.
  static size_t class_bytes(size_t triangles) { return 16 * std::max<size_t>(1, (triangles + 15) / 16); }

  void record_tiles(ScheduleRecorder& recorder, const std::string& name, const ViewRef& view, const Program& program,
                    std::string_view kernel, const std::function<void(PassBuilder&)>& bind) const;

  /// Set-up and binning alone, for several consumers of one schedule.
  std::shared_ptr<const LayeredBins> record_bins(ScheduleRecorder& recorder, const std::string& name,
                                                 const ViewRef& view) const;
  void record_tiles(ScheduleRecorder& recorder, const std::string& name, const ViewRef& view, const LayeredBins& bins,
                    const Program& program, std::string_view kernel,
                    const std::function<void(PassBuilder&)>& bind) const;

  /// A stored A-buffer: pixel_start holds width · height + 1 uints (exclusive sums; row by row of the view's width),
  /// fragments LayeredFragment, dropped one uint (0 except with k_buffer). All live in the schedule.
  struct Stored {
    BufferRef pixel_start, fragments, dropped;
  };
  Stored record_stored(ScheduleRecorder& recorder, const std::string& name, const ViewRef& view,
                       const LayeredStoreOptions& options = {}) const;

  /// What is seen: the first fragment of every pixel. depth (float; INFINITY: nothing) and triangle (uint, with
  /// LAYERED_AWAY; LUCARIUM_NONE) hold max_width · max_height elements, row by row of the view's width; those behind
  /// its last row stay as they were.
  void record_nearest(ScheduleRecorder& recorder, const std::string& name, const ViewRef& view, const BufferRef& depth,
                      const BufferRef& triangle) const;

  /// Expected device memory of a raster of `triangles`, the transients of a schedule included [bytes]; with an A-buffer
  /// where `stored` says how it is made. Taken for granted: four surfaces behind each other. `schedules`: that
  /// rasterize, each with transients of its own.
  static size_t estimate_bytes(size_t triangles, const LayeredRasterOptions& options,
                               const std::optional<LayeredStoreOptions>& stored, size_t schedules = 1);

 private:
  class ListStore;
  struct State;
  std::unique_ptr<State> state_;
};

/// An orthographic view along unit `direction`: `right` is a unit vector orthogonal to it, x grows along it and y along
/// direction × right. The raster image is `width` × `height` square pixels of `pixel_size` [m], pixel (0, 0) begins at
/// `corner` (in-plane coordinates along x and y relative to `center`); depths are relative to `center`, from -depth to
/// depth [m].
LayeredView orthographic_view(const glm::vec3& center, const glm::vec3& direction, const glm::vec3& right,
                              float pixel_size, uint32_t width, uint32_t height, float depth, const glm::vec2& corner);
/// A perspective view: horizontal extent at unit distance is 2·tan_half_width; depths are along `direction`.
LayeredView perspective_view(const glm::vec3& eye, const glm::vec3& direction, const glm::vec3& down,
                             float tan_half_width, uint32_t width, uint32_t height, float near_depth, float far_depth);
/// Faces +x, −x, +y, −y, +z, −z of a cube around `eye`, each a square perspective view of 90°.
std::array<LayeredView, 6> cube_views(const glm::vec3& eye, uint32_t size, float near_depth, float far_depth);

}  // namespace lucarium
