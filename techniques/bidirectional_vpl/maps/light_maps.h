// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>
#include <vector>

#include "bidirectional_vpl/maps/face_raster.h"
#include "bidirectional_vpl/maps/shadow_rays.h"
#include "lucarium/services/intersector.h"

namespace lucarium::bidirectional {

/// Cubes of what point and spot lights see, turned at random in every iteration: reflective shadow maps, or shadow
/// maps of direct light (maps/light_maps.cl).
class LightMaps {
 public:
  /// `name`: of passes and memory; `side`: texels of a face; `remedy`: said where memory does not suffice. `scene` must
  /// outlive this; `owner` pays for the memory.
  LightMaps(Device& device, KernelScheduler& scheduler, const SceneBuffers& scene, const std::string& name,
            uint32_t side, const std::string& remedy, const std::string& owner);

  /// Makes the maps of an iteration. False when cancelled.
  bool fill(uint32_t seed, uint32_t sample);
  /// Records what the first rays of light paths meet: look-ups for lights with a map, rays of `intersector` for
  /// others, which it returns.
  BufferRef record_light_paths(ScheduleRecorder& recorder, const Intersector& intersector, const BufferRef& states,
                               const RayBuffers& rays, const BufferRef& hits) const;
  /// Records the test of light samples, whose light is multiplied by the share that arrives. Sources: their lights.
  void record_test(ScheduleRecorder& recorder, const ShadowRays& rays) const;

  /// Follows a change of the scene. False where this must be built again.
  bool update();
  void warm_up();
  double faces() const { return 6. * static_cast<double>(lights_.size()); }  ///< of an iteration
  static size_t estimate_bytes(size_t triangles, size_t lights, uint32_t side);

 private:
  KernelScheduler& scheduler_;
  const SceneBuffers& scene_;
  std::string name_, owner_;
  uint32_t side_;
  std::vector<uint32_t> lights_;  ///< point and spot lights, into scene_lights
  std::vector<uint32_t> places_;  ///< of each light: its place in lights_, LUCARIUM_NONE of others
  Program program_;
  TypedBuffer<uint32_t> light_list_, place_list_;
  TypedBuffer<LayeredView> views_;
  TypedBuffer<uint32_t> triangles_;
  FaceRaster faces_;
  Schedule prepare_;
  Variable<uint32_t> seed_, sample_;
};

}  // namespace lucarium::bidirectional
