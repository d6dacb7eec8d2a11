// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>

#include "lucarium/services/eye_light/eye_light.h"
#include "lucarium/services/layer_spread/layer_spread.h"
#include "micro_rendering/cost.h"
#include "micro_rendering/pixels/pixel_gather.h"

namespace lucarium::micro {

/// How many samples of emission and direct light belong to a frame of gathers, so that the error of the image falls
/// most for all work: by the variances of both, measured while they come in, and by counted work.
class EyeBalance {
 public:
  /// Both outlive it.
  EyeBalance(Device& device, KernelScheduler& scheduler, const EyeLight& eye, const PixelGather& gathers,
             const std::string& owner);

  /// After a sample of the eye's light was added.
  void eye_added() { eye_spread_.measure(); }
  /// After a frame of gathers was added.
  void frame_added();
  /// Samples of the eye's light that are to follow, with `frames` of gathers done; kMaxEyeSamples at most since the
  /// last one was. One at least where nothing is known yet of how they scatter.
  uint32_t further_samples(uint32_t frames, const MicroParameters& parameters, const Scene& scene,
                           const RenderSettings& settings) const;
  void clear();
  void warm_up();

 private:
  double visits() const;

  const PixelGather& gathers_;
  LayerSpread eye_spread_, gather_spread_;
  uint32_t before_frame_ = 0;  ///< samples of the eye's light, when the last frame of gathers was done
  double visits_before_ = 0;   ///< counted before clear()
};

}  // namespace lucarium::micro
