// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <map>
#include <optional>

#include "lucarium/services/primitives/primitives.h"
#include "voxel_abuffer/structure/abuffer_lists.h"
#include "voxel_abuffer/structure/voxel_abuffer.h"

namespace lucarium::abuffer {

/// What to do when memory does not suffice.
inline constexpr const char* coarser_grid = "lower grid_size";

struct VoxelAbuffer::State {
  State(KernelScheduler& scheduler, const SceneBuffers& buffers, const VoxelAbufferOptions& options,
        const SceneSubset& subset);

  void classify_scene(const Scene& scene);
  /// Where its triangles are: of a subset, from the host's scene.
  void find_bounds(const Scene& scene);
  void build();
  /// Grid, classes, planes and corners of triangles; the numbers of fragments to expect.
  void prepare();
  void reserve();
  void record_build();
  void record_voxels(ScheduleRecorder& recorder, const AbufferLists::Sources& sources);
  void record_cells(ScheduleRecorder& recorder, const AbufferLists::Sources& sources);
  void record_axes(ScheduleRecorder& recorder);
  void run_build();
  /// Moves components that the build marked to exact search; whether there were any.
  bool move_marked();
  /// Whether voxels that parity searches have reaches (ABUFFER_REACHES).
  bool with_reaches() const;
  void compile();
  void record(ScheduleRecorder& recorder, const std::string& pass_name, const char* kernel, const RayBuffers& rays,
              const char* result_name, const BufferRef& result) const;

  KernelScheduler* scheduler;
  Device* device;
  const SceneBuffers* buffers;
  VoxelAbufferOptions options;
  SceneSubset subset;
  Bounds bounds;
  GridSize size;
  TriangleClasses loaded_classes;  ///< of the scene's meshes
  TriangleClasses classes;         ///< less the components that the last build moved
  Primitives primitives;
  Program prepare_program, voxel_program, search_program;
  std::map<std::string, std::string> search_defines;
  bool search_alpha = false;
  std::optional<AbufferLists> exact, parity;

  AbufferGrid grid{};
  TypedBuffer<AbufferGrid> grid_buffer;
  TypedBuffer<LayeredView> views;  ///< exact x, y, z, parity x, y, z
  TypedBuffer<uint32_t> component_of;
  TypedBuffer<uint8_t> component_class, triangle_classes;
  TypedBuffer<AbufferPlane> planes;
  TypedBuffer<float> triangles, expected_exact, expected_parity, exact_sum, parity_sum;
  TypedBuffer<uint32_t> voxels, counts;
  TypedBuffer<uint32_t> marked;  ///< components that parity does not search rightly, and two numbers of columns
  TypedBuffer<uint64_t> bricks, cells;
  TypedBuffer<int2> facing;    ///< per voxel and axis
  TypedBuffer<uint32_t> work;  ///< with count_work, what rays did: low and high words

  Schedule prepare_schedule, build_schedule;
  uint64_t recorded_lists = 0;  ///< generation of the lists when the build was recorded
  uint64_t scene_generation = 0;
  uint32_t recorded_voxels[4] = {};
  VoxelAbufferStatistics statistics;
  uint64_t generation = 0;
};

}  // namespace lucarium::abuffer
