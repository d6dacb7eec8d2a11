// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <limits>
#include <string>
#include <vector>

#include "lucarium/compare/request/experiment.h"
#include "lucarium/compare/results/image_pairs.h"

namespace lucarium {

struct ComparisonResult;

/// An experiment's values and trends, read off the results of its comparison.
struct Reproduction {
  struct Value {
    std::string label, unit;
    double ours = std::numeric_limits<double>::quiet_NaN();  ///< NaN: not measured
    std::optional<double> paper;
  };
  struct Trend {
    std::string claim, expression;
    std::string verdict;           ///< holds, fails, unknown (something it needs was not measured)
    bool unlike_machines = false;  ///< unknown, since it compares times of pieces that ran on several kinds of machine
  };
  struct Point {
    double x = 0, y = 0;
  };
  /// What one variant does in a plot.
  struct Line {
    std::string label;
    std::vector<Point> points;  ///< in the order of the scenes, without those that were not measured
    double slope = std::numeric_limits<double>::quiet_NaN();  ///< of log y over log x; NaN: of fewer than two points
  };
  struct Plot {
    std::string title, x_label, y_label;
    std::vector<Line> lines;
  };
  std::string id, title, place, claim, differences;
  bool quick = false;
  bool own = false;  ///< of no paper
  std::vector<Value> values;
  std::vector<Plot> plots;
  std::vector<Trend> trends;

  std::string table() const;  ///< for people, on a terminal
};

/// The quantities are those of docs/reproducing.md, averaged over the seeds.
Reproduction reproduce(const Experiment& experiment, const ComparisonResult& result, ImagePairs& pairs);

/// Least squares over logarithms; NaN unless two points differ in x, and where a coordinate is not positive.
double loglog_slope(const std::vector<Reproduction::Point>& points);

}  // namespace lucarium
