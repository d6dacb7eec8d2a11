// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>

#include "lucarium/services/direct_light/direct_light.h"
#include "lucarium/services/gbuffer/gbuffer.h"
#include "lucarium/services/layer_sums/layer_sums.h"

namespace lucarium {

/// Light that the camera sees without indirect light: the points of a G-buffer, and the layers `emission` and `direct`
/// of them, summed over samples. A sample takes three steps, so that a technique can work with the points between them
/// and add its own light at the same time: see() → sample() → commit().
class EyeLight {
 public:
  /// `light_kinds` as for DirectLight, 0: no direct light. `light_samples` of it to a sample of the pixel.
  /// `first_surface`: as of GBuffer.
  EyeLight(Device& device, KernelScheduler& scheduler, const SceneBuffers& scene, const Intersector& intersector,
           const Frame& frame, const std::string& owner, uint32_t light_kinds = DirectLight::kAllLights,
           uint32_t light_samples = 1, bool first_surface = false);

  /// Finds the points of sample `index`. False when cancelled.
  bool see(uint32_t index) { return gbuffer_.render(index); }
  const TypedBuffer<GBufferPoint>& points() const { return gbuffer_.points(); }
  /// Direct light of the points, not yet added. False when cancelled; it may be done again.
  bool sample(uint32_t index);
  /// Adds the sample to both layers, to its end.
  void commit();

  const LayerSums& sums() const { return sums_; }
  /// Of the sample that commit() has added, per pixel, for LayerSpread. Another part may use the buffer between two.
  const TypedBuffer<float>& deviations() const { return deviations_; }

  /// Back to no samples, with another camera or seed. The image size stays.
  void set_frame(const Frame& frame);
  void clear();
  void warm_up();
  /// Adds to the layers `emission` and `direct`.
  void write(Film& film) const { sums_.write(film); }
  static size_t estimate_bytes(uint32_t width, uint32_t height);

 private:
  KernelScheduler* scheduler_;
  uint32_t light_kinds_, light_samples_, seed_;
  GBuffer gbuffer_;
  DirectLight direct_light_;
  LayerSums sums_;
  TypedBuffer<float4> sample_;  ///< direct light of the sample: xyz sum, w light samples
  TypedBuffer<float> deviations_;
  Schedule clear_, commit_;
};

}  // namespace lucarium
