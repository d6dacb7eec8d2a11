// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "lucarium/services/direct_light.h"
#include "lucarium/services/gbuffer.h"
#include "lucarium/services/surface_atlas.h"

namespace lucarium::bundle {

/// What depends on the camera: the points it sees, their emission, direct light by samples, and the atlas' light
/// reflected at full resolution. One sample per pixel and iteration.
class CameraLight {
 public:
  CameraLight(Device& device, KernelScheduler& scheduler, const Program& program, const SceneBuffers& scene,
              const Intersector& intersector, const SurfaceAtlas& atlas, const TypedBuffer<float4>& shown,
              const Frame& frame);

  /// The next sample; false when cancelled. commit() then adds it, looking up `shown` as it is then.
  bool sample();
  void commit();
  void reset(uint32_t seed);
  void set_frame(const Frame& frame);
  void warm_up();
  uint32_t samples() const { return samples_; }
  void resolve(Film& film) const;
  static size_t estimate_bytes(uint32_t width, uint32_t height);

 private:
  void record(const Program& program, const SceneBuffers& scene, const SurfaceAtlas& atlas,
              const TypedBuffer<float4>& shown);
  KernelScheduler* scheduler_;
  Frame frame_;
  uint32_t pixels_, samples_ = 0;
  TypedBuffer<float4> direct_sample_, emission_, direct_, indirect_;
  GBuffer gbuffer_;
  DirectLight direct_light_;
  Schedule clear_, add_;
  Variable<float> atlas_weight_;
};

}  // namespace lucarium::bundle
