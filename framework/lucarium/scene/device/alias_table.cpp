// SPDX-License-Identifier: Apache-2.0
#include "lucarium/scene/device/alias_table.h"

#include <numeric>

namespace lucarium {

std::vector<AliasEntry> make_alias_table(const std::vector<double>& weights) {
  const size_t n = weights.size();
  std::vector<AliasEntry> table(n);
  const double sum = std::accumulate(weights.begin(), weights.end(), 0.0);
  std::vector<double> scaled(n);  // n · pmf: 1 fills a column
  std::vector<uint> small, large;
  for (uint i = 0; i < n; ++i) {
    const double pmf = sum > 0 ? weights[i] / sum : 1.0 / static_cast<double>(n);
    table[i] = {1.f, i, static_cast<float>(pmf), 0.f};
    scaled[i] = pmf * static_cast<double>(n);
    (scaled[i] < 1 ? small : large).push_back(i);
  }
  while (!small.empty() && !large.empty()) {
    const uint poor = small.back(), rich = large.back();
    small.pop_back();
    table[poor].probability = static_cast<float>(scaled[poor]);
    table[poor].alias = rich;
    scaled[rich] -= 1 - scaled[poor];
    if (scaled[rich] < 1) {
      large.pop_back();
      small.push_back(rich);
    }
  }
  // What is left is 1 up to rounding: such columns keep probability 1, except impossible ones.
  for (const uint i : small) {
    if (table[i].pmf == 0 && !large.empty()) table[i].probability = 0, table[i].alias = large.back();
  }
  return table;
}

}  // namespace lucarium
