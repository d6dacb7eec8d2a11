// SPDX-License-Identifier: Apache-2.0
#include "lucarium/view/sessions/motion.h"

#include <algorithm>
#include <array>

namespace lucarium {

namespace {

constexpr std::array<uint32_t, 6> divisors = {1, 2, 3, 4, 6, 8};
constexpr uint32_t first_divisor = 4;  // while nothing was measured
constexpr double newest_share = 0.5;   // of the last measurement in the mean
// Of the wanted time: what another size may take, so that it need not change again at once; and what one that is there
// must take at least, else a finer one is looked for.
constexpr double chosen_share = 0.85, min_share = 0.25;

}  // namespace

void MotionSize::measured(double seconds, double pixels) {
  const double now = seconds / std::max(pixels, 1.0);
  seconds_per_pixel_ = seconds_per_pixel_ < 0 ? now : newest_share * now + (1 - newest_share) * seconds_per_pixel_;
}

double MotionSize::expected_seconds(double pixels) const {
  return seconds_per_pixel_ < 0 ? -1 : seconds_per_pixel_ * pixels;
}

uint32_t MotionSize::divisor(double pixels, uint32_t present) const {
  if (seconds_per_pixel_ < 0) return present > 1 ? present : first_divisor;
  const auto seconds = [&](uint32_t divisor) { return expected_seconds(pixels / (divisor * divisor)); };
  if (present > 1 && seconds(present) <= wanted_seconds && seconds(present) >= min_share * wanted_seconds)
    return present;
  for (const uint32_t divisor : divisors)
    if (seconds(divisor) <= chosen_share * wanted_seconds) return divisor;
  return divisors.back();
}

}  // namespace lucarium
