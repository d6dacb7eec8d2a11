// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <memory>
#include <string>

#include "lucarium/services/intersector.h"
#include "lucarium/services/layered_raster/layered_raster.h"
#include "voxel_abuffer/base/name.h"
#include "voxel_abuffer/structure/triangle_classes.h"

namespace lucarium::abuffer {

/// Where parity looks for crossings in a voxel.
enum class Search {
  columns,      ///< 2D-DDA through all columns
  three_steps,  ///< at four points, then by bisection
  one_step,     ///< at both ends, then by bisection
};

/// By which axis' columns a voxel is searched for parity.
enum class AxisRule {
  absolute_normal,  ///< largest component of the sum of |n|: opposite faces do not cancel
  average_normal,   ///< of the average normal (Hu et al. 2014)
};

/// Where the distance and the barycentrics of hits by parity and by planes come from.
enum class Attributes {
  triangle,  ///< where the ray meets the triangle's plane
  pixel,     ///< distance as found, barycentrics of the pixel's centre (Hu et al. 2014)
  stored,    ///< the same bits, from attributes stored beside every fragment, 32 bytes together, as in the paper
};

struct VoxelAbufferOptions {
  uint32_t abuffer_size = 1280;  ///< n: pixels per side of an A-buffer, 128 to 4096
  uint32_t grid_size = 0;        ///< N: voxels along the longest side; 0: choose_grid_size()
  Intersect intersect = Intersect::automatic;
  Search search = Search::columns;
  AxisRule axis_rule = AxisRule::absolute_normal;
  bool conservative_voxels = true;  ///< voxels that triangles touch are occupied; else those that hold fragments
  uint32_t bisections = 10;         ///< 4 to 16
  float offset = 1;                 ///< β: of parity rays off the surfaces at their ends [pixels], 0.5 to 4
  Attributes attributes = Attributes::triangle;
  LayeredVariant list = LayeredVariant::tiles;  ///< tiles, exact (counted) or linked_list: the same structure
  bool count_work = false;                      ///< AbufferWork, and how long lists are, at the cost of time
};

/// What rays did since the structure was made; all 0 without count_work.
struct AbufferWork {
  uint64_t searches = 0;          ///< begun: two per ray where there are triangles for parity and for exact search
  uint64_t voxel_steps = 0;       ///< to the next voxel, or over a cube of empty bricks or free voxels
  uint64_t column_steps = 0;      ///< columns looked at, points for sampled searches
  uint64_t bisection_steps = 0;   ///< further points
  uint64_t triangle_tests = 0;    ///< by exact search
  uint64_t ambiguous_starts = 0;  ///< states that are the same on both sides of the surface that the ray leaves
  uint64_t facing_misses = 0;     ///< crossings beside which no triangle faces as they do
};

struct VoxelAbufferStatistics {
  uint32_t abuffer_size = 0, grid_size = 0;  ///< as chosen
  uint32_t parity_triangles = 0, exact_triangles = 0;
  uint32_t open_components = 0;
  size_t parity_fragments = 0, exact_fragments = 0;
  double expected_parity_fragments = 0, expected_exact_fragments = 0;  ///< in the mean over positions of the grid
  uint32_t longest_list = 0;        ///< fragments of a column; with count_work, as the next
  uint32_t filled_columns = 0;      ///< over all axes and both kinds of lists
  uint32_t unbalanced_columns = 0;  ///< over all tries of the last build, with intersect=auto, as the next
  uint32_t touching_columns = 0;    ///< with walls that two components share, or two parts of one
  uint32_t moved_components = 0;    ///< closed ones that became exact: their seams have opened, or they share a wall
  uint64_t builds = 0;
  double build_seconds = 0;  ///< of the last one, elapsed
  size_t bytes = 0;          ///< on the device
};

/// Ray tracing through a coarse voxel grid and three orthographic A-buffers, one along each axis, rasterized again
/// after every motion (Hu et al. 2014, "Ray tracing via GPU rasterization", section 3). Owner "voxel_abuffer" in the
/// memory account. Results do not depend on the number of threads, nor on the way in which lists are made.
class VoxelAbuffer : public Intersector {
 public:
  /// Of the whole scene, or of a subset: rays meet nothing else. Refuses with Error{device} naming abuffer_size or
  /// grid_size, and the numbers, what does not fit into memory. `scheduler` and `buffers` must outlive this.
  VoxelAbuffer(KernelScheduler& scheduler, const Scene& scene, const SceneBuffers& buffers,
               const VoxelAbufferOptions& options = {}, const SceneSubset& subset = {});
  ~VoxelAbuffer() override;

  /// Follows a change; after SceneBuffers::update(). Geometry builds everything again, on the device; cameras, lights
  /// and opaque materials build nothing. The same as a new one over the changed scene, bit for bit.
  void update(const Scene& scene, const SceneChange& change);
  /// Another subset or size of its pixels, from the next update() on; instances belong to either from one topology to
  /// the next.
  void set_subset(const SceneSubset& subset);
  /// Builds again although nothing changed (the paper does for every frame).
  void rebuild();
  /// Grows when passes recorded before must be recorded again.
  uint64_t generation() const;

  std::string name() const override { return technique_name; }
  bool wants_ends() const override;
  void record_closest(ScheduleRecorder& recorder, const std::string& pass_name, const RayBuffers& rays,
                      const BufferRef& hits) const override;
  void record_any(ScheduleRecorder& recorder, const std::string& pass_name, const RayBuffers& rays,
                  const BufferRef& occluded) const override;

  const VoxelAbufferStatistics& statistics() const;
  AbufferWork work() const;
  const VoxelAbufferOptions& options() const;

  struct State;
  const State& state() const { return *state_; }  ///< what tests look at

 private:
  std::unique_ptr<State> state_;
};

}  // namespace lucarium::abuffer
