// SPDX-License-Identifier: Apache-2.0
#include "lucarium/technique/budget_plan.h"

#include <algorithm>
#include <set>

namespace lucarium {
namespace {

constexpr double picture_share = 0.5;      // of the budget, for the first whole picture
constexpr double min_saving = 0.1;         // of the time, that a smaller value must be worth
constexpr double triangle_seconds = 3e-6;  // of a core: upload and BVH; measured on builtin:atrium

/// Names of the parameters that are the user's: those given, and all where a preset is given, since it gives all.
std::set<std::string> given_names(Technique& technique, const std::vector<std::pair<std::string, std::string>>& given) {
  const std::vector<ParameterTable::Entry>& entries = technique.parameters().entries();
  std::set<std::string> names;
  for (const auto& one : given) {
    names.insert(one.first);
    const bool preset = std::any_of(entries.begin(), entries.end(), [&](const ParameterTable::Entry& entry) {
      return entry.info.name == one.first && !entry.presets.empty();
    });
    if (!preset) continue;
    for (const ParameterTable::Entry& entry : entries) names.insert(entry.info.name);
  }
  return names;
}

/// The steps from the present parameters down to the smallest ones: the same for every budget.
class Savings {
 public:
  Savings(Technique& technique, const std::set<std::string>& given, const Scene& scene, const RenderSettings& settings,
          const ComputePower& power)
      : technique_(technique),
        scene_(scene),
        settings_(settings),
        power_(power),
        path_set_(technique.path_set(scene, settings).to_string()),
        savings_(technique.savings(scene, settings)),
        next_(savings_.size(), 0) {
    std::erase_if(savings_, [&](const ParameterSaving& saving) { return given.contains(saving.parameter); });
    seconds_ = estimate();
  }

  double seconds() const { return seconds_; }

  /// One value lower, of the parameters in turn. False when nothing is worth it any more.
  bool step() { return step(false) || step(true); }

 private:
  double estimate() const {
    return triangle_seconds * static_cast<double>(scene_.triangle_count()) / power_.host +
           technique_.estimate_seconds(scene_, settings_, power_);
  }

  bool step(bool last_resort) {
    for (size_t tried = 0; tried < savings_.size(); ++tried) {
      const size_t i = (turn_ + tried) % savings_.size();
      if (savings_[i].last_resort != last_resort || !lower(i)) continue;
      turn_ = (i + 1) % savings_.size();
      return true;
    }
    return false;
  }

  /// Gives parameter `i` its next value that saves enough time to be worth it. Light paths stay what they are: an image
  /// is compared with the reference of the parameters that were asked for.
  bool lower(size_t i) {
    const ParameterSaving& saving = savings_[i];
    ParameterTable& parameters = technique_.parameters();
    const std::string before = parameters.get(saving.parameter);
    for (size_t k = next_[i]; k < saving.values.size(); ++k) {
      parameters.set(saving.parameter, saving.values[k]);
      const double seconds = estimate();
      if (seconds <= (1 - min_saving) * seconds_ && technique_.path_set(scene_, settings_).to_string() == path_set_) {
        seconds_ = seconds;
        next_[i] = k + 1;
        return true;
      }
    }
    parameters.set(saving.parameter, before);
    return false;  // a value may be worth more when others have become cheap
  }

  Technique& technique_;
  const Scene& scene_;
  const RenderSettings& settings_;
  const ComputePower& power_;
  const std::string path_set_;
  std::vector<ParameterSaving> savings_;
  std::vector<size_t> next_;  ///< of a saving's values
  size_t turn_ = 0;
  double seconds_ = 0;
};

std::vector<std::pair<std::string, std::string>> values_of(Technique& technique) {
  std::vector<std::pair<std::string, std::string>> values;
  for (const ParameterTable::Entry& entry : technique.parameters().entries())
    if (entry.presets.empty()) values.emplace_back(entry.info.name, entry.get());
  return values;
}

/// Nothing where a limit is given: the user has said when it is to end.
std::vector<BudgetPlan::Change> lift_limits(Technique& technique, const std::set<std::string>& given) {
  std::vector<BudgetPlan::Change> lifted;
  const auto values = technique.endless();
  const auto is_given = [&](const auto& value) {
    return given.contains(value.first) && technique.parameters().get(value.first) != value.second;
  };
  if (std::any_of(values.begin(), values.end(), is_given)) return lifted;
  for (const auto& [name, value] : values) {
    if (technique.parameters().get(name) == value) continue;
    lifted.push_back({name, technique.parameters().get(name), value});
    technique.parameters().set(name, value);
  }
  return lifted;
}

}  // namespace

std::string BudgetPlan::changes_text() const {
  std::string text;
  for (const Change& change : changes)
    text += fmt::format("{}{} {} -> {}", text.empty() ? "" : ", ", change.parameter, change.from, change.to);
  return text;
}

BudgetPlan plan_budget(Technique& technique, const std::vector<std::pair<std::string, std::string>>& given,
                       const Scene& scene, const RenderSettings& settings, const ComputePower& power,
                       const TimeBudget& time) {
  BudgetPlan plan;
  const std::set<std::string> names = given_names(technique, given);
  if (time.to_the_end) plan.lifted = lift_limits(technique, names);
  if (time.seconds <= 0 || technique.estimate_seconds(scene, settings, power) <= 0) return plan;
  const auto before = values_of(technique);
  Savings savings(technique, names, scene, settings, power);
  plan.budget_seconds = time.seconds;
  plan.default_seconds = savings.seconds();
  while (savings.seconds() > picture_share * time.seconds && savings.step()) {
  }
  plan.expected_seconds = savings.seconds();
  const auto planned = values_of(technique);
  for (size_t i = 0; i < before.size(); ++i)
    if (planned[i] != before[i]) plan.changes.push_back({before[i].first, before[i].second, planned[i].second});
  while (savings.step()) {
  }
  plan.sufficient_seconds = savings.seconds() / picture_share;
  for (const auto& [name, value] : planned) technique.parameters().set(name, value);
  return plan;
}

}  // namespace lucarium
