// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <map>
#include <string>

#include "voxel_abuffer/base/scene_subset.h"
#include "voxel_abuffer/structure/voxel_abuffer.h"

namespace lucarium::abuffer {

/// Two structures: what rests, and what animations move. A motion builds the second one alone, within its own bounds;
/// rays are traced through both, each with its own states of points, and the nearer hit counts. The paper leaves that
/// to future work (Hu et al. 2014, section 6). Hits are those of one structure where search is exact.
class MovingSet : public Intersector {
 public:
  MovingSet(KernelScheduler& scheduler, const Scene& scene, const SceneBuffers& buffers,
            const VoxelAbufferOptions& options);

  /// Follows a change, as VoxelAbuffer does. What rests is built again only if it has moved after all.
  void update(const Scene& scene, const SceneChange& change);
  /// Builds what moves again.
  void rebuild() { moving_.rebuild(); }
  uint64_t generation() const { return resting_.generation() + moving_.generation(); }

  std::string name() const override { return "voxel_abuffer, two sets"; }
  bool wants_ends() const override { return resting_.wants_ends(); }
  void record_closest(ScheduleRecorder& recorder, const std::string& pass_name, const RayBuffers& rays,
                      const BufferRef& hits) const override;
  void record_any(ScheduleRecorder& recorder, const std::string& pass_name, const RayBuffers& rays,
                  const BufferRef& occluded) const override;

  const VoxelAbuffer& resting() const { return resting_; }
  const VoxelAbuffer& moving() const { return moving_; }
  /// Sums over both; the time of the last build is that of what moves.
  VoxelAbufferStatistics statistics() const;
  AbufferWork work() const;

  /// The moving subset of a scene: its pixels are as large as those of what rests, or larger where it extends farther.
  static SceneSubset moving_subset(const Scene& scene, const VoxelAbufferOptions& options);

 private:
  Program program_;
  VoxelAbuffer resting_, moving_;
};

}  // namespace lucarium::abuffer
