// SPDX-License-Identifier: Apache-2.0
#include "lucarium/statistics/statistics.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "lucarium/base/error.h"
#include "lucarium/base/numbers.h"
#include "lucarium/statistics/student_t.h"

namespace lucarium {
namespace {

constexpr double greatest_reference_share = 0.1;

void check_pairs(const std::vector<double>& a, const std::vector<double>& b) {
  if (a.size() != b.size()) throw_error(ErrorClass::internal, "{} values cannot be paired with {}", a.size(), b.size());
}

}  // namespace

ConfidenceInterval seed_mean(const std::vector<double>& values, double confidence) {
  const size_t n = values.size();
  const bool undefined = n == 0 || std::any_of(values.begin(), values.end(), [](double v) { return std::isnan(v); });
  if (undefined) return {not_a_number, not_a_number, not_a_number, n};
  double sum = 0;
  for (const double v : values) sum += v;
  const double mean = sum / static_cast<double>(n);
  if (n == 1) return {mean, -infinity, infinity, n};
  if (std::isinf(mean)) return {mean, mean, mean, n};
  double squares = 0;
  for (const double v : values) squares += (v - mean) * (v - mean);
  const auto dof = static_cast<double>(n - 1);
  const double error = std::sqrt(squares / dof / static_cast<double>(n));
  const double half_width = error > 0 ? student_t_quantile(1 - confidence, dof) * error : 0;
  return {mean, mean - half_width, mean + half_width, n};
}

ConfidenceInterval seed_geometric_mean(const std::vector<double>& values, double confidence) {
  std::vector<double> logs;
  for (const double v : values) {
    if (v < 0) throw_error(ErrorClass::internal, "{} is below 0 and has no geometric mean", v);
    logs.push_back(std::log(v));
  }
  const ConfidenceInterval mean = seed_mean(logs, confidence);
  if (mean.mean == -infinity) {
    const bool all_zero = std::all_of(values.begin(), values.end(), [](double v) { return v == 0; });
    return {0, 0, all_zero ? 0 : infinity, mean.seeds};
  }
  return {std::exp(mean.mean), std::exp(mean.low), std::exp(mean.high), mean.seeds};
}

ConfidenceInterval paired_difference(const std::vector<double>& a, const std::vector<double>& b, double confidence) {
  check_pairs(a, b);
  std::vector<double> differences(a.size());
  for (size_t i = 0; i < a.size(); ++i) differences[i] = a[i] == b[i] ? 0 : a[i] - b[i];
  return seed_mean(differences, confidence);
}

ConfidenceInterval paired_ratio(const std::vector<double>& a, const std::vector<double>& b, double confidence) {
  check_pairs(a, b);
  std::vector<double> ratios(a.size());
  for (size_t i = 0; i < a.size(); ++i) ratios[i] = a[i] == b[i] ? 1 : a[i] / b[i];
  return seed_geometric_mean(ratios, confidence);
}

DebiasedError debiased_error(double error, double reference_error) {
  return {error - reference_error, reference_error <= greatest_reference_share * error};
}

}  // namespace lucarium
