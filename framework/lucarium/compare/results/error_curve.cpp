// SPDX-License-Identifier: Apache-2.0
#include "lucarium/compare/results/error_curve.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "lucarium/base/numbers.h"

namespace lucarium {
TimeToError time_to_error(const std::vector<CurvePoint>& curve, double error) {
  const auto there = std::find_if(curve.begin(), curve.end(), [&](const CurvePoint& p) { return p.error <= error; });
  if (there == curve.end()) return {TimeToError::State::not_reached, infinity};
  if (there == curve.begin()) return {TimeToError::State::before_first, there->time};
  const CurvePoint &before = there[-1], &after = *there;
  // A line can neither start from a NaN nor end at 0.
  if (!(before.error > error) || !(after.error > 0)) return {TimeToError::State::reached, after.time};
  const double exponent = std::log(after.time / before.time) / std::log(after.error / before.error);
  return {TimeToError::State::reached, before.time * std::pow(error / before.error, exponent)};
}

double error_at_time(const std::vector<CurvePoint>& curve, double time) {
  const auto after = std::find_if(curve.begin(), curve.end(), [&](const CurvePoint& p) { return p.time >= time; });
  if (after == curve.end()) return not_a_number;
  if (after->time == time) return after->error;
  if (after == curve.begin()) return not_a_number;
  const CurvePoint& before = after[-1];
  if (before.error == 0 || after->error == 0) return after->error;
  const double exponent = std::log(after->error / before.error) / std::log(after->time / before.time);
  return before.error * std::pow(time / before.time, exponent);
}

PowerLaw fit_power_law(const std::vector<CurvePoint>& curve) {
  double sum_x = 0, sum_y = 0, count = 0;
  for (const CurvePoint& p : curve) {
    if (!(p.error > 0) || !(p.time > 0)) continue;
    sum_x += std::log(p.time);
    sum_y += std::log(p.error);
    ++count;
  }
  const double mean_x = sum_x / count, mean_y = sum_y / count;
  double xx = 0, xy = 0;
  for (const CurvePoint& p : curve) {
    if (!(p.error > 0) || !(p.time > 0)) continue;
    const double x = std::log(p.time) - mean_x;
    xx += x * x;
    xy += x * (std::log(p.error) - mean_y);
  }
  const auto points = static_cast<size_t>(count);
  if (!(xx > 0)) return {not_a_number, not_a_number, points};
  return {xy / xx, std::exp(mean_y - xy / xx * mean_x), points};
}

ConfidenceInterval seed_slope(const std::vector<std::vector<CurvePoint>>& curves, double confidence) {
  std::vector<double> slopes;
  for (const std::vector<CurvePoint>& curve : curves) slopes.push_back(fit_power_law(curve).slope);
  return seed_mean(slopes, confidence);
}

}  // namespace lucarium
