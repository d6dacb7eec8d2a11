// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>
#include <vector>

#include "bidirectional_vpl/base/plan.h"
#include "lucarium/services/gbuffer/gbuffer.h"

namespace lucarium::bidirectional {

/// The picture of few samples, smoothed over the pixels of a tile of interleaved sampling (filter_pixels.cl).
class PixelFilter {
 public:
  /// `sums`: of the light that is filtered.
  PixelFilter(Device& device, KernelScheduler& scheduler, const SceneBuffers& scene, const Intersector& intersector,
              const Frame& frame, const Plan& plan, const TypedBuffer<float4>& sums, const std::string& owner);

  /// Finds the surfaces, once per camera and scene. False when cancelled.
  bool find_surfaces();
  /// Filters the sums of that many iterations; to its end. Nothing where each pixel has as many as a tile has pixels.
  void apply(uint64_t iterations);
  /// Whether the picture shows filtered().
  bool shows() const { return shows_; }
  std::vector<float4> filtered() const { return filtered_.download(); }
  void set_frame(const Frame& frame);
  void warm_up();
  static size_t estimate_bytes(const Plan& plan, bool ray_ends);

 private:
  KernelScheduler& scheduler_;
  Frame frame_;
  uint32_t side_;
  GBuffer surfaces_;
  Program program_;
  TypedBuffer<float4> filtered_;
  Schedule filter_;
  Variable<Frame> frame_variable_;
  bool found_ = false, shows_ = false;
};

}  // namespace lucarium::bidirectional
