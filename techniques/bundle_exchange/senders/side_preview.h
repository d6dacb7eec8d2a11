// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "bundle_exchange/senders/side_means.h"

namespace lucarium::bundle {

/// What texel sides display, smoothed within charts and across smooth seams, where neighbours differ no more than their
/// standard errors say (smooth_preview.cl): for images that have not converged. Where errors vanish, so does the
/// smoothing.
class SidePreview {
 public:
  SidePreview(Device& device, KernelScheduler& scheduler, const Program& program, const SurfaceAtlas& atlas,
              const SideMeans& means);

  /// Smooths what `means` display now; false when cancelled.
  bool smooth();
  void warm_up();
  const TypedBuffer<float4>& shown() const { return indirect_[0]; }  ///< as SideMeans::shown()
  const TypedBuffer<float4>& shown_direct() const { return direct_[0]; }
  static size_t estimate_bytes(size_t sides, const Channels& channels);

 private:
  KernelScheduler* scheduler_;
  const SideMeans* means_;
  TypedBuffer<float4> indirect_[2], direct_[2];
  TypedBuffer<float> variance_[2];
  Schedule schedule_;
  Variable<float> correction_;
};

}  // namespace lucarium::bundle
