// SPDX-License-Identifier: Apache-2.0
// results.json, as docs/results.md describes it. Declared in comparison_result.h.
#include <cmath>

#include "lucarium/base/error.h"
#include "lucarium/base/json.h"
#include "lucarium/compare/results/baseline.h"
#include "lucarium/compare/results/comparison_result.h"
#include "lucarium/compare/results/summary.h"
#include "lucarium/compare/results/winners.h"
#include "lucarium/metrics/metrics.h"

namespace lucarium {

using nlohmann::ordered_json;

namespace {

/// Adds a number unless it is not finite, which JSON cannot say.
void put(ordered_json& object, const char* key, double value) {
  if (std::isfinite(value)) object[key] = value;
}

ordered_json mean_json(const ConfidenceInterval& mean) {
  ordered_json json = ordered_json::object();
  put(json, "mean", mean.mean);
  if (mean.seeds > 1) {
    put(json, "low", mean.low);
    put(json, "high", mean.high);
  }
  return json;
}

ordered_json walk_json(const WalkTimes& walk) {
  ordered_json json = {
      {"frame_seconds", {{"min", walk.min_seconds}, {"median", walk.median_seconds}, {"max", walk.max_seconds}}}};
  if (walk.relmse) json["relmse"] = *walk.relmse;
  return json;
}

ordered_json reference_json(const ReferenceResult& reference) {
  ordered_json json = {{"path_set", reference.path_set}};
  if (!reference.failure.empty()) {
    json["failure"] = reference.failure;
    return json;
  }
  json.update({{"image", reference.image},
               {"source", reference.source},
               {"samples", reference.samples},
               {"seconds", reference.seconds},
               {"from_cache", reference.from_cache}});
  if (reference.error_known) {
    json["own_mse"] = reference.mse;
    json["own_relmse"] = reference.relmse;
  }
  for (const ReferenceResult::Frame& frame : reference.walk)
    json["walk"].push_back({{"frame", frame.frame}, {"camera", frame.camera}, {"image", frame.image}});
  return json;
}

ordered_json scene_json(const SceneResult& scene) {
  ordered_json json = {{"name", scene.name},
                       {"triangles", scene.triangles},
                       {"emissive_triangles", scene.emissive_triangles},
                       {"hash", scene.hash},
                       {"exposure_stops", scene.exposure},
                       {"warnings", scene.warnings},
                       {"unlike_machines", scene.unlike_machines}};
  if (!scene.failure.empty()) {
    json["failure"] = scene.failure;
    return json;
  }
  json["references"] = ordered_json::array();
  for (const ReferenceResult& reference : scene.references) json["references"].push_back(reference_json(reference));
  json["variants"] = ordered_json::array();
  for (const SceneVariant& variant : scene.variants) {
    if (variant.refused.empty()) {
      json["variants"].push_back({{"reference", variant.reference}, {"limitations", variant.limitations}});
    } else {
      json["variants"].push_back({{"refused", variant.refused}, {"limitations", variant.limitations}});
    }
  }
  return json;
}

/// Leaves out what is not known.
template <class Value>
void put(ordered_json& object, const char* key, const std::optional<Value>& value) {
  if (!value) return;
  if constexpr (std::is_same_v<Value, ConfidenceInterval>)
    object[key] = mean_json(*value);
  else
    object[key] = *value;
}

ordered_json piece_json(const PieceResult& piece) {
  ordered_json json = {
      {"scene", piece.scene}, {"variant", piece.variant}, {"budget", piece.budget}, {"seed", piece.seed}};
  if (!piece.failure.empty()) {
    json["failure"] = piece.failure;
    return json;
  }
  json.update({{"image", piece.image},
               {"parameters", piece.parameters},
               {"iterations", piece.iterations},
               {"samples", piece.samples},
               {"iterate_seconds", piece.iterate_seconds},
               {"device_seconds", piece.device_seconds},
               {"load_seconds", piece.load_seconds},
               {"prepare_seconds", piece.prepare_seconds},
               {"compile_seconds", piece.compile_seconds},
               {"peak_host_bytes", piece.peak_host_bytes},
               {"peak_device_bytes", piece.peak_device_bytes},
               {"metrics", piece.metrics},
               {"converged", piece.converged}});
  json["snapshots"] = ordered_json::array();
  for (const Snapshot& snapshot : piece.snapshots) {
    json["snapshots"].push_back({{"seconds", snapshot.seconds},
                                 {"iterations", snapshot.iterations},
                                 {"samples", snapshot.samples},
                                 {"metrics", snapshot.metrics}});
    put(json["snapshots"].back(), "processor_seconds", snapshot.processor_seconds);
  }
  put(json, "processor_seconds", piece.processor_seconds);
  put(json, "reached_seconds", piece.reached_seconds);
  put(json, "reached_processor_seconds", piece.reached_processor_seconds);
  if (piece.walk) json["walk"] = walk_json(*piece.walk);
  if (piece.machine) json["machine"] = piece_machine_json(*piece.machine);
  const ordered_json summary = ordered_json::parse(piece.render_summary);
  for (const char* key : {"passes", "counters", "warnings"}) json[key] = summary.at(key);
  for (const char* key : {"device", "planned", "plan"})
    if (summary.contains(key)) json[key] = summary[key];
  return json;
}

ordered_json bias_json(const BiasAndVariance& bias) {
  ordered_json json = {{"mse", bias.bias2}, {"variance_mse", bias.variance}};
  put(json, "standard_errors", bias.standard_errors);
  put(json, "mse_standard_error", bias.bias2_error);
  json["relative_mean"] = mean_json(bias.relative_mean);
  put(json, "mean_t", bias.mean_t);
  return json;
}

ordered_json curve_json(const std::vector<SummaryPoint>& curve, const char* seconds) {
  ordered_json json = ordered_json::array();
  for (const SummaryPoint& point : curve)
    json.push_back({{seconds, point.seconds}, {"samples", point.samples}, {"relmse", mean_json(point.relmse)}});
  return json;
}

ordered_json times_json(const std::vector<SummaryTime>& times, const char* seconds) {
  ordered_json json = ordered_json::array();
  for (const SummaryTime& time : times) {
    ordered_json entry = {{"relmse", time.relmse}};
    if (time.seconds) entry.update({{seconds, mean_json(*time.seconds)}, {"at_most", time.at_most}});
    json.push_back(std::move(entry));
  }
  return json;
}

ordered_json summary_json(const SummaryKey& key, const Summary& summary) {
  const auto& [scene, variant, budget] = key;
  ordered_json json = {{"scene", scene}, {"variant", variant}, {"budget", budget}, {"seeds", summary.seeds}};
  json["metrics"] = ordered_json::object();
  for (const auto& [name, mean] : summary.metrics) json["metrics"][name] = mean_json(mean);
  json.update({{"iterate_seconds", summary.iterate_seconds},
               {"prepare_seconds", summary.prepare_seconds},
               {"compile_seconds", summary.compile_seconds},
               {"device_seconds", summary.device_seconds},
               {"samples", summary.samples},
               {"peak_host_bytes", summary.peak_host_bytes},
               {"peak_device_bytes", summary.peak_device_bytes},
               {"debiased_mse", summary.debiased_mse},
               {"resolved", summary.resolved}});
  if (summary.bias) json["bias"] = bias_json(*summary.bias);
  put(json, "processor_seconds", summary.processor_seconds);
  json["curve"] = curve_json(summary.curve, "seconds");
  json["processor_curve"] = curve_json(summary.processor_curve, "processor_seconds");
  if (std::isfinite(summary.slope.mean)) {
    json["slope"] = mean_json(summary.slope);
    json["slope"]["value"] = summary.slope.mean;
    json["slope"].erase("mean");
  }
  put(json, "reached_seconds", summary.reached_seconds);
  put(json, "reached_processor_seconds", summary.reached_processor_seconds);
  if (summary.walk) json["walk"] = walk_json(*summary.walk);
  json["time_to_error"] = times_json(summary.times, "seconds");
  json["processor_time_to_error"] = times_json(summary.processor_times, "processor_seconds");
  return json;
}

ordered_json budget_json(const ComparisonBudget& budget) {
  ordered_json json = {{"label", budget.label()}};
  if (budget.seconds > 0) json["seconds"] = budget.seconds;
  if (budget.iterations > 0) json["iterations"] = budget.iterations;
  if (budget.samples > 0) json["samples"] = budget.samples;
  if (budget.relmse > 0) json.update({{"relmse", budget.relmse}, {"limit_seconds", budget.limit_seconds}});
  return json;
}

ordered_json variant_json(const TechniqueVariant& variant, const VariantInfo& info) {
  ordered_json parameters = ordered_json::object();
  for (const auto& [name, value] : info.parameters) parameters[name] = value;
  return {{"label", variant.label()}, {"technique", variant.technique}, {"parameters", parameters},
          {"given", info.given},      {"summary", info.summary},        {"citation", info.citation},
          {"version", info.version}};
}

ordered_json baseline_json(const BaselineComparison& baseline) {
  ordered_json json = {{"folder", baseline.folder}, {"version", baseline.version}, {"missing", baseline.missing}};
  json["changes"] = ordered_json::array();
  for (const BaselineChange& change : baseline.changes) {
    ordered_json entry = {{"scene", change.scene},   {"variant", change.variant},  {"budget", change.budget},
                          {"metric", change.metric}, {"ratio", change.ratio.mean}, {"verdict", change.verdict}};
    if (change.ratio.seeds > 1) entry.update({{"low", change.ratio.low}, {"high", change.ratio.high}});
    json["changes"].push_back(std::move(entry));
  }
  return json;
}

ordered_json plot_json(const Reproduction::Plot& plot) {
  ordered_json json = {{"title", plot.title}, {"x_label", plot.x_label}, {"y_label", plot.y_label}};
  json["lines"] = ordered_json::array();
  for (const Reproduction::Line& line : plot.lines) {
    ordered_json entry = {{"label", line.label}, {"points", ordered_json::array()}};
    for (const Reproduction::Point& point : line.points) entry["points"].push_back({{"x", point.x}, {"y", point.y}});
    put(entry, "slope", line.slope);
    json["lines"].push_back(std::move(entry));
  }
  return json;
}

ordered_json reproduction_json(const Reproduction& reproduction) {
  ordered_json json = {{"id", reproduction.id},
                       {"title", reproduction.title},
                       {"place", reproduction.place},
                       {"claim", reproduction.claim},
                       {"quick", reproduction.quick},
                       {"own", reproduction.own},
                       {"differences", reproduction.differences}};
  json["values"] = ordered_json::array();
  for (const Reproduction::Value& value : reproduction.values) {
    ordered_json entry = {{"label", value.label}, {"unit", value.unit}};
    put(entry, "ours", value.ours);
    if (value.paper) entry["paper"] = *value.paper;
    json["values"].push_back(std::move(entry));
  }
  json["plots"] = ordered_json::array();
  for (const Reproduction::Plot& plot : reproduction.plots) json["plots"].push_back(plot_json(plot));
  json["trends"] = ordered_json::array();
  for (const Reproduction::Trend& trend : reproduction.trends) {
    json["trends"].push_back({{"claim", trend.claim},
                              {"expression", trend.expression},
                              {"verdict", trend.verdict},
                              {"unlike_machines", trend.unlike_machines}});
  }
  return json;
}

void add_conclusions(ordered_json& json, const ComparisonResult& result) {
  json["summaries"] = ordered_json::array();
  for (const auto& [key, summary] : result.summaries) json["summaries"].push_back(summary_json(key, summary));
  json["pairs"] = ordered_json::array();
  for (const SummaryPair& pair : make_pairs(result)) {
    json["pairs"].push_back({{"scene", pair.scene},
                             {"budget", pair.budget},
                             {"a", pair.a},
                             {"b", pair.b},
                             {"metric", pair.metric},
                             {"ratio", mean_json(pair.ratio)},
                             {"different", pair.different()}});
  }
  json["winners"] = ordered_json::array();
  for (const Winner& winner : find_winners(result)) {
    json["winners"].push_back({{"scene", winner.scene},
                               {"budget", winner.budget},
                               {"best", winner.best},
                               {"next", winner.next},
                               {"metric", winner.metric},
                               {"ratio", mean_json(winner.ratio)},
                               {"different", winner.difference_shown()},
                               {"resolved", winner.resolved}});
  }
  json["gates"] = ordered_json::array();
  for (const GateResult& gate : result.gates) {
    ordered_json entry = {{"gate", gate.gate},     {"scene", gate.scene},   {"variant", gate.variant},
                          {"budget", gate.budget}, {"passed", gate.passed}, {"unlike_machines", gate.unlike_machines}};
    put(entry, "value", gate.value);
    json["gates"].push_back(std::move(entry));
  }
  if (result.baseline) json["baseline"] = baseline_json(*result.baseline);
  if (result.reproduction) json["reproduction"] = reproduction_json(*result.reproduction);
}

}  // namespace

std::string ComparisonResult::to_json() const {
  ordered_json json = {{"schema", "lucarium-results-2"},
                       {"version", version},
                       {"device", device},
                       {"driver", driver},
                       {"started", started},
                       {"interrupted", interrupted}};
  json["machine"] = machine_json(machine);
  json["comparison"] = ordered_json::parse(spec.to_json());
  json["variants"] = ordered_json::array();
  for (size_t i = 0; i < spec.variants.size(); ++i)
    json["variants"].push_back(variant_json(spec.variants[i], variants.at(i)));
  json["budgets"] = ordered_json::array();
  for (const ComparisonBudget& budget : spec.budgets) json["budgets"].push_back(budget_json(budget));
  json["metrics"] = ordered_json::array();
  for (const Metric& metric : metric_table()) {
    json["metrics"].push_back({{"name", metric.name},
                               {"formula", metric.formula},
                               {"unit", metric.unit},
                               {"better", metric.lower_is_better ? "lower" : "higher"}});
  }
  json["scenes"] = ordered_json::array();
  for (const SceneResult& scene : scenes) json["scenes"].push_back(scene_json(scene));
  json["pieces"] = ordered_json::array();
  for (const PieceResult& piece : pieces) json["pieces"].push_back(piece_json(piece));
  add_conclusions(json, *this);
  return json.dump(1) + "\n";
}

}  // namespace lucarium
