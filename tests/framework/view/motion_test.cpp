// SPDX-License-Identifier: Apache-2.0
// Sizes of pictures while the camera moves, from what iterations took.
#include "lucarium/view/sessions/motion.h"

#include <doctest/doctest.h>

using namespace lucarium;

namespace {

constexpr double pixels = 640 * 360;

/// Moves a camera for a while, of iterations that take `seconds` at the whole size. Returns the divisor in the end.
uint32_t divisor_of(MotionSize& motion, double seconds, uint32_t present = 0) {
  for (int i = 0; i < 20; ++i) {
    present = motion.divisor(pixels, present);
    const double share = 1.0 / (present * present);
    motion.measured(seconds * share, pixels * share, present);
  }
  return present;
}

}  // namespace

TEST_CASE("while the camera moves a size is taken that keeps the wanted rate, and none that is much coarser") {
  for (const double seconds : {0.001, 0.05, 0.08, 0.1, 0.25, 0.32, 0.5, 1.0, 2.0, 4.0}) {
    CAPTURE(seconds);
    MotionSize motion;
    CHECK(motion.divisor(pixels, 0) == 4);  // nothing is known
    const uint32_t divisor = divisor_of(motion, seconds);
    CHECK(seconds / (divisor * divisor) <= MotionSize::wanted_seconds);
    if (divisor > 1) CHECK(seconds / (divisor * divisor) >= 0.2 * MotionSize::wanted_seconds);
    CHECK(divisor_of(motion, seconds, divisor) == divisor);
  }
}

TEST_CASE("what becomes slower gets coarser, what becomes much faster finer, and a little changes nothing") {
  MotionSize motion;
  const double seconds = 4 * 0.8 * MotionSize::wanted_seconds;
  CHECK(divisor_of(motion, seconds) == 2);
  CHECK(divisor_of(motion, 1.2 * seconds, 2) == 2);
  CHECK(divisor_of(motion, 1.3 * seconds, 2) == 3);
  CHECK(divisor_of(motion, seconds, 3) == 3);  // another size costs a session
  CHECK(divisor_of(motion, 0.4 * seconds, 3) == 2);
  CHECK(divisor_of(motion, 0.2 * seconds, 2) == 1);
  CHECK(divisor_of(motion, 1e6, 2) == 8);  // there is none coarser
  motion.forget();
  CHECK(motion.divisor(pixels, 0) == 4);
}

TEST_CASE("what does not keep the rate at the coarsest size is too slow once that was measured twice, until in doubt") {
  const double wanted = MotionSize::wanted_seconds, coarsest = pixels / 64;
  MotionSize motion;
  for (int i = 0; i < 5; ++i) motion.measured(100 * wanted, pixels / 36, 6);
  CHECK_FALSE(motion.is_too_slow());  // there is a coarser one
  motion.measured(9 * wanted, coarsest, 8);
  CHECK_FALSE(motion.is_too_slow());  // once is no rule
  motion.measured(9 * wanted, coarsest, 8);
  CHECK(motion.is_too_slow());
  for (int i = 0; i < 20; ++i) motion.measured(wanted, pixels, 1);
  CHECK(motion.is_too_slow());  // the whole size says nothing of what each size costs
  motion.doubt();
  CHECK_FALSE(motion.is_too_slow());
  motion.measured(2 * wanted, coarsest, 8);
  CHECK(motion.is_too_slow());  // one is enough then
  motion.doubt();
  for (int i = 0; i < 5; ++i) motion.measured(1.1 * wanted, coarsest, 8);
  CHECK_FALSE(motion.is_too_slow());  // nearly
  for (int i = 0; i < 5; ++i) motion.measured(1.4 * wanted, coarsest, 8);
  CHECK(motion.is_too_slow());
  motion.forget();
  CHECK_FALSE(motion.is_too_slow());
}

TEST_CASE("one slow measurement is no rule, however slow: caches were cold, parameters are others") {
  const double wanted = MotionSize::wanted_seconds, coarsest = pixels / 64;
  MotionSize motion;
  motion.measured(12 * wanted, coarsest, 8);
  motion.measured(0.6 * wanted, coarsest, 8);
  CHECK_FALSE(motion.is_too_slow());
  motion.measured(12 * wanted, coarsest, 8);
  CHECK_FALSE(motion.is_too_slow());
  motion.measured(12 * wanted, coarsest, 8);
  CHECK(motion.is_too_slow());
  motion.forget_slow();
  motion.measured(12 * wanted, coarsest, 8);
  CHECK_FALSE(motion.is_too_slow());
  motion.doubt();  // of what is not too slow there is no doubt
  CHECK_FALSE(motion.is_too_slow());
  motion.measured(12 * wanted, coarsest, 8);
  CHECK(motion.is_too_slow());
}

TEST_CASE("slow is what misses the rate clearly at a size that has none coarser") {
  CHECK(MotionSize::is_slow(1.3 * MotionSize::wanted_seconds, 8));
  CHECK_FALSE(MotionSize::is_slow(1.2 * MotionSize::wanted_seconds, 8));
  CHECK_FALSE(MotionSize::is_slow(100 * MotionSize::wanted_seconds, 6));
}
