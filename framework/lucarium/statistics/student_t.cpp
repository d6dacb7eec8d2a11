// SPDX-License-Identifier: Apache-2.0
#include "lucarium/statistics/student_t.h"

#include <algorithm>
#include <cmath>

namespace lucarium {
namespace {

/// Regularized incomplete beta function I_x(a, b) by its continued fraction, DLMF 8.17.22, which converges fast for
/// x < (a+1)/(a+b+2). `y` is 1 − x, given apart because it may be tiny.
double incomplete_beta_fraction(double a, double b, double x, double y) {
  const int terms = 60 + static_cast<int>(6 * std::sqrt(std::max(a, b)));
  double fraction = 1;
  for (int m = terms; m >= 0; --m) {
    fraction = 1 - (a + m) * (a + b + m) * x / ((a + 2 * m) * (a + 2 * m + 1)) / fraction;
    if (m > 0) fraction = 1 + m * (b - m) * x / ((a + 2 * m - 1) * (a + 2 * m)) / fraction;
  }
  const double log_beta = std::lgamma(a) + std::lgamma(b) - std::lgamma(a + b);
  return std::exp(a * std::log(x) + b * std::log(y) - log_beta) / (a * fraction);
}

}  // namespace

double student_t_tail(double t, double dof) {
  if (t == 0) return 1;
  const double x = dof / (dof + t * t), y = t * t / (dof + t * t), a = dof / 2, b = 0.5;
  if (x < (a + 1) / (a + b + 2)) return incomplete_beta_fraction(a, b, x, y);
  return 1 - incomplete_beta_fraction(b, a, y, x);
}

double student_t_quantile(double level, double dof) {
  double low = 1e-12, high = 1e18;
  for (int i = 0; i < 70; ++i) {
    const double middle = std::sqrt(low * high);
    (student_t_tail(middle, dof) > level ? low : high) = middle;
  }
  return low;
}

double sidak_level(double level, size_t tests) { return -std::expm1(std::log1p(-level) / static_cast<double>(tests)); }

}  // namespace lucarium
