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
constexpr double slow_share = 1.25;  // of the wanted time, at the coarsest size: too slow
constexpr int decisive = 2;          // measurements of that in a row; one may have met cold caches

}  // namespace

void MotionSize::measured(double seconds, double pixels, uint32_t divisor) {
  const double now = seconds / std::max(pixels, 1.0);
  seconds_per_pixel_ = seconds_per_pixel_ < 0 ? now : newest_share * now + (1 - newest_share) * seconds_per_pixel_;
  if (divisor >= divisors.back()) slow_count_ = is_slow(seconds, divisor) ? slow_count_ + 1 : 0;
}

bool MotionSize::is_slow(double seconds, uint32_t divisor) {
  return divisor >= divisors.back() && seconds > slow_share * wanted_seconds;
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

bool MotionSize::is_too_slow() const { return slow_count_ >= decisive; }

void MotionSize::doubt() { slow_count_ = std::min(slow_count_, decisive - 1); }

}  // namespace lucarium
