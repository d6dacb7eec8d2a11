// SPDX-License-Identifier: Apache-2.0
#include "lucarium/compare/results/baseline.h"

#include <cmath>
#include <limits>
#include <set>

#include "lucarium/base/error.h"
#include "lucarium/base/files/atomic_file.h"
#include "lucarium/base/json.h"
#include "lucarium/compare/results/summary.h"
#include "lucarium/statistics/student_t.h"

namespace lucarium {

using nlohmann::json;

namespace {

constexpr double level = 0.05;
const std::vector<std::string> compared_metrics = {"relMSE", "HDR_FLIP", "seconds"};

/// Mean and squared standard error of the logarithms.
struct LogMean {
  double mean = 0, error2 = 0;
};

LogMean log_mean(const std::vector<double>& values) {
  LogMean result;
  const double n = static_cast<double>(values.size());
  for (const double value : values) result.mean += std::log(value) / n;
  if (values.size() < 2) return result;
  for (const double value : values) result.error2 += std::pow(std::log(value) - result.mean, 2) / (n - 1) / n;
  return result;
}

/// The values of a metric that can be compared: positive ones.
void add_value(std::vector<double>& values, double value) {
  if (value > 0 && std::isfinite(value)) values.push_back(value);
}

std::vector<double> values_now(const ComparisonResult& result, const SummaryKey& key, const std::string& metric) {
  std::vector<double> values;
  for (const PieceResult* piece : pieces_of(result, key)) {
    if (metric == "seconds") {
      add_value(values, piece->reached_seconds.value_or(piece->seconds()));
    } else if (const auto found = piece->metrics.find(metric); found != piece->metrics.end()) {
      add_value(values, found->second);
    }
  }
  return values;
}

std::vector<double> values_then(const json& old, size_t scene, size_t variant, size_t budget,
                                const std::string& metric) {
  std::vector<double> values;
  for (const json& piece : old.at("pieces")) {
    if (piece.contains("failure") || piece.at("scene") != scene || piece.at("variant") != variant ||
        piece.at("budget") != budget)
      continue;
    if (metric == "seconds") {
      const double seconds = piece.at("prepare_seconds").get<double>() + piece.at("iterate_seconds").get<double>();
      add_value(values, piece.value("reached_seconds", seconds));
    } else {
      add_value(values, piece.at("metrics").value(metric, 0.0));
    }
  }
  return values;
}

/// Index of the element with this label, or npos.
size_t find_label(const json& list, const char* key, const std::string& label) {
  for (size_t i = 0; i < list.size(); ++i) {
    if (list[i].at(key) == label) return i;
  }
  return std::string::npos;
}

std::string judge(const ConfidenceInterval& ratio) {
  if (!std::isfinite(ratio.high) || ratio.low <= 0) return "unknown";
  return ratio.high < 1 ? "better" : ratio.low > 1 ? "worse" : "same";
}

/// Whether all pieces, now and then, ran on one kind of machine, as far as that is known. Another driver is no other
/// machine: what it changes may be what is asked for.
bool one_kind_of_machine(const ComparisonResult& result, const json& old) {
  std::set<std::pair<std::string, unsigned>> kinds;
  std::set<std::string> devices;
  for (const PieceResult& piece : result.pieces) {
    if (!piece.failure.empty()) continue;
    if (piece.machine) kinds.insert({piece.machine->machine.cpu, piece.machine->machine.logical_cores});
    devices.insert(json::parse(piece.render_summary).value("device", ""));
  }
  for (const json& piece : old.at("pieces")) {
    if (piece.contains("failure")) continue;
    const auto machine = piece.find("machine");
    if (machine != piece.end())
      kinds.emplace(machine->at("cpu").get<std::string>(), machine->at("logical_cores").get<unsigned>());
    devices.insert(piece.value("device", old.value("device", "")));  // earlier versions name one for all pieces
  }
  devices.erase("");
  return kinds.size() < 2 && devices.size() < 2;
}

json read_results(const std::filesystem::path& folder) {
  const std::filesystem::path file = folder / "results.json";
  try {
    json old = json::parse(read_file(file));
    if (old.at("schema") != "lucarium-results-2") {
      throw_error(ErrorClass::input, "{}: its schema {} cannot be compared with", file.string(),
                  old.at("schema").dump());
    }
    return old;
  } catch (const json::exception& error) {
    throw_error(ErrorClass::input, "{}: not a results file: {}", file.string(), error.what());
  }
}

}  // namespace

ConfidenceInterval welch_ratio(const std::vector<double>& now, const std::vector<double>& then) {
  const LogMean a = log_mean(now), b = log_mean(then);
  ConfidenceInterval ratio;
  ratio.seeds = std::min(now.size(), then.size());
  ratio.mean = std::exp(a.mean - b.mean);
  ratio.low = 0;
  ratio.high = std::numeric_limits<double>::infinity();
  if (ratio.seeds < 2) return ratio;
  const double variance = a.error2 + b.error2;
  double spread = 0;
  if (variance > 0) {
    const double dof = variance * variance /
                       (a.error2 * a.error2 / static_cast<double>(now.size() - 1) +
                        b.error2 * b.error2 / static_cast<double>(then.size() - 1));
    spread = student_t_quantile(level, dof) * std::sqrt(variance);
  }
  ratio.low = ratio.mean * std::exp(-spread);
  ratio.high = ratio.mean * std::exp(spread);
  return ratio;
}

BaselineComparison compare_with_baseline(const ComparisonResult& result, const std::filesystem::path& folder) {
  const json old = read_results(folder);
  BaselineComparison comparison;
  comparison.folder = folder.string();
  try {
    comparison.version = old.at("version");
    const bool times_compare = one_kind_of_machine(result, old);
    for (const auto& [key, summary] : result.summaries) {
      const auto [scene, variant, budget] = key;
      const std::string label = result.spec.variants[variant].label(), wanted = result.spec.budgets[budget].label();
      const size_t old_scene = find_label(old.at("scenes"), "name", result.scenes[scene].name);
      const size_t old_variant = find_label(old.at("variants"), "label", label);
      const size_t old_budget = find_label(old.at("budgets"), "label", wanted);
      bool found = false;
      for (const std::string& metric : compared_metrics) {
        const std::vector<double> now = values_now(result, key, metric);
        const std::vector<double> then = values_then(old, old_scene, old_variant, old_budget, metric);
        if (now.empty() || then.empty()) continue;
        found = true;
        const ConfidenceInterval ratio = welch_ratio(now, then);
        const bool about_time = metric == "seconds" || result.spec.budgets[budget].seconds > 0;
        const std::string verdict = about_time && !times_compare ? "unknown" : judge(ratio);
        comparison.changes.push_back({scene, variant, budget, metric, ratio, verdict});
      }
      if (!found) comparison.missing.push_back(fmt::format("{}, {}, {}", result.scenes[scene].name, label, wanted));
    }
  } catch (const json::exception& error) {
    throw_error(ErrorClass::input, "{}: not a results file: {}", (folder / "results.json").string(), error.what());
  }
  return comparison;
}

std::string BaselineComparison::table(const ComparisonResult& result) const {
  std::string text = fmt::format("against {} (version {}): ratio of now over then\n", folder, version);
  for (const BaselineChange& change : changes) {
    const std::string interval =
        change.ratio.seeds > 1 ? fmt::format(" [{:.3g}, {:.3g}]", change.ratio.low, change.ratio.high) : "";
    text += fmt::format("  {:<7} {:<9} {:.3g}{}  {}, {}, {}\n", change.verdict, change.metric, change.ratio.mean,
                        interval, result.scenes[change.scene].name, result.spec.variants[change.variant].label(),
                        result.spec.budgets[change.budget].label());
  }
  for (const std::string& line : missing) text += fmt::format("  not in it: {}\n", line);
  return text;
}

}  // namespace lucarium
