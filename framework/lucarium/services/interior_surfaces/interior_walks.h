// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "lucarium/scene/device/scene_buffers.h"
#include "lucarium/services/intersector.h"

namespace lucarium {

/// Which surfaces lie inside solids (columns that stand in floors, walls that pass through each other): no light ever
/// comes there and nothing looks from there, so that techniques that keep light on surfaces leave them out.
///
/// The definition, for texels (TexelInterior) and points (PointInterior) alike: random walks leave the surface, cosine
/// distributed, and go on from where they meet fronts. A walk that meets the back of a single-sided surface is inside a
/// solid, and caught; one that meets glass, leaves the scene, or has gone `steps` steps has escaped; two-sided sheets
/// let walks go on. A side from which no walk escapes is interior. MASK and BLEND are decided ray by ray.
///
/// Users differ in one parameter, how many steps prove that light gets somewhere, and the reason is theirs to say.
struct InteriorRule {
  /// 1: unless the first ray hits a back, the surface counts as seen. More steps also find solids inside solids and
  /// gaps between solids; each costs a ray.
  uint32_t steps = 6;
  /// Fronts that are no farther apart see nothing of each other: walks between solids that touch are caught [m].
  float contact = 0;
};

/// Follows walks whose first rays the caller has aimed.
class InteriorWalks {
 public:
  InteriorWalks(Device& device, const SceneBuffers& scene, const Intersector& intersector, const InteriorRule& rule);

  /// Records all steps of walks. `rays`: the first ones, inactive where there is no walk; they and their ends are
  /// overwritten. counter_index is 0. escaped[i] (uchar) becomes 1 where a walk escapes, and stays as it is elsewhere.
  void record(ScheduleRecorder& recorder, const RayBuffers& rays, const BufferRef& escaped) const;
  const Intersector& intersector() const { return *intersector_; }
  const Program& program() const { return program_; }  ///< walks.cl
  const SceneBuffers& scene() const { return *scene_; }

  /// Transient memory of `capacity` walks [bytes], their rays not included.
  static size_t estimate_bytes(size_t capacity) { return capacity * sizeof(Hit); }

 private:
  const SceneBuffers* scene_;
  const Intersector* intersector_;
  InteriorRule rule_;
  Program program_;
};

}  // namespace lucarium
