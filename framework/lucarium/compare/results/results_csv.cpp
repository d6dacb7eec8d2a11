// SPDX-License-Identifier: Apache-2.0
// results.csv and curves.csv: one line per piece, and one per snapshot. Declared in comparison_result.h.
#include "lucarium/base/error.h"
#include "lucarium/compare/results/comparison_result.h"
#include "lucarium/metrics/metrics.h"

namespace lucarium {
namespace {

std::string csv_field(const std::string& text) {
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + "\"";
}

/// What a line begins with: the names of scene, variant and budget, and the seed.
std::string piece_name(const ComparisonResult& result, const PieceResult& piece) {
  return fmt::format("{},{},{},{}", csv_field(result.scenes.at(piece.scene).name),
                     csv_field(result.spec.variants.at(piece.variant).label()),
                     csv_field(result.spec.budgets.at(piece.budget).label()), piece.seed);
}

std::string metric_names() {
  std::string names;
  for (const Metric& metric : metric_table()) names += "," + metric.name;
  return names;
}

std::string optional_value(const std::optional<double>& value) { return value ? fmt::format("{}", *value) : ""; }

/// Empty where there was no walk, or no reference.
std::string walk_values(const std::optional<WalkTimes>& walk) {
  if (!walk) return ",,,";
  return fmt::format("{},{},{},{}", walk->min_seconds, walk->median_seconds, walk->max_seconds,
                     optional_value(walk->relmse));
}

/// Values in the order of metric_table(); empty where there is none.
std::string metric_values(const std::map<std::string, double>& metrics) {
  std::string values;
  for (const Metric& metric : metric_table()) {
    const auto found = metrics.find(metric.name);
    values += found == metrics.end() ? "," : fmt::format(",{}", found->second);
  }
  return values;
}

}  // namespace

std::string ComparisonResult::pieces_csv() const {
  std::string csv =
      "scene,variant,budget,seed,iterations,samples,iterate_seconds,device_seconds,processor_seconds,load_seconds,"
      "prepare_seconds,"
      "compile_seconds,peak_host_bytes,peak_device_bytes,reached_seconds,"
      "walk_min_seconds,walk_median_seconds,walk_max_seconds,walk_relmse,failure" +
      metric_names() + "\n";
  for (const PieceResult& piece : pieces) {
    csv +=
        fmt::format("{},{},{},{},{},{},{},{},{},{},{},{},{},{}{}\n", piece_name(*this, piece), piece.iterations,
                    piece.samples, piece.iterate_seconds, piece.device_seconds, optional_value(piece.processor_seconds),
                    piece.load_seconds, piece.prepare_seconds, piece.compile_seconds, piece.peak_host_bytes,
                    piece.peak_device_bytes, optional_value(piece.reached_seconds), walk_values(piece.walk),
                    csv_field(piece.failure), metric_values(piece.metrics));
  }
  return csv;
}

std::string ComparisonResult::snapshots_csv() const {
  std::string csv = "scene,variant,budget,seed,seconds,processor_seconds,iterations,samples" + metric_names() + "\n";
  for (const PieceResult& piece : pieces) {
    for (const Snapshot& snapshot : piece.snapshots) {
      csv += fmt::format("{},{},{},{},{}{}\n", piece_name(*this, piece), snapshot.seconds,
                         optional_value(snapshot.processor_seconds), snapshot.iterations, snapshot.samples,
                         metric_values(snapshot.metrics));
    }
  }
  return csv;
}

}  // namespace lucarium
