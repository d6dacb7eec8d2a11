// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <optional>

namespace lucarium {

/// Estimates the remaining time of work from how fast its fraction has grown since the first update, or since it began
/// to grow. A fraction that falls means that other work has begun, and the estimate starts over.
class TimeLeft {
 public:
  /// `fraction` of the work is done after `seconds`; negative: unknown.
  void update(double fraction, double seconds);
  /// Seconds left; nothing before the fraction has grown.
  std::optional<double> estimate() const;
  /// The same, for people: nothing before it is based on a twentieth of the work, or on ten seconds of it.
  std::optional<double> settled_estimate() const;

 private:
  bool begun_ = false;
  double first_fraction_ = 0, first_seconds_ = 0;
  double fraction_ = 0, seconds_ = 0;
};

}  // namespace lucarium
