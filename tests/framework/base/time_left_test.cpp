// SPDX-License-Identifier: Apache-2.0
#include "lucarium/base/time_left.h"

#include <doctest/doctest.h>

#include <cmath>

using lucarium::TimeLeft;

TEST_CASE("time left goes by the growth of the fraction, not by what came before it") {
  TimeLeft left;
  CHECK_FALSE(left.estimate());
  left.update(0, 30);  // 30 s of something else
  CHECK_FALSE(left.estimate());
  left.update(0.1, 31);
  REQUIRE(left.estimate());
  CHECK(std::abs(*left.estimate() - 9) < 1e-9);
  left.update(1, 40);
  CHECK(std::abs(*left.estimate()) < 1e-9);
}

TEST_CASE("little growth in a short time is no estimate for people") {
  TimeLeft left;
  left.update(0, 0);
  left.update(0.01, 2);
  CHECK(left.estimate());
  CHECK_FALSE(left.settled_estimate());
  left.update(0.05, 9);
  CHECK(left.settled_estimate());
  TimeLeft slow;
  slow.update(0, 0);
  slow.update(0.01, 10);
  REQUIRE(slow.settled_estimate());
  CHECK(std::abs(*slow.settled_estimate() - 990) < 1e-9);
}

TEST_CASE("a fraction that falls is that of other work, an unknown one gives no time") {
  TimeLeft left;
  left.update(0.9, 10);  // resumed work: what is done took no time of this
  CHECK_FALSE(left.estimate());
  left.update(0.2, 11);
  CHECK_FALSE(left.estimate());
  left.update(0.4, 12);
  REQUIRE(left.estimate());
  CHECK(std::abs(*left.estimate() - 3) < 1e-9);
  left.update(-1, 13);
  CHECK_FALSE(left.estimate());
}
