// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <functional>

#include "lucarium/services/gbuffer/gbuffer.h"
#include "voxel_abuffer/modes/mode.h"
#include "voxel_abuffer/modes/pass_sums.h"

namespace lucarium::abuffer {

/// Ambient occlusion: 1 − (rays that meet something within the radius) / (all rays), directions distributed by the
/// cosine; mirrors and clear glass are looked through. Layer `ambient_occlusion`, 1 where nothing is seen. A pass sees
/// the scene once, and casts λ rays per pixel.
class OcclusionMode : public Mode {
 public:
  /// `radius`: beyond it nothing occludes [m], may be INFINITY; asked for again by every restart().
  OcclusionMode(const ModeContext& context, uint32_t samples, std::function<float()> radius);
  bool pass() override;
  void restart(const Frame& frame, uint64_t seed) override;
  void write(Film& film) override { sums_.sums().write(film); }
  void warm_up() override;
  std::map<std::string, double> counters() const override;
  static size_t estimate_bytes(size_t width, size_t height, bool ray_ends);

 private:
  void record(const ModeContext& context);
  KernelScheduler* scheduler_;
  uint32_t samples_;
  std::function<float()> radius_;
  GBuffer gbuffer_;
  PassSums sums_;
  TypedBuffer<uint32_t> count_;  ///< one element: rays of a sample, as the intersector takes it
  Schedule sample_;
  Variable<uint32_t> sample_index_, seed_;
  Variable<float> reach_;
  uint32_t passes_ = 0, frame_seed_ = 0;
};

}  // namespace lucarium::abuffer
