// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <functional>
#include <string>

#include "lucarium/compute/schedule/scheduler.h"
#include "lucarium/scene/device/scene_buffers.h"
#include "lucarium/services/intersector.h"
#include "lucarium/shared/light_path.h"

namespace lucarium {

/// Direct light at a technique's own points (leaves of a tree, texels, pixels), that of virtual lights, one sample per
/// point and pass, or that of photons. A .cl file of the technique's says what point i is and where its light goes:
/// light_at_points.clh.
///
///   const Program program(device, library,
///                         {"my technique/points", {"my_technique/points.cl"}, ray_end_defines(bvh)});
///   LightAtPoints light(device, buffers, bvh, program, points, [&](PassBuilder& pass) { pass.arg("leaves", leaves); },
///                       "my technique", "use fewer points");
///   light.record_samples(recorder, sample, seed, [&](PassBuilder& pass) { pass.arg("sums", sums); });
///
/// Sums change in the last pass of a recording only, so that a cancelled run has changed nothing. Photons are the
/// exception, since their pass is sliced: some points may have received light, and the sums must be cleared.
class LightAtPoints {
 public:
  using Bind = std::function<void(PassBuilder&)>;
  static constexpr uint32_t kAllLights = 31;

  /// `bind_points` binds LIGHT_POINT_PARAMETERS. `scene` and `intersector` must outlive this; `owner` pays for the
  /// memory, `remedy` is said where it does not suffice.
  LightAtPoints(Device& device, const SceneBuffers& scene, const Intersector& intersector, const Program& program,
                uint32_t points, Bind bind_points, const std::string& owner, const std::string& remedy);

  /// One sample of the lights of some kinds (bits 1 << LUCARIUM_LIGHT_*) at every point. `bind_sums` binds
  /// LIGHT_SUM_PARAMETERS. However near a lamp is, a sample brings 2 pi times its radiance at most.
  void record_samples(ScheduleRecorder& recorder, const Variable<uint32_t>& sample_index,
                      const Variable<uint32_t>& seed, const Bind& bind_sums, uint32_t kinds = kAllLights) const;
  /// The light of virtual_lights[light] (VirtualLight) at every point, its geometry term bounded by `max_geometry`
  /// [1/m²].
  void record_virtual_light(ScheduleRecorder& recorder, const BufferRef& virtual_lights,
                            const Variable<uint32_t>& light, const Variable<uint32_t>& seed,
                            const Variable<float>& max_geometry, const Bind& bind_sums) const;

  /// The irradiance of `photons` (VirtualLight, arriving flux) about every point, estimated from the `nearest` of them
  /// (2 to LIGHT_MAX_PHOTONS, else Error{internal}), and those nearer than `cell` [m]; twice the radius that is
  /// expected to hold so many is a good one. Of a program that includes photon_density.clh.
  void record_photon_density(ScheduleRecorder& recorder, const TypedBuffer<VirtualLight>& photons,
                             const Variable<float>& cell, uint32_t nearest, const Bind& bind_sums) const;

  /// Device memory of a recording, unshared [bytes].
  static size_t estimate_bytes(size_t points);

 private:
  struct Shadows {
    BufferRef rays, ends, light, occluded;
  };
  Shadows shadows(ScheduleRecorder& recorder) const;
  PassBuilder point_pass(ScheduleRecorder& recorder, const std::string& name, const char* kernel) const;
  PassBuilder add_pass(ScheduleRecorder& recorder, const char* kernel, const Shadows& shadows,
                       const Variable<uint32_t>& number, const Variable<uint32_t>& seed, const Bind& bind_sums) const;

  Device& device_;
  const SceneBuffers& scene_;
  const Intersector& intersector_;
  Program program_;
  uint32_t points_;
  Bind bind_points_;
  std::string remedy_;
  TypedBuffer<uint32_t> count_;  ///< one element, as the intersector takes it
};

}  // namespace lucarium
