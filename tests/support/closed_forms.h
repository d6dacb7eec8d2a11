// SPDX-License-Identifier: Apache-2.0
// Estimates with their standard errors, against closed forms.
#pragma once
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "lucarium/statistics/student_t.h"
#include "test_support.h"

namespace lucarium::test {

/// A mean, and its standard error from the spread of independent replicates.
struct Estimate {
  double mean = 0, error = 0;
  uint32_t replicates = 0;
};

inline Estimate estimate_of(const std::vector<double>& means) {
  Estimate result;
  result.replicates = static_cast<uint32_t>(means.size());
  for (const double m : means) result.mean += m / static_cast<double>(means.size());
  double squares = 0;
  for (const double m : means) squares += (m - result.mean) * (m - result.mean);
  const double count = static_cast<double>(means.size());
  result.error = std::sqrt(squares / (count - 1) / count);
  return result;
}

/// Of `count` values, the i-th of which belongs to replicate i mod 16.
template <class Value>
Estimate interleaved_estimate(size_t count, Value value_of) {
  std::vector<double> means(16);
  for (size_t i = 0; i < count; ++i)
    means[i % 16] += static_cast<double>(value_of(i)) * 16 / static_cast<double>(count);
  return estimate_of(means);
}

/// Rows of one table of closed forms, with the criterion
///   |mean - exact| <= t SE + 2e-4 exact,
/// t the quantile of Student's distribution for the replicates, Sidak-corrected over the rows of the table, so that a
/// whole table fails by chance once in a hundred seeds (and seeds are fixed).
class ClosedForms {
 public:
  /// `slack`: what the exact value itself is uncertain by (rounded tables, tessellation), absolute.
  void add(const std::string& name, const Estimate& estimate, double exact, double slack = 0) {
    rows_.push_back({name, estimate, exact, slack});
  }
  /// The standard errors must be at most 5e-4 of the exact value, or a third of the slack; in a quick run,
  /// `quick_error` of it.
  void check(double quick_error = 5e-4) const {
    const double max_error = full_run() ? 5e-4 : quick_error;
    for (const Row& row : rows_) {
      const double t = student_t_quantile(sidak_level(0.01, rows_.size()), row.estimate.replicates - 1);
      const double allowed = t * row.estimate.error + 2e-4 * row.exact + row.slack;
      INFO(row.name, ": mean ", row.estimate.mean, " +- ", row.estimate.error, ", exact ", row.exact, ", allowed ",
           allowed);
      CHECK(std::abs(row.estimate.mean - row.exact) <= allowed);
      CHECK(row.estimate.error <= std::max(max_error * row.exact, row.slack / 3));
    }
  }

 private:
  struct Row {
    std::string name;
    Estimate estimate;
    double exact, slack;
  };
  std::vector<Row> rows_;
};

}  // namespace lucarium::test
