// SPDX-License-Identifier: Apache-2.0
#include "bundle_exchange/direction_plan.h"

#include <fmt/format.h>

#include <algorithm>

namespace lucarium::bundle {
namespace {

constexpr double kPixels = 4e6;  // bundle pixels in 100 ms

}  // namespace

uint32_t batch_size(const Parameters& parameters, const SideMeans& means, uint64_t directions) {
  const uint64_t first = static_cast<uint64_t>(parameters.direct_first);
  const bool direct_only = means.direct_only(directions);
  uint64_t count = static_cast<uint64_t>(parameters.batch);
  if (!direct_only) count = std::min<uint64_t>(count, 1 + (directions - (means.direct_only(0) ? first : 0)) / 32);
  if (direct_only && directions < first) count = std::min(count, first - directions);
  count = std::min<uint64_t>(count, direction_limit(parameters) - directions);
  if (parameters.interleave == Interleave::pingpong) {
    const uint64_t block = static_cast<uint64_t>(parameters.block);
    count = std::min<uint64_t>(count, block - means.reflecting(directions) % block);
  }
  return static_cast<uint32_t>(count);
}

uint32_t directions_per_iteration(const Parameters& parameters, double largest_image, bool gathers) {
  // Fragments that are stored cost about three times as much as those that are exchanged at once.
  const double images = (parameters.transfer == Transfer::texel ? 3 : 1) + (gathers ? 3 : 0);
  return static_cast<uint32_t>(std::clamp(kPixels / images / largest_image, 1.0, 64 / images));
}

bool is_accurate(const Parameters& parameters, const SideMeans& means, uint64_t directions) {
  return forgets(parameters) && parameters.stop_error > 0 && means.carries_all(directions) &&
         means.relative_error() < parameters.stop_error;
}

double progress_of(Phase phase, const Parameters& parameters, uint64_t directions) {
  if (phase == Phase::done) return parameters.camera_samples > 0 ? 1 : -1;
  if (phase == Phase::light || directions == 0) return 0;
  return parameters.directions > 0 ? static_cast<double>(directions) / parameters.directions : -1;
}

std::string describe(Phase phase, const SideMeans& means) {
  if (phase == Phase::light) return "light";
  return means.reflected_light_done() ? "direct light" : "exchange";
}

bool has_samples(const Parameters& parameters, uint64_t camera_samples) {
  return parameters.camera_samples > 0 && camera_samples >= static_cast<uint64_t>(parameters.camera_samples);
}

std::string why_converged(const Parameters& parameters, const SideMeans& means, uint64_t directions, bool exchanges,
                          uint32_t camera_samples) {
  if (!exchanges) return fmt::format("all {} camera_samples are done", parameters.camera_samples);
  if (is_accurate(parameters, means, directions))
    return fmt::format("the relative error is {:.2g}, below stop_error", means.relative_error());
  const bool by_samples = camera_samples == static_cast<uint32_t>(parameters.camera_samples);  // which it waited for
  if (by_samples)
    return fmt::format("all {} directions and {} camera_samples are done", parameters.directions,
                       parameters.camera_samples);
  return fmt::format("all {} directions are done", parameters.directions);
}

}  // namespace lucarium::bundle
