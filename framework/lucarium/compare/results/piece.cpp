// SPDX-License-Identifier: Apache-2.0
#include "lucarium/compare/results/piece.h"

#include <algorithm>

#include "lucarium/base/error.h"
#include "lucarium/base/json.h"

namespace lucarium {

using nlohmann::json;

namespace {

std::map<std::string, double> read_metrics(const json& object) {
  std::map<std::string, double> metrics;
  for (const auto& [name, value] : object.items()) metrics[name] = value.get<double>();
  return metrics;
}

std::optional<double> read_processor_seconds(const json& object) {
  const auto found = object.find("processor_seconds");
  return found == object.end() ? std::nullopt : std::optional(found->get<double>());
}

void read_clocks(PieceResult& piece, const json& clocks) {
  piece.load_seconds = clocks.at("load_seconds");
  piece.prepare_seconds = clocks.at("upload_seconds").get<double>() + clocks.at("bvh_seconds").get<double>() +
                          clocks.at("prepare_seconds").get<double>();
  piece.compile_seconds = clocks.at("compile_seconds").get<double>() + clocks.at("warm_up_seconds").get<double>();
  piece.iterate_seconds = clocks.at("iterate_seconds");
  piece.processor_seconds = read_processor_seconds(clocks);
}

WalkTimes read_walk(const json& walk) {
  std::vector<double> seconds = walk.at("frame_seconds");
  std::sort(seconds.begin(), seconds.end());
  if (seconds.empty()) throw_error(ErrorClass::input, "its walk has no frames");
  const size_t middle = seconds.size() / 2;
  const double median = seconds.size() % 2 ? seconds[middle] : 0.5 * (seconds[middle - 1] + seconds[middle]);
  WalkTimes times{seconds.front(), median, seconds.back(), {}};
  const json& errors = walk.at("relmse");
  if (errors.empty()) return times;
  double sum = 0;
  for (const json& error : errors) sum += error.at("relmse").get<double>();
  times.relmse = sum / static_cast<double>(errors.size());
  return times;
}

/// When the curve got to the error; the first snapshot's time bounds it where that was enough.
std::optional<double> find_reached(const std::vector<CurvePoint>& curve, double relmse) {
  const TimeToError reached = time_to_error(curve, relmse);
  if (reached.state == TimeToError::State::not_reached) return std::nullopt;
  return reached.time;
}

}  // namespace

std::vector<CurvePoint> curve_of(const PieceResult& piece) {
  std::vector<CurvePoint> curve;
  for (const Snapshot& snapshot : piece.snapshots) curve.push_back({snapshot.seconds, snapshot.metrics.at("relMSE")});
  return curve;
}

std::vector<CurvePoint> processor_curve_of(const PieceResult& piece) {
  std::vector<CurvePoint> curve;
  for (const Snapshot& snapshot : piece.snapshots) {
    if (!snapshot.processor_seconds) return {};
    curve.push_back({*snapshot.processor_seconds, snapshot.metrics.at("relMSE")});
  }
  return curve;
}

RenderWork work_within(const ComparisonBudget& budget) {
  RenderWork work;
  work.seconds = budget.seconds > 0 ? budget.seconds : budget.limit_seconds;
  work.iterations = budget.iterations;
  work.samples = budget.samples;
  work.relmse = budget.relmse;
  work.curve = budget.relmse <= 0;
  return work;
}

std::string piece_stem(size_t scene, size_t variant, size_t budget, uint32_t seed) {
  return fmt::format("pieces/scene{}-variant{}-budget{}-seed{}", scene + 1, variant + 1, budget + 1, seed);
}

std::string mean_file(const PieceResult& piece) {
  return fmt::format("means/scene{}-variant{}-budget{}.exr", piece.scene + 1, piece.variant + 1, piece.budget + 1);
}

void read_summary(PieceResult& piece, const ComparisonBudget& budget) {
  try {
    const json summary = json::parse(piece.render_summary);
    read_clocks(piece, summary.at("clocks"));
    piece.parameters = summary.at("parameters");
    piece.samples = summary.at("samples");
    piece.iterations = summary.at("iterations");
    piece.converged = summary.at("converged");
    piece.peak_host_bytes = summary.at("peak_host_bytes");
    piece.peak_device_bytes = summary.at("peak_device_memory_bytes");
    piece.device_seconds = 0;
    for (const json& pass : summary.at("passes")) piece.device_seconds += pass.at("device_seconds").get<double>();
    piece.metrics = read_metrics(summary.at("metrics"));
    piece.snapshots.clear();
    for (const json& snapshot : summary.at("snapshots")) {
      piece.snapshots.push_back({snapshot.at("seconds"), snapshot.at("iterations"), snapshot.at("samples"),
                                 read_metrics(snapshot.at("metrics")), read_processor_seconds(snapshot)});
    }
    if (summary.contains("walk")) piece.walk = read_walk(summary["walk"]);
    piece.device = summary.value("device", "") + ", " + summary.value("driver", "");
    if (summary.contains("machine")) piece.machine = read_piece_machine(summary["machine"]);
    if (budget.relmse > 0) {
      piece.reached_seconds = find_reached(curve_of(piece), budget.relmse);
      piece.reached_processor_seconds = find_reached(processor_curve_of(piece), budget.relmse);
    }
  } catch (const json::exception& error) {
    throw_error(ErrorClass::input, "its summary cannot be read: {}", error.what());
  }
}

}  // namespace lucarium
