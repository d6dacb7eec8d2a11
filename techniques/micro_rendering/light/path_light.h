// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "lucarium/scene/scene.h"
#include "lucarium/services/intersector.h"
#include "lucarium/services/light_at_points/light_at_points.h"
#include "lucarium/services/light_paths/light_paths.h"
#include "lucarium/shared/gbuffer.h"
#include "micro_rendering/gather/gather_pass.h"

namespace lucarium::micro {

/// Light at the leaves of a forest, or at the points of a G-buffer if there are some, and what becomes of it.
LightAtPoints light_at_points(Device& device, const SceneBuffers& scene, const Intersector& intersector,
                              const PointForest& forest, const TypedBuffer<GBufferPoint>& points,
                              const MicroParameters& parameters, const std::string& owner);
LightAtPoints::Bind bind_light_sums(const MicroParameters& parameters, float weight,
                                    const TypedBuffer<float4>& irradiance,
                                    const TypedBuffer<MicroLeafLight>& leaf_lights);

/// Light of several bounces at the leaves by paths from the lights: virtual point lights, or a photon map ("Multiple
/// Bounces with Instant Radiosity" and "Photon Mapping" of Ritschel et al. 2009, section 4). Or at visible points, by
/// virtual point lights.
class PathLight {
 public:
  /// `bounces` as for LeafLight. `points`: of a G-buffer, which get the light instead of leaves; null: leaves do.
  PathLight(Device& device, KernelScheduler& scheduler, const Scene& scene, const SceneBuffers& buffers,
            const Intersector& intersector, const PointForest& forest, const MicroParameters& parameters, int bounces,
            const TypedBuffer<float4>& irradiance, const TypedBuffer<MicroLeafLight>& leaf_lights,
            const std::string& owner, const TypedBuffer<GBufferPoint>* points = nullptr);

  /// Traces the paths of a frame. False when cancelled.
  bool trace(uint32_t frame, uint32_t seed);
  double traced_rays() const { return paths_schedule_ ? paths_.rays() : 0; }  ///< by trace()
  /// In how many parts their light is added: virtual lights, or one of all photons.
  uint32_t parts() const {
    return !paths_schedule_ ? 0 : virtual_lights() ? static_cast<uint32_t>(lights_.count()) : 1;
  }
  /// Adds a part to the irradiance. False when cancelled: nothing has been added, or with adds_whole_parts() false
  /// perhaps to some leaves.
  bool add(uint32_t part);
  bool adds_whole_parts() const { return virtual_lights(); }  ///< by a last pass; photons come in slices of leaves
  void warm_up();
  static size_t estimate_bytes(const MicroParameters& parameters, size_t leaves, int bounces);

 private:
  bool virtual_lights() const { return parameters_.multibounce == MultiBounce::instant_radiosity; }
  float photon_cell() const;
  void record_virtual_light(const TypedBuffer<GBufferPoint>& points, const TypedBuffer<float4>& irradiance,
                            const TypedBuffer<MicroLeafLight>& leaf_lights);
  void record_density(const TypedBuffer<float4>& irradiance, const TypedBuffer<MicroLeafLight>& leaf_lights);

  Device& device_;
  KernelScheduler& scheduler_;
  const Scene& scene_;
  const SceneBuffers& buffers_;
  const Intersector& intersector_;
  const PointForest& forest_;
  MicroParameters parameters_;
  std::string owner_;
  LightPaths paths_;
  TypedBuffer<VirtualLight> lights_;  ///< or photons
  Schedule paths_schedule_, light_schedule_;
  Variable<uint32_t> frame_, seed_, light_, shadow_seed_;
  uint32_t frame_seed_ = 0;
  Variable<float> max_geometry_;  ///< bound of a virtual light's geometry term [1/m²]
  Variable<float> cell_;          ///< photon_cell() [m]
};

}  // namespace lucarium::micro
