// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>

#include "lucarium/services/direct_light/direct_light.h"
#include "lucarium/services/gbuffer/gbuffer.h"

namespace lucarium::micro {

/// What the framework's services say of the visible points: a G-buffer per frame, and the layers `emission` and
/// `direct`.
class EyeLight {
 public:
  /// `kinds` of lights as for DirectLight.
  EyeLight(Device& device, KernelScheduler& scheduler, const SceneBuffers& scene, const Intersector& intersector,
           const Frame& frame, uint32_t kinds, uint32_t direct_samples, const std::string& owner);

  void set_frame(const Frame& frame);
  /// Finds the points of a frame. False when cancelled.
  bool see(uint32_t frame) { return gbuffer_.render(frame); }
  const TypedBuffer<GBufferPoint>& points() const { return gbuffer_.points(); }
  /// Adds a frame's emission and direct light to the sums. False when cancelled: they are as before.
  bool add(uint32_t frame);
  void restart();
  void warm_up();
  /// Writes the layers `emission` and `direct`.
  void resolve(Film& film) const;
  static size_t estimate_bytes(uint32_t width, uint32_t height);

 private:
  KernelScheduler& scheduler_;
  uint32_t direct_samples_;
  uint32_t seed_;
  GBuffer gbuffer_;
  DirectLight direct_light_;
  TypedBuffer<float4> emission_, direct_, frame_direct_;  ///< xyz sum, w samples
  Program program_;
  Schedule add_;
};

}  // namespace lucarium::micro
