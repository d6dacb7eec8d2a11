// SPDX-License-Identifier: Apache-2.0
// Error over time: both axes are logarithmic, and between two snapshots the curve is a straight line there.
#pragma once
#include <vector>

#include "lucarium/statistics/statistics.h"

namespace lucarium {

/// One snapshot of a run.
struct CurvePoint {
  double time = 0;   ///< [s]
  double error = 0;  ///< any metric of which less is better
};

/// When a curve came down to an error.
struct TimeToError {
  enum class State {
    reached,
    before_first,  ///< the first snapshot is below it already: `time` is that snapshot's, an upper bound
    not_reached    ///< `time` is infinite
  };
  State state = State::not_reached;
  double time = 0;  ///< [s]
};

/// First time at which the curve is at `error` or below. Points ascend in time; all times are positive.
/// Between e_i > ε ≥ e_{i+1}: t_i (ε/e_i)^{ln(t_{i+1}/t_i)/ln(e_{i+1}/e_i)}.
/// With the upper bounds of intervals as errors, it is the smallest time at which the interval is below ε.
TimeToError time_to_error(const std::vector<CurvePoint>& curve, double error);

/// Error at a time between the snapshots; NaN outside. Where one of both neighbours is 0, the later one counts.
double error_at_time(const std::vector<CurvePoint>& curve, double time);

/// Straight line through log e over log t: error = scale · time^slope. −1 for the MSE of independent samples.
struct PowerLaw {
  double slope = 0, scale = 0;
  size_t points = 0;  ///< that took part: those with positive error
};

/// Least squares; NaN for fewer than two times with positive errors.
PowerLaw fit_power_law(const std::vector<CurvePoint>& curve);

/// Mean of the slopes of independent runs with its interval. The points of one run are not independent (each contains
/// the samples of the one before), so that residuals about one line say nothing about the slope's error; seeds do.
ConfidenceInterval seed_slope(const std::vector<std::vector<CurvePoint>>& curves, double confidence = 0.95);

}  // namespace lucarium
