// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <vector>

namespace lucarium::test {

/// Regularised upper incomplete gamma function Q(a, x), a > 0: its series for small x, else Lentz's continued fraction
/// (Press et al., Numerical Recipes, section 6.2). Relative error about 1e-12.
inline double upper_gamma(double a, double x) {
  if (x <= 0) return 1;
  const double scale = std::exp(a * std::log(x) - x - std::lgamma(a));
  if (x < a + 1) {
    double term = 1 / a, sum = term;
    for (int n = 1; n < 100000 && std::abs(term) > 1e-15 * std::abs(sum); ++n) sum += term *= x / (a + n);
    return 1 - scale * sum;
  }
  const double tiny = 1e-300;
  double b = x + 1 - a, c = 1 / tiny, d = 1 / b, h = d;
  for (int n = 1; n < 100000; ++n) {
    const double an = -n * (n - a);
    b += 2;
    d = an * d + b;
    if (std::abs(d) < tiny) d = tiny;
    c = b + an / c;
    if (std::abs(c) < tiny) c = tiny;
    d = 1 / d;
    const double factor = d * c;
    h *= factor;
    if (std::abs(factor - 1) < 1e-15) break;
  }
  return scale * h;
}

/// Probability that a chi-squared variable of `degrees` degrees of freedom is at least `statistic`.
inline double chi2_p_value(double statistic, double degrees) { return upper_gamma(0.5 * degrees, 0.5 * statistic); }

/// Level of one of `tests` independent tests that keeps the whole family at `alpha` (Sidak).
inline double sidak(double alpha, int tests) { return 1 - std::pow(1 - alpha, 1.0 / tests); }

struct Chi2Result {
  double statistic = 0, p = 0;
  int cells = 0;       ///< after pooling
  uint64_t stray = 0;  ///< samples in cells that expect none
};

/// Pearson's test. Cells are pooled in ascending order of expectation until each holds at least 5.
inline Chi2Result chi2_test(const std::vector<uint64_t>& observed, const std::vector<double>& expected) {
  std::vector<size_t> order(expected.size());
  std::iota(order.begin(), order.end(), size_t{0});
  std::sort(order.begin(), order.end(), [&](size_t a, size_t b) { return expected[a] < expected[b]; });
  Chi2Result result;
  double pooled_expected = 0, pooled_observed = 0, last_expected = 0, last_observed = 0;
  const auto close = [&](double e, double o, int count) {
    result.statistic += (o - e) * (o - e) / e;
    result.cells += count;
  };
  for (const size_t i : order) {
    if (expected[i] == 0) {
      result.stray += observed[i];
      continue;
    }
    pooled_expected += expected[i];
    pooled_observed += static_cast<double>(observed[i]);
    if (pooled_expected < 5) continue;
    if (last_expected > 0) close(last_expected, last_observed, 1);
    last_expected = pooled_expected, last_observed = pooled_observed;
    pooled_expected = pooled_observed = 0;
  }
  // What is left over joins the last cell.
  last_expected += pooled_expected, last_observed += pooled_observed;
  if (last_expected > 0) close(last_expected, last_observed, 1);
  result.p = result.cells > 1 ? chi2_p_value(result.statistic, result.cells - 1) : 1;
  return result;
}

}  // namespace lucarium::test
