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
  /// Whether iterations are too slow for the rate even at the coarsest size, clearly so, and not once.
  bool is_too_slow() const;
  /// Of what was too slow the next measurement decides that again: the machine may have been busy.
  void doubt();
  void forget() { *this = {}; }

 private:
  double seconds_per_pixel_ = -1;
  double coarsest_seconds_ = 0;
  int coarsest_count_ = 0;
  bool in_doubt_ = true;
};

}  // namespace lucarium
