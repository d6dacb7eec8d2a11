// SPDX-License-Identifier: Apache-2.0
#include "lucarium/compare/results/summary.h"

#include <algorithm>
#include <cmath>

#include "lucarium/base/error.h"
#include "lucarium/compare/results/error_curve.h"
#include "lucarium/compare/results/piece.h"
#include "lucarium/film/image_io.h"

namespace lucarium {
namespace fs = std::filesystem;

namespace {

constexpr size_t max_errors = 6;
const char* const error_metric = "relMSE";

std::vector<double> collect(const std::vector<const PieceResult*>& pieces, double (*value)(const PieceResult&)) {
  std::vector<double> values;
  for (const PieceResult* piece : pieces) values.push_back(value(*piece));
  return values;
}

double average(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

/// Errors spread by factors; decibels and similarities do not, and may be negative.
bool is_arithmetic(const std::string& metric) { return metric == "PSNR" || metric == "SSIM"; }

/// Means of the metrics that every piece has.
std::map<std::string, ConfidenceInterval> mean_metrics(const std::vector<const PieceResult*>& pieces) {
  std::map<std::string, ConfidenceInterval> means;
  for (const auto& [name, unused] : pieces.front()->metrics) {
    std::vector<double> values;
    for (const PieceResult* piece : pieces) {
      if (const auto found = piece->metrics.find(name); found != piece->metrics.end()) values.push_back(found->second);
    }
    if (values.size() == pieces.size())
      means[name] = is_arithmetic(name) ? seed_mean(values) : seed_geometric_mean(values);
  }
  return means;
}

std::vector<CurvePoint> curve_of(const PieceResult& piece) {
  std::vector<CurvePoint> curve;
  for (const Snapshot& snapshot : piece.snapshots)
    curve.push_back({snapshot.seconds, snapshot.metrics.at(error_metric)});
  return curve;
}

/// The curves' mean at the times of the first one; the others are interpolated.
std::vector<SummaryPoint> mean_curve(const std::vector<const PieceResult*>& pieces) {
  std::vector<SummaryPoint> points;
  for (const Snapshot& snapshot : pieces.front()->snapshots) {
    std::vector<double> errors = {snapshot.metrics.at(error_metric)};
    for (size_t i = 1; i < pieces.size(); ++i) {
      const double error = error_at_time(curve_of(*pieces[i]), snapshot.seconds);
      if (std::isfinite(error)) errors.push_back(error);
    }
    points.push_back({snapshot.seconds, static_cast<double>(snapshot.samples), seed_geometric_mean(errors)});
  }
  return points;
}

std::optional<ConfidenceInterval> mean_reached(const std::vector<const PieceResult*>& pieces) {
  std::vector<double> seconds;
  for (const PieceResult* piece : pieces) {
    if (!piece->reached_seconds) return std::nullopt;
    seconds.push_back(*piece->reached_seconds);
  }
  return seed_geometric_mean(seconds);
}

std::optional<WalkTimes> walk_of(const std::vector<const PieceResult*>& pieces) {
  WalkTimes all{INFINITY, 0, 0, {}};
  std::vector<double> errors;
  for (const PieceResult* piece : pieces) {
    if (!piece->walk) return std::nullopt;
    all.min_seconds = std::min(all.min_seconds, piece->walk->min_seconds);
    all.median_seconds += piece->walk->median_seconds / static_cast<double>(pieces.size());
    all.max_seconds = std::max(all.max_seconds, piece->walk->max_seconds);
    if (piece->walk->relmse) errors.push_back(*piece->walk->relmse);
  }
  if (errors.size() == pieces.size()) all.relmse = seed_geometric_mean(errors).mean;
  return all;
}

SummaryTime time_of(const std::vector<const PieceResult*>& pieces, double relmse) {
  SummaryTime result;
  result.relmse = relmse;
  std::vector<double> seconds;
  for (const PieceResult* piece : pieces) {
    const TimeToError reached = time_to_error(curve_of(*piece), relmse);
    if (reached.state == TimeToError::State::not_reached) return result;
    result.at_most |= reached.state == TimeToError::State::before_first;
    seconds.push_back(reached.time);
  }
  result.seconds = seed_geometric_mean(seconds);
  return result;
}

}  // namespace

std::vector<const PieceResult*> pieces_of(const ComparisonResult& result, const SummaryKey& key) {
  std::vector<const PieceResult*> pieces;
  for (const PieceResult& piece : result.pieces) {
    if (piece.failure.empty() && SummaryKey{piece.scene, piece.variant, piece.budget} == key) pieces.push_back(&piece);
  }
  std::sort(pieces.begin(), pieces.end(), [](const PieceResult* a, const PieceResult* b) { return a->seed < b->seed; });
  return pieces;
}

Summary summarize(const std::vector<const PieceResult*>& pieces, const ReferenceResult& reference,
                  const ComparisonBudget& budget) {
  Summary summary;
  summary.seeds = pieces.size();
  if (pieces.empty()) return summary;
  summary.metrics = mean_metrics(pieces);
  summary.iterate_seconds = average(collect(pieces, [](const PieceResult& p) { return p.iterate_seconds; }));
  summary.prepare_seconds = average(collect(pieces, [](const PieceResult& p) { return p.prepare_seconds; }));
  summary.compile_seconds = average(collect(pieces, [](const PieceResult& p) { return p.compile_seconds; }));
  summary.device_seconds = average(collect(pieces, [](const PieceResult& p) { return p.device_seconds; }));
  summary.samples = average(collect(pieces, [](const PieceResult& p) { return static_cast<double>(p.samples); }));
  for (const PieceResult* piece : pieces) {
    summary.peak_host_bytes = std::max(summary.peak_host_bytes, piece->peak_host_bytes);
    summary.peak_device_bytes = std::max(summary.peak_device_bytes, piece->peak_device_bytes);
  }
  const double mse = average(collect(pieces, [](const PieceResult& p) { return p.metrics.at("MSE"); }));
  summary.debiased_mse = debiased_error(mse, reference.mse).value;
  summary.resolved = debiased_error(summary.metrics.at(error_metric).mean, reference.relmse).resolved;
  summary.curve = mean_curve(pieces);
  std::vector<std::vector<CurvePoint>> curves;
  for (const PieceResult* piece : pieces) curves.push_back(curve_of(*piece));
  summary.slope = seed_slope(curves);
  summary.walk = walk_of(pieces);
  if (budget.relmse > 0) summary.reached_seconds = mean_reached(pieces);
  return summary;
}

BiasAndVariance measure_bias(const std::vector<const PieceResult*>& pieces, const ReferenceResult& reference,
                             const fs::path& folder) {
  std::vector<std::vector<float>> images;
  Film mean = read_image(folder / pieces.front()->image);
  for (const PieceResult* piece : pieces) images.push_back(read_image(folder / piece->image).image());
  Film film(mean.width(), mean.height());
  FilmLayer& layer = film.layer("mean", {"R", "G", "B"}, true);
  for (size_t i = 0; i < layer.pixels.size(); ++i) {
    double sum = 0;
    for (const std::vector<float>& image : images) sum += image[i];
    layer.pixels[i] = static_cast<float>(sum / static_cast<double>(images.size()));
  }
  film.metadata = {{"seeds", std::to_string(images.size())}};
  write_exr(folder / mean_file(*pieces.front()), film);
  const SeedImages reduced =
      reduce_seed_images(images, read_image(folder / reference.image).image(), ErrorScale::absolute);
  return split_error(reduced, reference.mse);
}

bool mark_unlike_machines(ComparisonResult& result, size_t scene) {
  const PieceResult* first = nullptr;
  bool unlike = false;
  for (const PieceResult& piece : result.pieces) {
    if (piece.scene != scene || !piece.failure.empty() || !piece.machine) continue;
    if (!first) first = &piece;
    const Machine &a = first->machine->machine, &b = piece.machine->machine;
    unlike |= piece.device != first->device || a.cpu != b.cpu || a.logical_cores != b.logical_cores;
  }
  result.scenes[scene].unlike_machines = unlike;
  return unlike;
}

void add_times_to_error(const ComparisonResult& result, size_t scene, size_t budget,
                        std::map<SummaryKey, Summary>& summaries) {
  double largest = 0, smallest = INFINITY;
  std::map<SummaryKey, std::vector<const PieceResult*>> groups;
  for (auto& [key, summary] : summaries) {
    if (std::get<0>(key) != scene || std::get<2>(key) != budget || summary.seeds == 0) continue;
    summary.times.clear();
    if (result.scenes[scene].unlike_machines) continue;
    groups[key] = pieces_of(result, key);
    for (const SummaryPoint& point : summary.curve) {
      largest = std::max(largest, point.relmse.mean);
      if (point.relmse.mean > 0) smallest = std::min(smallest, point.relmse.mean);
    }
  }
  if (!(smallest < largest)) return;
  std::vector<double> errors;
  for (int exponent = static_cast<int>(std::floor(std::log10(smallest))); errors.size() < max_errors; ++exponent) {
    for (const double mantissa : {1.0, 3.0}) {
      const double error = mantissa * std::pow(10.0, exponent);
      if (error >= smallest && error < largest && errors.size() < max_errors) errors.push_back(error);
    }
    if (std::pow(10.0, exponent) > largest) break;
  }
  for (auto& [key, pieces] : groups) {
    summaries[key].times.clear();
    for (const double error : errors) summaries[key].times.push_back(time_of(pieces, error));
  }
}

std::vector<SummaryPair> make_pairs(const ComparisonResult& result) {
  std::vector<SummaryPair> pairs;
  const auto add = [&](size_t scene, size_t budget, size_t a, size_t b, const char* metric, auto&& value) {
    const auto first = pieces_of(result, {scene, a, budget}), second = pieces_of(result, {scene, b, budget});
    std::vector<double> left, right;
    for (const PieceResult* one : first) {
      for (const PieceResult* two : second) {
        if (one->seed != two->seed || !value(*one) || !value(*two)) continue;
        left.push_back(*value(*one));
        right.push_back(*value(*two));
      }
    }
    if (!left.empty()) pairs.push_back({scene, budget, a, b, metric, paired_ratio(left, right)});
  };
  for (size_t scene = 0; scene < result.scenes.size(); ++scene) {
    for (size_t budget = 0; budget < result.spec.budgets.size(); ++budget) {
      for (size_t a = 0; a < result.spec.variants.size(); ++a) {
        for (size_t b = a + 1; b < result.spec.variants.size(); ++b) {
          if (result.spec.budgets[budget].relmse > 0) {
            add(scene, budget, a, b, "seconds", [](const PieceResult& piece) { return piece.reached_seconds; });
            continue;
          }
          for (const char* metric : {"relMSE", "HDR_FLIP"}) {
            add(scene, budget, a, b, metric, [metric](const PieceResult& piece) -> std::optional<double> {
              const auto found = piece.metrics.find(metric);
              return found == piece.metrics.end() ? std::nullopt : std::optional(found->second);
            });
          }
        }
      }
    }
  }
  return pairs;
}

}  // namespace lucarium
