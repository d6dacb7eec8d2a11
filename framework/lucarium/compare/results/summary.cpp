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

using Curves = std::vector<std::vector<CurvePoint>>;  // of the seeds

Curves curves_of(const std::vector<const PieceResult*>& pieces, std::vector<CurvePoint> (*curve)(const PieceResult&)) {
  Curves curves;
  for (const PieceResult* piece : pieces) curves.push_back(curve(*piece));
  return curves;
}

/// The curves' mean at the times of the first one, which is that of `first`; the others are interpolated.
std::vector<SummaryPoint> mean_curve(const Curves& curves, const PieceResult& first) {
  std::vector<SummaryPoint> points;
  for (size_t i = 0; i < curves.front().size(); ++i) {
    const CurvePoint& point = curves.front()[i];
    std::vector<double> errors = {point.error};
    for (size_t other = 1; other < curves.size(); ++other) {
      const double error = error_at_time(curves[other], point.time);
      if (std::isfinite(error)) errors.push_back(error);
    }
    points.push_back({point.time, static_cast<double>(first.snapshots[i].samples), seed_geometric_mean(errors)});
  }
  return points;
}

/// Mean of what every piece has.
std::optional<ConfidenceInterval> mean_of_all(const std::vector<const PieceResult*>& pieces,
                                              std::optional<double> PieceResult::*value) {
  std::vector<double> values;
  for (const PieceResult* piece : pieces) {
    if (!(piece->*value)) return std::nullopt;
    values.push_back(*(piece->*value));
  }
  return seed_geometric_mean(values);
}

std::optional<double> mean_processor_seconds(const std::vector<const PieceResult*>& pieces) {
  double sum = 0;
  for (const PieceResult* piece : pieces) {
    if (!piece->processor_seconds) return std::nullopt;
    sum += *piece->processor_seconds;
  }
  return sum / static_cast<double>(pieces.size());
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

SummaryTime time_of(const Curves& curves, double relmse) {
  SummaryTime result;
  result.relmse = relmse;
  std::vector<double> seconds;
  for (const std::vector<CurvePoint>& curve : curves) {
    const TimeToError reached = time_to_error(curve, relmse);
    if (reached.state == TimeToError::State::not_reached) return result;
    result.at_most |= reached.state == TimeToError::State::before_first;
    seconds.push_back(reached.time);
  }
  result.seconds = seed_geometric_mean(seconds);
  return result;
}

/// Of a budget of time, the errors of unlike machines say which machine is faster, too.
bool is_ranked(const ComparisonResult& result, size_t scene, size_t budget) {
  return !result.scenes[scene].unlike_machines || result.spec.budgets[budget].seconds <= 0;
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
  const Curves curves = curves_of(pieces, curve_of);
  summary.curve = mean_curve(curves, *pieces.front());
  summary.slope = seed_slope(curves);
  summary.processor_seconds = mean_processor_seconds(pieces);
  if (summary.processor_seconds)
    summary.processor_curve = mean_curve(curves_of(pieces, processor_curve_of), *pieces.front());
  summary.walk = walk_of(pieces);
  if (budget.relmse > 0) {
    summary.reached_seconds = mean_of_all(pieces, &PieceResult::reached_seconds);
    summary.reached_processor_seconds = mean_of_all(pieces, &PieceResult::reached_processor_seconds);
  }
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
    summary.processor_times.clear();
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
  const bool like = !result.scenes[scene].unlike_machines;
  for (auto& [key, pieces] : groups) {
    Summary& summary = summaries[key];
    const Curves curves = curves_of(pieces, curve_of), processor_curves = curves_of(pieces, processor_curve_of);
    for (const double error : errors) {
      if (like) summary.times.push_back(time_of(curves, error));
      if (summary.processor_seconds) summary.processor_times.push_back(time_of(processor_curves, error));
    }
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
          if (!is_ranked(result, scene, budget)) continue;
          if (result.spec.budgets[budget].relmse > 0) {
            if (!result.scenes[scene].unlike_machines)
              add(scene, budget, a, b, "seconds", [](const PieceResult& piece) { return piece.reached_seconds; });
            add(scene, budget, a, b, "processor_seconds",
                [](const PieceResult& piece) { return piece.reached_processor_seconds; });
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
