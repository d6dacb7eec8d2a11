// SPDX-License-Identifier: Apache-2.0
#include "lucarium/base/time_left.h"

#include <algorithm>

namespace lucarium {
namespace {

constexpr double min_growth = 0.05, min_seconds = 10;

}  // namespace

void TimeLeft::update(double fraction, double seconds) {
  const double now = std::clamp(fraction, 0.0, 1.0);
  if (!begun_ || now <= 0 || now < fraction_) first_fraction_ = now, first_seconds_ = seconds;
  begun_ = true;
  fraction_ = now;
  seconds_ = seconds;
}

std::optional<double> TimeLeft::estimate() const {
  const double growth = fraction_ - first_fraction_;
  if (growth <= 0) return std::nullopt;
  return (seconds_ - first_seconds_) * (1 - fraction_) / growth;
}

std::optional<double> TimeLeft::settled_estimate() const {
  const bool settled = fraction_ - first_fraction_ >= min_growth || seconds_ - first_seconds_ >= min_seconds;
  return settled ? estimate() : std::nullopt;
}

}  // namespace lucarium
