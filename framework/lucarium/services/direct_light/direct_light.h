// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <memory>

#include "lucarium/compute/schedule/scheduler.h"
#include "lucarium/scene/device/scene_buffers.h"
#include "lucarium/services/gbuffer/gbuffer.h"
#include "lucarium/services/intersector.h"
#include "lucarium/shared/surface_point.h"

namespace lucarium {

/// The complete `direct` layer (one counted scattering): light sampling and BSDF sampling joined by MIS for every light
/// type, as the path tracer does it, at pixels (reflected radiance towards the eye) or at surface points (irradiance).
/// Volumes absorb along its rays as along the path tracer's, at pixels; at surface points those of which the point
/// itself is a wall, since a point does not know what it lies in. Changes of the scene need no new one while the
/// generations of SceneBuffers and of the intersector stay.
class DirectLight {
 public:
  static constexpr uint32_t kAllLights = 31;
  static constexpr uint32_t kPunctualLights = 7;  ///< point, spot and directional ones

  /// `kinds`: which lights count, bits 1 << LUCARIUM_LIGHT_*.
  DirectLight(Device& device, KernelScheduler& scheduler, const SceneBuffers& scene, const Intersector& intersector,
              const std::string& owner, uint32_t kinds = kAllLights);
  ~DirectLight();

  /// Adds one sample per pixel to `radiance` (float4 per pixel, xyz sum, w sample count) for the points of the
  /// G-buffer. Returns false when cancelled; nothing has then been added.
  bool accumulate_radiance(const TypedBuffer<GBufferPoint>& points, const TypedBuffer<float4>& radiance,
                           uint32_t sample_index, uint32_t seed);
  /// Adds one sample per point to `irradiance` (float4, xyz sum [lx], w count), as LightAtPoints does. Returns false
  /// when cancelled; nothing has then been added.
  bool accumulate_irradiance(const TypedBuffer<SurfacePoint>& points, const TypedBuffer<float4>& irradiance,
                             uint32_t sample_index, uint32_t seed);
  /// Compiles what the same call will launch.
  void warm_up(const TypedBuffer<GBufferPoint>& points, const TypedBuffer<float4>& radiance);
  void warm_up(const TypedBuffer<SurfacePoint>& points, const TypedBuffer<float4>& irradiance);
  /// Device memory of one pair of buffers, without them [bytes]. `ray_ends`: over an intersector that wants them.
  static size_t estimate_bytes(size_t points, bool ray_ends = false);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace lucarium
