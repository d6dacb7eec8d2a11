// SPDX-License-Identifier: Apache-2.0
#include "voxel_abuffer/moving/moving_set.h"

#include <algorithm>

#include "voxel_abuffer/structure/grid_layout.h"

const lucarium::EmbeddedSources& voxel_abuffer_kernels();

namespace lucarium::abuffer {

SceneSubset MovingSet::moving_subset(const Scene& scene, const VoxelAbufferOptions& options) {
  SceneSubset subset = moving_instances(scene);
  const Bounds rest = resting_instances(scene).bounds(scene);
  const bool exact = options.intersect == Intersect::exact;
  if (!rest.empty())
    subset.min_pixel = make_grid(choose_grid_size(options.abuffer_size, options.grid_size, exact), rest, 0).center.w;
  return subset;
}

MovingSet::MovingSet(KernelScheduler& scheduler, const Scene& scene, const SceneBuffers& buffers,
                     const VoxelAbufferOptions& options)
    : program_(make_program(scheduler.device(), voxel_abuffer_kernels(), {"voxel_abuffer/moving/nearer_hits"})),
      resting_(scheduler, scene, buffers, options, resting_instances(scene)),
      moving_(scheduler, scene, buffers, options, moving_subset(scene, options)) {}

void MovingSet::update(const Scene& scene, const SceneChange& change) {
  const SceneSubset moving = moving_subset(scene, resting_.options());
  const auto rests = [&](int instance) { return !moving.has(static_cast<size_t>(instance)); };
  const bool moved_after_all = change.topology ||
                               std::any_of(change.moved_instances.begin(), change.moved_instances.end(), rests) ||
                               std::any_of(change.deformed_instances.begin(), change.deformed_instances.end(), rests);
  SceneChange elsewhere = change;  // for those that rest
  if (!moved_after_all) {
    elsewhere.moved_instances.clear();
    elsewhere.previous_world_from_object.clear();
    elsewhere.deformed_instances.clear();
  }
  if (change.topology) resting_.set_subset(resting_instances(scene));
  resting_.update(scene, elsewhere);
  moving_.set_subset(moving);
  moving_.update(scene, change);
}

void MovingSet::record_closest(ScheduleRecorder& recorder, const std::string& pass_name, const RayBuffers& rays,
                               const BufferRef& hits) const {
  const BufferRef others = recorder.transient<Hit>(pass_name + ", hits of what moves", rays.capacity);
  resting_.record_closest(recorder, pass_name + ", resting", rays, hits);
  moving_.record_closest(recorder, pass_name + ", moving", rays, others);
  recorder.pass(pass_name + ", nearer", program_, "abuffer_nearer_hits")
      .global(rays.capacity)
      .arg("counter", rays.counter)
      .arg("counter_index", rays.counter_index)
      .arg("capacity", rays.capacity)
      .arg("others", others)
      .arg("hits", hits);
}

void MovingSet::record_any(ScheduleRecorder& recorder, const std::string& pass_name, const RayBuffers& rays,
                           const BufferRef& occluded) const {
  const BufferRef others = recorder.transient<uint32_t>(pass_name + ", occluded by what moves", rays.capacity);
  resting_.record_any(recorder, pass_name + ", resting", rays, occluded);
  moving_.record_any(recorder, pass_name + ", moving", rays, others);
  recorder.pass(pass_name + ", either", program_, "abuffer_either_occludes")
      .global(rays.capacity)
      .arg("counter", rays.counter)
      .arg("counter_index", rays.counter_index)
      .arg("capacity", rays.capacity)
      .arg("others", others)
      .arg("occluded", occluded);
}

VoxelAbufferStatistics MovingSet::statistics() const {
  const VoxelAbufferStatistics& rest = resting_.statistics();
  VoxelAbufferStatistics all = moving_.statistics();
  all.parity_triangles += rest.parity_triangles;
  all.exact_triangles += rest.exact_triangles;
  all.open_components += rest.open_components;
  all.parity_fragments += rest.parity_fragments;
  all.exact_fragments += rest.exact_fragments;
  all.expected_parity_fragments += rest.expected_parity_fragments;
  all.expected_exact_fragments += rest.expected_exact_fragments;
  all.unbalanced_columns += rest.unbalanced_columns;
  all.touching_columns += rest.touching_columns;
  all.moved_components += rest.moved_components;
  all.longest_list = std::max(all.longest_list, rest.longest_list);
  all.filled_columns += rest.filled_columns;
  all.builds += rest.builds;
  all.bytes += rest.bytes;
  return all;
}

AbufferWork MovingSet::work() const {
  const AbufferWork rest = resting_.work();
  AbufferWork all = moving_.work();
  all.searches += rest.searches;
  all.voxel_steps += rest.voxel_steps;
  all.column_steps += rest.column_steps;
  all.bisection_steps += rest.bisection_steps;
  all.triangle_tests += rest.triangle_tests;
  all.ambiguous_starts += rest.ambiguous_starts;
  all.facing_misses += rest.facing_misses;
  return all;
}

}  // namespace lucarium::abuffer
