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
  std::string id, title, place, claim, differences;
  bool quick = false;
  std::vector<Value> values;
  std::vector<Trend> trends;

  std::string table() const;  ///< for people, on a terminal
};

/// The quantities are those of docs/reproducing.md, averaged over the seeds.
Reproduction reproduce(const Experiment& experiment, const ComparisonResult& result, ImagePairs& pairs);

}  // namespace lucarium
