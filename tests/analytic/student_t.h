// SPDX-License-Identifier: Apache-2.0
// Student's t distribution, as far as the statistical tests need it.
#pragma once
#include <cmath>
#include <cstddef>

namespace lucarium::test {

/// Density of Student's t with `dof` degrees of freedom.
inline double student_t_density(double t, double dof) {
  const double scale = std::lgamma(0.5 * (dof + 1)) - std::lgamma(0.5 * dof) - 0.5 * std::log(dof * M_PI);
  return std::exp(scale - 0.5 * (dof + 1) * std::log1p(t * t / dof));
}

/// P(|T| > t): Simpson's rule in s = 1/x over the tail, which is smooth and ends at s = 0.
inline double student_t_tail(double t, double dof) {
  const int steps = 2000;
  const double width = 1 / t / steps;
  const auto integrand = [&](double s) { return s > 0 ? student_t_density(1 / s, dof) / (s * s) : 0.0; };
  double sum = 0;
  for (int i = 0; i < steps; i += 2)
    sum += integrand(i * width) + 4 * integrand((i + 1) * width) + integrand((i + 2) * width);
  return 2 * sum * width / 3;
}

/// The t that |T| exceeds with probability `level`.
inline double student_t_quantile(double level, double dof) {
  double low = 0.1, high = 1e6;
  for (int i = 0; i < 200; ++i) {
    const double middle = std::sqrt(low * high);
    (student_t_tail(middle, dof) > level ? low : high) = middle;
  }
  return low;
}

/// Level of one of `tests` independent tests so that all together fail by chance with probability `level` (Sidak).
inline double sidak_level(double level, size_t tests) { return -std::expm1(std::log1p(-level) / static_cast<double>(tests)); }

}  // namespace lucarium::test
