// SPDX-License-Identifier: Apache-2.0
// Contestants measured in turns: first all of them once, then all of them again, so that whatever else the machine does
// meets each of them alike.
#pragma once
#include <functional>
#include <string>
#include <vector>

namespace lucarium::bench {

struct Contestant {
  std::string name;
  std::function<void()> run;
  unsigned cpus = 1;              ///< the process is pinned to that many processors while it runs
  std::vector<double> cpu, wall;  ///< seconds, one per round: processor time of the process, and elapsed
};

void run_rounds(std::vector<Contestant>& contestants, int rounds);

double median(std::vector<double> values);
/// Median over the rounds of a[i] / b[i].
double median_ratio(const std::vector<double>& a, const std::vector<double>& b);

}  // namespace lucarium::bench
