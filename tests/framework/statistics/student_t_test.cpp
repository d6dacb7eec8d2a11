// SPDX-License-Identifier: Apache-2.0
#include "lucarium/statistics/student_t.h"

#include <doctest/doctest.h>

#include <cmath>
#include <initializer_list>

#include "tolerance.h"

using namespace lucarium;

TEST_CASE("student_t: quantiles agree with printed tables") {
  CHECK(student_t_quantile(0.05, 15) == test::relative(2.13145, 1e-5));
  CHECK(student_t_quantile(0.01, 15) == test::relative(2.94671, 1e-5));
  CHECK(student_t_quantile(0.001, 30) == test::relative(3.64596, 1e-5));
  CHECK(student_t_quantile(0.05, 3) == test::relative(3.18245, 1e-5));
  CHECK(student_t_quantile(0.05, 1e6) == test::relative(1.959966, 1e-6));
}

TEST_CASE("student_t: tails of 1 and 2 degrees of freedom have closed forms") {
  for (const double t : {1e-6, 0.01, 0.5, 1.0, 3.0, 40.0, 1e5}) {
    CHECK(student_t_tail(t, 1) == test::relative(2 / M_PI * std::atan2(1, t), 1e-12));
    // 1 − t/√(2+t²), without the cancellation
    CHECK(student_t_tail(t, 2) == test::relative(2 / (std::sqrt(2 + t * t) * (std::sqrt(2 + t * t) + t)), 1e-12));
    CHECK(student_t_tail(-t, 2) == student_t_tail(t, 2));
  }
  CHECK(student_t_tail(0, 5) == 1);
}

TEST_CASE("student_t: the quantile inverts the tail far out and close in") {
  for (const double dof : {1.0, 2.0, 2.7, 9.0, 31.0, 1000.0}) {
    for (const double level : {0.9, 0.5, 0.05, 1e-3, 1.45e-8}) {
      CHECK(student_t_tail(student_t_quantile(level, dof), dof) / level == test::relative(1, 1e-9));
    }
  }
}

TEST_CASE("student_t: Sidak's level keeps the joint probability") {
  CHECK(std::pow(1 - sidak_level(0.01, 40), 40) == test::relative(0.99));
}
