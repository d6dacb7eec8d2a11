// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>

namespace lucarium {

/// The size of pictures while the camera moves: the finest of 1/1, 1/2, 1/3, 1/4, 1/6 and 1/8 whose iterations keep the
/// wanted rate, from the time that earlier ones took.
class MotionSize {
 public:
  static constexpr double wanted_seconds = 1.0 / 12;

  /// An iteration of so many pixels took that long, with its picture where one was sent.
  void measured(double seconds, double pixels, uint32_t divisor);
  /// How long one is expected to take; negative: nothing was measured.
  double expected_seconds(double pixels) const;
  /// The divisor for pictures of that many pixels at their whole size. Stays at `present` (0: none) while that is about
  /// right, since another size costs a session.
  uint32_t divisor(double pixels, uint32_t present) const;
  /// Whether that is too slow for the rate at that size, clearly so, and there is none coarser.
  static bool is_slow(double seconds, uint32_t divisor);
  /// Whether the last measurements of the coarsest size were all slow, and more than one.
  bool is_too_slow() const;
  /// Of what was too slow the next measurement decides that again: the machine may have been busy.
  void doubt();
  /// What was slow may not be: it has other parameters. What is known of sizes is a beginning.
  void forget_slow() { slow_count_ = 0; }
  void forget() { *this = {}; }

 private:
  double seconds_per_pixel_ = -1;
  int slow_count_ = 0;  ///< of measurements in a row
};

}  // namespace lucarium
