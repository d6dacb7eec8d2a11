// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "lucarium/services/intersector.h"
#include "lucarium/services/primitives/primitives.h"
#include "lucarium/shared/gbuffer.h"
#include "micro_rendering/gather/gather_pass.h"

namespace lucarium::micro {

/// Kernels of micro_light.cl.
Program light_program(Device& device, const MicroParameters& parameters);

/// Light of several bounces at the leaves by paths from the lights: virtual point lights, or a photon map. Or at
/// visible points, by virtual point lights.
class LightPaths {
 public:
  /// `bounces` as for LeafLight. `points`: of a G-buffer, which get the light instead of leaves; null: leaves do.
  LightPaths(Device& device, KernelScheduler& scheduler, const Scene& scene, const SceneBuffers& buffers,
             const Intersector& intersector, const PointForest& forest, const MicroParameters& parameters, int bounces,
             const TypedBuffer<float4>& irradiance, const DynamicShading& shading, const std::string& owner,
             const TypedBuffer<GBufferPoint>* points = nullptr);

  /// Traces the paths of a frame. False when cancelled.
  bool trace(uint32_t frame, uint32_t seed);
  double traced_rays() const {
    return static_cast<double>(paths_) * (first_vertex() + kept_vertices());
  }  ///< by trace()
  /// In how many parts their light is added: virtual lights, or one of all photons.
  uint32_t parts() const {
    return !paths_schedule_ ? 0 : virtual_lights() ? static_cast<uint32_t>(photons_.count()) : 1;
  }
  /// Adds a part to the irradiance. False when cancelled: it may have been added to some leaves.
  bool add(uint32_t part);
  void warm_up();
  static size_t estimate_bytes(const MicroParameters& parameters, size_t leaves, int bounces);

 private:
  bool virtual_lights() const { return parameters_.multibounce == MultiBounce::instant_radiosity; }
  uint32_t first_vertex() const;
  uint32_t kept_vertices() const;
  float photon_cell() const;
  static uint32_t paths_of(const MicroParameters& parameters);
  void record_paths();
  void record_virtual_light();
  void record_density();

  Device& device_;
  KernelScheduler& scheduler_;
  const Scene& scene_;
  const SceneBuffers& buffers_;
  const Intersector& intersector_;
  const PointForest& forest_;
  MicroParameters parameters_;
  int bounces_;
  TypedBuffer<float4> irradiance_;
  const DynamicShading& shading_;
  std::string owner_;
  uint32_t paths_ = 0;
  Program program_, light_program_;
  Primitives primitives_;
  TypedBuffer<MicroPhoton> photons_;
  TypedBuffer<GBufferPoint> points_;
  TypedBuffer<uint32_t> path_count_, receiver_count_;
  Schedule paths_schedule_, light_schedule_;
  Variable<uint32_t> frame_, seed_, light_, shadow_seed_;
  uint32_t frame_seed_ = 0;
  Variable<float> most_;  ///< of a virtual light's geometry term [1/m²]
  Variable<float> cell_;  ///< photon_cell() [m]
};

}  // namespace lucarium::micro
