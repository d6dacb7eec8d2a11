// SPDX-License-Identifier: Apache-2.0
#include "lucarium/compare/results/reproduction.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "lucarium/base/error.h"
#include "lucarium/base/json.h"
#include "lucarium/compare/request/expression.h"
#include "lucarium/compare/results/comparison_result.h"
#include "lucarium/compare/results/error_curve.h"
#include "lucarium/compare/results/summary.h"

namespace lucarium {

using nlohmann::json;

namespace {

/// A name as expressions can use it.
std::string expression_name(std::string name) {
  for (char& c : name) {
    if (!std::isalnum(static_cast<unsigned char>(c))) c = '_';
  }
  return name;
}

void lower(std::map<std::string, double>& numbers, const std::string& name, double value) {
  const auto [entry, is_new] = numbers.try_emplace(name, value);
  if (!is_new) entry->second = std::min(entry->second, value);
}

/// Counters and passes of the render summaries, averaged; times also of the seed that other programs disturbed least.
void add_counters(const std::vector<const PieceResult*>& pieces, std::map<std::string, double>& numbers) {
  const double share = 1.0 / static_cast<double>(pieces.size());
  for (const PieceResult* piece : pieces) {
    const json summary = json::parse(piece->render_summary);
    for (const auto& [name, value] : summary.at("counters").items()) {
      if (value.is_number()) numbers["counter_" + expression_name(name)] += share * value.get<double>();
    }
    std::map<std::string, double> passes;  // of several schedules, and the sums of these
    for (const json& pass : summary.at("passes")) {
      const double seconds = pass.at("device_seconds").get<double>();
      passes["pass_" + expression_name(pass.at("name"))] += seconds;
      passes["schedule_" + expression_name(pass.at("schedule"))] += seconds;
    }
    for (const auto& [name, seconds] : passes) {
      numbers[name] += share * seconds;
      lower(numbers, "fastest_" + name, seconds);
    }
    lower(numbers, "fastest_iterate_seconds", piece->iterate_seconds);
  }
}

std::vector<CurvePoint> mean_curve(const Summary& summary) {
  std::vector<CurvePoint> curve;
  for (const SummaryPoint& point : summary.curve) curve.push_back({point.seconds, point.relmse.mean});
  return curve;
}

double seconds_to(const Summary& summary, double relmse) {
  const TimeToError reached = time_to_error(mean_curve(summary), relmse);
  return reached.state == TimeToError::State::not_reached ? NAN : reached.time;
}

/// Everything that an expression about one variant may use.
ExpressionScope quantities(const ComparisonResult& result, const SummaryKey& key) {
  ExpressionScope scope;
  const auto found = result.summaries.find(key);
  const std::vector<const PieceResult*> pieces = pieces_of(result, key);
  if (found == result.summaries.end() || pieces.empty()) return scope;
  const Summary& summary = found->second;
  double iterations = 0;
  for (const PieceResult* piece : pieces)
    iterations += static_cast<double>(piece->iterations) / static_cast<double>(pieces.size());
  scope.numbers = {{"iterations", iterations},
                   {"samples", summary.samples},
                   {"prepare_seconds", summary.prepare_seconds},
                   {"iterate_seconds", summary.iterate_seconds},
                   {"device_seconds", summary.device_seconds},
                   {"seconds", summary.prepare_seconds + summary.iterate_seconds},
                   {"peak_host_bytes", static_cast<double>(summary.peak_host_bytes)},
                   {"peak_device_bytes", static_cast<double>(summary.peak_device_bytes)},
                   {"triangles", static_cast<double>(result.scenes[std::get<0>(key)].triangles)},
                   {"pixels", static_cast<double>(result.spec.width) * result.spec.height}};
  if (summary.reached_seconds) scope.numbers["reached_seconds"] = summary.reached_seconds->mean;
  if (summary.walk) {
    scope.numbers["walk_min_seconds"] = summary.walk->min_seconds;
    scope.numbers["walk_median_seconds"] = summary.walk->median_seconds;
    scope.numbers["walk_max_seconds"] = summary.walk->max_seconds;
    if (summary.walk->relmse) scope.numbers["walk_relMSE"] = *summary.walk->relmse;
  }
  for (const auto& [name, mean] : summary.metrics) scope.numbers[expression_name(name)] = mean.mean;
  if (summary.bias) {
    scope.numbers["bias_MSE"] = summary.bias->bias2;
    scope.numbers["variance_MSE"] = summary.bias->variance;
    scope.numbers["relative_mean"] = summary.bias->relative_mean.mean;
  }
  add_counters(pieces, scope.numbers);
  scope.functions["seconds_to"] = [&summary](double relmse) { return seconds_to(summary, relmse); };
  scope.functions["relmse_at"] = [&summary](double time) { return error_at_time(mean_curve(summary), time); };
  return scope;
}

/// Times, as expressions call them.
bool is_time_name(const std::string& name) {
  return name == "seconds" || name.ends_with("_seconds") || name.starts_with("pass_") ||
         name.starts_with("schedule_") || name.starts_with("fastest_");
}

/// Of unlike machines nothing is said that compares them: no time, and what a budget of time led to only where it has
/// no part in it. The names stay, as NaN, and are returned; functions set `asked` when an expression calls them.
std::set<std::string> forget_times(ExpressionScope& scope, bool budget_of_time, bool& asked) {
  static const std::set<std::string> same_anywhere = {"triangles", "pixels", "peak_host_bytes", "peak_device_bytes"};
  std::set<std::string> forgotten;
  for (auto& [name, number] : scope.numbers) {
    if (!is_time_name(name) && (!budget_of_time || same_anywhere.contains(name))) continue;
    number = NAN;
    forgotten.insert(name);
  }
  for (auto& [name, function] : scope.functions) {
    function = [&asked](double) {
      asked = true;
      return NAN;
    };
  }
  return forgotten;
}

/// Where the variant stands in this comparison, which may be a quick one without it; its size when it is not there.
size_t find_variant(const ComparisonResult& result, const std::string& label) {
  const std::vector<TechniqueVariant>& variants = result.spec.variants;
  return static_cast<size_t>(std::find_if(variants.begin(), variants.end(),
                                          [&](const TechniqueVariant& variant) { return variant.label() == label; }) -
                             variants.begin());
}

/// Replaces the metrics by those against the images of another variant; false where it has none.
bool compare_images(ExpressionScope& scope, const ComparisonResult& result, const ExperimentValue& value,
                    ImagePairs& pairs) {
  const auto key = [&](const std::string& label) {
    return SummaryKey{value.scene, find_variant(result, label), value.budget};
  };
  const std::map<std::string, double> errors = pairs.measure(result, key(value.variant), key(value.against));
  for (const auto& [name, error] : errors) scope.numbers[expression_name(name)] = error;
  return !errors.empty();
}

bool uses_any(const std::string& expression, const std::set<std::string>& names) {
  const std::vector<std::string> used = expression_names(expression);
  return std::any_of(used.begin(), used.end(), [&](const std::string& name) { return names.contains(name); });
}

std::string verdict(double value) {
  if (std::isnan(value)) return "unknown";
  return value != 0 ? "holds" : "fails";
}

std::string number_text(double value) { return std::isnan(value) ? "–" : fmt::format("{:.4g}", value); }

}  // namespace

Reproduction reproduce(const Experiment& experiment, const ComparisonResult& result, ImagePairs& pairs) {
  Reproduction reproduction{experiment.id(),
                            experiment.title,
                            experiment.place,
                            experiment.claim,
                            experiment.differences,
                            experiment.quick,
                            {},
                            {}};
  std::map<std::string, double> values;
  std::set<std::string> unlike;  // values that need machines of one kind
  for (const ExperimentValue& value : experiment.values) {
    ExpressionScope scope;
    if (!value.variant.empty())
      scope = quantities(result, {value.scene, find_variant(result, value.variant), value.budget});
    bool measured = value.variant.empty() || scope.numbers.contains("seconds");
    if (!value.against.empty()) measured = measured && compare_images(scope, result, value, pairs);
    std::set<std::string> forgotten;
    bool asked = false;
    if (scope.numbers.contains("seconds") && result.scenes[value.scene].unlike_machines)
      forgotten = forget_times(scope, result.spec.budgets[value.budget].seconds > 0, asked);
    forgotten.insert(unlike.begin(), unlike.end());
    scope.numbers.insert(values.begin(), values.end());
    double ours = measured ? evaluate_expression(value.expression, scope) : NAN;
    if (asked) ours = NAN;  // whatever the expression made of it
    if (measured && (asked || uses_any(value.expression, forgotten))) unlike.insert(value.name);
    values[value.name] = ours;
    reproduction.values.push_back({value.label, value.unit, ours, value.paper});
  }
  for (const ExperimentTrend& trend : experiment.trends) {
    const double holds = evaluate_expression(trend.expression, {values, {}});
    reproduction.trends.push_back({trend.claim, trend.expression, verdict(holds), uses_any(trend.expression, unlike)});
  }
  return reproduction;
}

std::string Reproduction::table() const {
  std::string text =
      fmt::format("{} ({}{}): {}\n  paper: {}\n", id, place, quick ? ", quick setting" : "", title, claim);
  if (!differences.empty()) text += fmt::format("  here:  {}\n", differences);
  size_t width = 0;
  for (const Value& value : values) width = std::max(width, value.label.size());
  if (!values.empty()) text += fmt::format("  {:{}}  {:>12}  {:>12}\n", "", width, "measured", "paper");
  for (const Value& value : values) {
    text += fmt::format("  {:{}}  {:>12}  {:>12}  {}\n", value.label, width, number_text(value.ours),
                        number_text(value.paper.value_or(NAN)), value.unit);
  }
  for (const Trend& trend : trends)
    text += fmt::format("  {}{}: {}  [{}]\n", trend.verdict, trend.unlike_machines ? ", since the machines differ" : "",
                        trend.claim, trend.expression);
  return text;
}

}  // namespace lucarium
