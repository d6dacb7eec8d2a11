// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>

#include "bidirectional_vpl/base/plan.h"
#include "bidirectional_vpl/light/light_vertices.h"
#include "bidirectional_vpl/maps/face_raster.h"
#include "bidirectional_vpl/maps/shadow_rays.h"

namespace lucarium::bidirectional {

/// Shadow maps of an iteration's virtual lights (vpl_visibility=map, maps/vpl_maps.cl).
class VplMaps {
 public:
  /// `scene` and `vertices` must outlive this; `owner` pays for the memory.
  VplMaps(Device& device, KernelScheduler& scheduler, const SceneBuffers& scene, const Plan& plan,
          const LightVertices& vertices, const std::string& owner);

  /// Makes the maps of an iteration's virtual lights, which are there. False when cancelled.
  bool fill(uint32_t seed, uint32_t sample);
  /// Whether maps answer all connections: nothing transmits light, so that all arrive before the lights' surfaces.
  bool answers_all() const { return alone_; }
  /// Records the test of connections. What is hidden becomes black or is marked. Sources: light paths.
  void record_test(ScheduleRecorder& recorder, const ShadowRays& rays) const;

  /// Follows a change of the scene. False where this must be built again.
  bool update() { return faces_.update() && !transmits(scene_) == alone_; }
  void warm_up();
  double faces() const { return 5. * vertices_.vertex_count(); }  ///< of the last iteration
  /// Texels per axis of the first face of a map of `map_res`² texels; the other four are half as high.
  static uint32_t side(uint32_t map_res);
  static size_t estimate_bytes(const Plan& plan, size_t triangles);

 private:
  static bool transmits(const SceneBuffers& scene) { return (scene.info().flags & LUCARIUM_SCENE_TRANSMITS) != 0; }

  KernelScheduler& scheduler_;
  const SceneBuffers& scene_;
  const LightVertices& vertices_;
  uint32_t side_, vertices_per_path_;
  bool alone_, of_one_;
  Program program_;
  TypedBuffer<LayeredView> views_;
  TypedBuffer<uint32_t> places_, triangles_;
  FaceRaster faces_;
  Schedule prepare_;
  Variable<uint32_t> seed_, sample_;
};

}  // namespace lucarium::bidirectional
