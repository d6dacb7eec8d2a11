// SPDX-License-Identifier: Apache-2.0
#include "lucarium/compare/results/gate.h"

#include <charconv>
#include <cmath>

#include "lucarium/base/error.h"
#include "lucarium/base/text/nearest_name.h"
#include "lucarium/compare/results/comparison_result.h"
#include "lucarium/metrics/metrics.h"

namespace lucarium {
namespace {

const std::vector<std::pair<std::string, double (*)(const Summary&)>>& resource_values() {
  static const std::vector<std::pair<std::string, double (*)(const Summary&)>> values = {
      {"seconds",
       [](const Summary& s) {
         return s.reached_seconds ? s.reached_seconds->mean : s.prepare_seconds + s.iterate_seconds;
       }},
      {"prepare_seconds", [](const Summary& s) { return s.prepare_seconds; }},
      {"peak_host_bytes", [](const Summary& s) { return static_cast<double>(s.peak_host_bytes); }},
      {"peak_device_bytes", [](const Summary& s) { return static_cast<double>(s.peak_device_bytes); }}};
  return values;
}

std::string resolve_metric(const std::string& name, const std::string& text) {
  std::vector<std::string> known;
  for (const auto& [resource, value] : resource_values()) {
    if (resource == name) return name;
    known.push_back(resource);
  }
  for (const Metric& metric : metric_table()) known.push_back(metric.name);
  try {
    return find_metric(name).name;
  } catch (const Error&) {
    throw_error(ErrorClass::usage, "--gate {}: no metric is called '{}'{}", text, name, suggest_name(name, known));
  }
}

bool is_wall_time(const std::string& metric) { return metric == "seconds" || metric == "prepare_seconds"; }

double value_of(const Summary& summary, const std::string& metric) {
  for (const auto& [resource, value] : resource_values()) {
    if (resource == metric) return summary.seeds > 0 ? value(summary) : NAN;
  }
  const auto found = summary.metrics.find(metric);
  return found == summary.metrics.end() ? NAN : found->second.mean;
}

}  // namespace

Gate parse_gate(const std::string& text) {
  const size_t sign = text.find_last_of("<>");
  Gate gate;
  gate.text = text;
  if (sign != std::string::npos) {
    const std::string left = text.substr(0, sign), right = text.substr(sign + 1);
    const size_t colon = left.rfind(':');
    const std::string metric = colon == std::string::npos ? left : left.substr(colon + 1);
    const auto [end, failure] = std::from_chars(right.data(), right.data() + right.size(), gate.bar);
    const bool number = failure == std::errc() && end == right.data() + right.size() && std::isfinite(gate.bar);
    if (number && !metric.empty()) {
      gate.variant = colon == std::string::npos ? "" : left.substr(0, colon);
      gate.metric = resolve_metric(metric, text);
      gate.below = text[sign] == '<';
      return gate;
    }
  }
  throw_error(ErrorClass::usage, "--gate {} is not METRIC<VALUE, METRIC>VALUE or LABEL:METRIC<VALUE", text);
}

std::vector<GateResult> apply_gates(const std::vector<Gate>& gates, const ComparisonResult& result) {
  std::vector<GateResult> results;
  for (const Gate& gate : gates) {
    bool known = gate.variant.empty();
    for (size_t variant = 0; variant < result.spec.variants.size(); ++variant) {
      if (!gate.variant.empty() && gate.variant != result.spec.variants[variant].label()) continue;
      known = true;
      for (size_t scene = 0; scene < result.scenes.size(); ++scene) {
        for (size_t budget = 0; budget < result.spec.budgets.size(); ++budget) {
          const auto found = result.summaries.find({scene, variant, budget});
          GateResult entry{gate.text, scene, variant, budget, NAN, false};
          // What a machine reaches in a time is its own; the memory that it takes is not.
          const bool by_time = is_wall_time(gate.metric) ||
                               (result.spec.budgets[budget].seconds > 0 && !gate.metric.starts_with("peak_"));
          entry.unlike_machines = result.scenes[scene].unlike_machines && by_time;
          if (found != result.summaries.end() && !entry.unlike_machines)
            entry.value = value_of(found->second, gate.metric);
          entry.passed = gate.below ? entry.value < gate.bar : entry.value > gate.bar;  // NaN passes neither
          results.push_back(entry);
        }
      }
    }
    if (!known) throw_error(ErrorClass::usage, "--gate {}: no technique has the label '{}'", gate.text, gate.variant);
  }
  return results;
}

}  // namespace lucarium
