// SPDX-License-Identifier: Apache-2.0
#include "student_t.h"

#include <doctest/doctest.h>

using namespace lucarium::test;

TEST_CASE("student_t: quantiles agree with printed tables") {
  CHECK(student_t_quantile(0.05, 15) == doctest::Approx(2.13145).epsilon(1e-5));
  CHECK(student_t_quantile(0.01, 15) == doctest::Approx(2.94671).epsilon(1e-5));
  CHECK(student_t_quantile(0.001, 30) == doctest::Approx(3.64596).epsilon(1e-5));
  CHECK(student_t_quantile(0.05, 3) == doctest::Approx(3.18245).epsilon(1e-5));
}

TEST_CASE("student_t: Sidak's level keeps the joint probability") {
  CHECK(std::pow(1 - sidak_level(0.01, 40), 40) == doctest::Approx(0.99));
}
