// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "lucarium/compute/schedule/scheduler.h"
#include "lucarium/scene/device/scene_buffers.h"
#include "lucarium/services/bvh/bvh.h"
#include "lucarium/services/interior_surfaces/point_interior.h"
#include "micro_rendering/points/scene_sides.h"
#include "micro_rendering/shared/micro_types.h"

namespace lucarium::micro {

/// The leaf at a point.
MicroLeaf leaf_of(const SampledPoint& point);

/// Which sides of points anything sees (interior_walks.h). What moves hides nothing, since it may move away, nor do
/// MASK and BLEND surfaces, since they are there for some rays only.
///
/// Points inside solids get no light and would do harm: their discs reach beyond the line where two solids meet, nodes
/// that hold them and their lit neighbours show the mean of both, and nodes may gather where it is dark. So they are
/// left out.
///
/// Where no walk from a point's back escapes, only the inside of a solid sees that back, and it is transparent.
/// Otherwise a gather that looks through a gap between front discs would hit a black back, instead of an empty pixel
/// that is filled as a hole.
class PointVisibility {
 public:
  /// `intersector`: of the whole scene; `sources`: all trees; `contact`: see InteriorRule.
  PointVisibility(Device& device, KernelScheduler& scheduler, const ScenePoints& scene_points,
                  const SceneBuffers& buffers, const Intersector& intersector, const std::vector<TreeSource>& sources,
                  float contact, const std::string& owner);

  using Progress = PointInterior::Progress;
  /// Whether something sees the front of each point. Throws Error{interrupted}.
  std::vector<bool> fronts(const std::vector<SampledPoint>& points, const Progress& progress) const;
  /// Whether something sees the backs of those points that are on single-sided surfaces.
  std::vector<bool> backs(const std::vector<SampledPoint>& points, const Progress& progress) const;
  static size_t estimate_bytes(const Scene& scene, size_t points);

 private:
  std::unique_ptr<Bvh> resting_;  ///< without what moves
  const ScenePoints& scene_points_;
  PointInterior interior_;
};

/// Samples the surfaces of trees where something sees their fronts.
class VisibleSampler {
 public:
  /// `visibility`: null where everything counts as seen; `backs`: whether backs are asked for.
  VisibleSampler(const ScenePoints& scene_points, PointVisibility* visibility, bool backs, uint32_t seed, int threads)
      : scene_points_(scene_points), visibility_(visibility), backs_(backs), seed_(seed), threads_(threads) {}

  /// Share of a tree's surface whose front something sees, from `points` points; 1 for what moves.
  double visible_share(const TreeSource& source, uint32_t points) const;
  /// sample_surface() there. `share`: visible_share(); where it was too large hidden points make up the number.
  /// SampledSurface::area is the visible area; points know whether they are solid.
  SampledSurface sample(const TreeSource& source, double share, uint32_t count,
                        const PointVisibility::Progress& progress) const;

 private:
  bool measures(const TreeSource& source) const { return visibility_ && source.kind == TreeKind::resting; }
  const ScenePoints& scene_points_;
  PointVisibility* visibility_;
  bool backs_;
  uint32_t seed_;
  int threads_;
};

}  // namespace lucarium::micro
