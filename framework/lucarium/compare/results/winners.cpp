// SPDX-License-Identifier: Apache-2.0
#include "lucarium/compare/results/winners.h"

#include <algorithm>
#include <utility>

#include "lucarium/base/error.h"
#include "lucarium/compare/results/summary.h"

namespace lucarium {

namespace {

/// What decides: the smaller one is better. Absent: there is no result.
std::optional<double> deciding_value(const Summary& summary, const ComparisonBudget& budget) {
  if (budget.relmse > 0) {
    if (!summary.reached_seconds) return std::nullopt;
    return summary.reached_seconds->mean;
  }
  const auto found = summary.metrics.find("relMSE");
  if (found == summary.metrics.end() || !(found->second.mean > 0)) return std::nullopt;
  return found->second.mean;
}

ConfidenceInterval inverse_of(const ConfidenceInterval& ratio) {
  ConfidenceInterval inverse = ratio;
  inverse.mean = 1 / ratio.mean;
  inverse.low = 1 / ratio.high;
  inverse.high = 1 / ratio.low;
  return inverse;
}

/// Paired by seeds; without an interval where the pieces share none.
ConfidenceInterval ratio_of(const Winner& winner, double best, double next, const std::vector<SummaryPair>& pairs) {
  for (const SummaryPair& pair : pairs) {
    if (pair.scene != winner.scene || pair.budget != winner.budget || pair.metric != winner.metric) continue;
    if (pair.a == winner.next && pair.b == winner.best) return pair.ratio;
    if (pair.a == winner.best && pair.b == winner.next) return inverse_of(pair.ratio);
  }
  ConfidenceInterval ratio;
  ratio.mean = next / best;
  ratio.seeds = 1;
  return ratio;
}

}  // namespace

std::vector<Winner> find_winners(const ComparisonResult& result) {
  const std::vector<SummaryPair> pairs = make_pairs(result);
  std::vector<Winner> winners;
  for (size_t scene = 0; scene < result.scenes.size(); ++scene) {
    for (size_t budget = 0; budget < result.spec.budgets.size(); ++budget) {
      const ComparisonBudget& asked = result.spec.budgets[budget];
      if (result.scenes[scene].unlike_machines && (asked.seconds > 0 || asked.relmse > 0)) continue;
      std::vector<std::pair<double, size_t>> values;
      for (size_t variant = 0; variant < result.spec.variants.size(); ++variant) {
        const auto found = result.summaries.find({scene, variant, budget});
        if (found == result.summaries.end()) continue;
        if (const auto value = deciding_value(found->second, asked)) values.emplace_back(*value, variant);
      }
      if (values.size() < 2) continue;
      std::partial_sort(values.begin(), values.begin() + 2, values.end());
      Winner winner{scene, budget, values[0].second, values[1].second, asked.relmse > 0 ? "seconds" : "relMSE", {}};
      for (const size_t variant : {winner.best, winner.next})
        winner.resolved &= result.summaries.at({scene, variant, budget}).resolved;
      winner.ratio = ratio_of(winner, values[0].first, values[1].first, pairs);
      if (winner.ratio.mean < 1) {  // a geometric mean, which may order two close ones otherwise than their means do
        std::swap(winner.best, winner.next);
        winner.ratio = inverse_of(winner.ratio);
      }
      winners.push_back(std::move(winner));
    }
  }
  return winners;
}

std::string describe_winners(const ComparisonResult& result) {
  std::string text;
  for (const Winner& winner : find_winners(result)) {
    const auto label = [&](size_t variant) { return result.spec.variants[variant].label(); };
    const std::string doubt = winner.ratio.seeds < 2 ? " (one seed)" : " (no difference shown)";
    text += fmt::format("  {}, {}: {}; {} has {:.3g} times its {}{}{}\n", result.scenes[winner.scene].name,
                        result.spec.budgets[winner.budget].label(), label(winner.best), label(winner.next),
                        winner.ratio.mean, winner.metric, winner.difference_shown() ? "" : doubt,
                        winner.resolved ? "" : " (close to the reference's own error)");
  }
  return text.empty() ? text : "best:\n" + text;
}

}  // namespace lucarium
