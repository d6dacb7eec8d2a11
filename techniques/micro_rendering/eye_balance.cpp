// SPDX-License-Identifier: Apache-2.0
#include "micro_rendering/eye_balance.h"

#include <algorithm>
#include <cmath>

namespace lucarium::micro {
namespace {

LayerSpread::Shown shown(const EyeLight& eye, const PixelGather& gathers) {
  return {eye.sums()["emission"], eye.sums()["direct"], gathers.sums(), gathers.sky_sums()};
}

}  // namespace

EyeBalance::EyeBalance(Device& device, KernelScheduler& scheduler, const EyeLight& eye, const PixelGather& gathers,
                       const std::string& owner)
    : gathers_(gathers),
      eye_spread_(device, scheduler, shown(eye, gathers), eye.deviations(), owner),
      gather_spread_(device, scheduler, shown(eye, gathers), eye.deviations(), owner) {}

void EyeBalance::frame_added() {
  gather_spread_.measure();
  before_frame_ = eye_spread_.samples();
}

uint32_t EyeBalance::further_samples(uint32_t frames, const MicroParameters& parameters, const Scene& scene,
                                     const RenderSettings& settings) const {
  if (eye_spread_.samples() == 0) return 1;
  const FrameWork work = frame_work(parameters, scene, settings, (visits() - visits_before_) / frames);
  const double gather_variance = gather_spread_.samples() > 0
                                     ? gather_spread_.variance()
                                     : assumed_gather_variance(parameters) * eye_spread_.indirect_share();
  const double samples =
      frames * samples_for_each(eye_spread_.variance(), work.eye, gather_variance, work.indirect, kMaxEyeSamples);
  const double done = eye_spread_.samples() + 1;
  const double left = double{kMaxEyeSamples} - (eye_spread_.samples() - before_frame_);
  return static_cast<uint32_t>(std::max(0.0, std::min(std::round(samples) - done, left)));
}

void EyeBalance::clear() {
  eye_spread_.clear();
  gather_spread_.clear();
  before_frame_ = 0;
  visits_before_ = visits();
}

void EyeBalance::warm_up() {
  eye_spread_.warm_up();
  gather_spread_.warm_up();
}

double EyeBalance::visits() const {
  const auto found = gathers_.counters().find("node visits");
  return found == gathers_.counters().end() ? 0 : found->second;
}

}  // namespace lucarium::micro
