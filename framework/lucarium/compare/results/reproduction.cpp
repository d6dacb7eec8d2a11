// SPDX-License-Identifier: Apache-2.0
#include "lucarium/compare/results/reproduction.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "lucarium/base/error.h"
#include "lucarium/base/json.h"
#include "lucarium/compare/request/device_arguments.h"
#include "lucarium/compare/request/expression.h"
#include "lucarium/compare/results/comparison_result.h"
#include "lucarium/compare/results/error_curve.h"
#include "lucarium/compare/results/summary.h"

namespace lucarium {

using nlohmann::json;

namespace {

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

/// relMSE without the reference's own, where that is not most of it, and what it is at most.
void add_debiased_error(const ComparisonResult& result, const SummaryKey& key, std::map<std::string, double>& numbers) {
  const auto& [scene, variant, budget] = key;
  const SceneResult& entry = result.scenes[scene];
  const auto found = numbers.find("relMSE");
  if (found == numbers.end() || variant >= entry.variants.size()) return;
  const size_t reference = entry.variants[variant].reference;
  if (reference >= entry.references.size()) return;
  const double own = entry.references[reference].relmse;
  const double debiased = debiased_error(found->second, own).value;
  if (found->second > 2 * own) numbers["debiased_relMSE"] = debiased;
  numbers["relMSE_at_most"] = std::max(debiased, own);
}

/// What the scene is rendered with. Unlimited bounces are no number.
void add_settings(const ComparisonResult& result, size_t scene, const PieceResult& piece,
                  std::map<std::string, double>& numbers) {
  const SceneSettings settings = result.spec.settings_of(result.spec.scenes[scene]);
  numbers["pixels"] = static_cast<double>(settings.width) * settings.height;
  if (settings.max_bounces >= 0) numbers["max_bounces"] = settings.max_bounces;
  DeviceOptions device;
  read_device_arguments(settings.device_arguments, device);
  if (device.threads > 0)
    numbers["threads"] = device.threads;
  else if (piece.machine)
    numbers["threads"] = piece.machine->machine.logical_cores;
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
                   {"emissive_triangles", static_cast<double>(result.scenes[std::get<0>(key)].emissive_triangles)}};
  add_settings(result, std::get<0>(key), *pieces.front(), scope.numbers);
  if (summary.processor_seconds) scope.numbers["processor_seconds"] = *summary.processor_seconds;
  if (summary.reached_seconds) scope.numbers["reached_seconds"] = summary.reached_seconds->mean;
  if (summary.walk) {
    scope.numbers["walk_min_seconds"] = summary.walk->min_seconds;
    scope.numbers["walk_median_seconds"] = summary.walk->median_seconds;
    scope.numbers["walk_max_seconds"] = summary.walk->max_seconds;
    if (summary.walk->relmse) scope.numbers["walk_relMSE"] = *summary.walk->relmse;
  }
  for (const auto& [name, mean] : summary.metrics) scope.numbers[expression_name(name)] = mean.mean;
  add_debiased_error(result, key, scope.numbers);
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
  static const std::set<std::string> same_anywhere = {
      "triangles", "emissive_triangles", "pixels", "max_bounces", "threads", "peak_host_bytes", "peak_device_bytes"};
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

/// Replaces the metrics by those against the images of another variant, or of a layer; false where it has none.
bool compare_images(ExpressionScope& scope, const ComparisonResult& result, const ExperimentValue& value,
                    ImagePairs& pairs) {
  const auto key = [&](const std::string& label) {
    return SummaryKey{value.scene, find_variant(result, label), value.budget};
  };
  const std::map<std::string, double> errors = value.layer.empty()
                                                   ? pairs.measure(result, key(value.variant), key(value.against))
                                                   : pairs.measure_layer(result, key(value.variant), value.layer);
  for (const char* of_whole_image : {"debiased_relMSE", "relMSE_at_most"}) scope.numbers.erase(of_whole_image);
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

/// What an expression may use of a variant, and the names that say nothing since the machines differ.
struct VariantScope {
  ExpressionScope scope;
  std::set<std::string> forgotten;
  bool measured() const { return scope.numbers.contains("seconds"); }
};

/// `asked` is set when an expression calls a function of times that were forgotten.
void forget_unlike(VariantScope& variant, const ComparisonResult& result, size_t scene, size_t budget, bool& asked) {
  if (variant.measured() && result.scenes[scene].unlike_machines)
    variant.forgotten = forget_times(variant.scope, result.spec.budgets[budget].seconds > 0, asked);
}

/// One line of a plot. `unlike`: a point is missing since the machines differ.
Reproduction::Line plot_line(const ExperimentPlot& plot, const std::string& variant, const ComparisonResult& result,
                             bool& unlike) {
  Reproduction::Line line{variant, {}};
  for (const size_t scene : plot.scenes) {
    bool asked = false;
    VariantScope of{quantities(result, {scene, find_variant(result, variant), plot.budget}), {}};
    if (!of.measured()) continue;
    forget_unlike(of, result, scene, plot.budget, asked);
    const Reproduction::Point point{evaluate_expression(plot.x, of.scope), evaluate_expression(plot.y, of.scope)};
    if (asked || uses_any(plot.x, of.forgotten) || uses_any(plot.y, of.forgotten))
      unlike = true;
    else if (std::isfinite(point.x) && std::isfinite(point.y))
      line.points.push_back(point);
  }
  if (!unlike) line.slope = loglog_slope(line.points);
  return line;
}

}  // namespace

Reproduction reproduce(const Experiment& experiment, const ComparisonResult& result, ImagePairs& pairs) {
  Reproduction reproduction;
  reproduction.id = experiment.id();
  reproduction.title = experiment.title;
  reproduction.place = experiment.place;
  reproduction.claim = experiment.claim;
  reproduction.differences = experiment.differences;
  reproduction.quick = experiment.quick;
  reproduction.own = experiment.own;
  std::map<std::string, double> values;
  std::set<std::string> unlike;  // values that need machines of one kind
  for (const ExperimentValue& value : experiment.values) {
    VariantScope variant;
    bool asked = false;
    if (!value.variant.empty())
      variant.scope = quantities(result, {value.scene, find_variant(result, value.variant), value.budget});
    bool measured = value.variant.empty() || variant.measured();
    if (!value.against.empty() || !value.layer.empty())
      measured = measured && compare_images(variant.scope, result, value, pairs);
    forget_unlike(variant, result, value.scene, value.budget, asked);
    variant.forgotten.insert(unlike.begin(), unlike.end());
    variant.scope.numbers.insert(values.begin(), values.end());
    double ours = measured ? evaluate_expression(value.expression, variant.scope) : NAN;
    if (asked) ours = NAN;  // whatever the expression made of it
    if (measured && (asked || uses_any(value.expression, variant.forgotten))) unlike.insert(value.name);
    values[value.name] = ours;
    reproduction.values.push_back({value.label, value.unit, ours, value.paper});
  }
  for (const ExperimentPlot& plot : experiment.plots) {
    Reproduction::Plot made{plot.title, plot.x_label, plot.y_label, {}};
    for (const std::string& variant : plot.variants) {
      bool differ = false;
      made.lines.push_back(plot_line(plot, variant, result, differ));
      values[plot.slope_name(variant)] = made.lines.back().slope;
      if (differ) unlike.insert(plot.slope_name(variant));
    }
    reproduction.plots.push_back(std::move(made));
  }
  for (const ExperimentTrend& trend : experiment.trends) {
    const double holds = evaluate_expression(trend.expression, {values, {}});
    reproduction.trends.push_back({trend.claim, trend.expression, verdict(holds), uses_any(trend.expression, unlike)});
  }
  return reproduction;
}

double loglog_slope(const std::vector<Reproduction::Point>& points) {
  double mean_x = 0, mean_y = 0, xx = 0, xy = 0;
  const auto count = static_cast<double>(points.size());
  for (const Reproduction::Point& point : points) {
    if (!(point.x > 0 && point.y > 0)) return NAN;
    mean_x += std::log(point.x) / count;
    mean_y += std::log(point.y) / count;
  }
  for (const Reproduction::Point& point : points) {
    const double dx = std::log(point.x) - mean_x;
    xx += dx * dx;
    xy += dx * (std::log(point.y) - mean_y);
  }
  return xx > 1e-12 ? xy / xx : NAN;
}

}  // namespace lucarium
