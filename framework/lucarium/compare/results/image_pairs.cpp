// SPDX-License-Identifier: Apache-2.0
#include "lucarium/compare/results/image_pairs.h"

#include <cmath>

#include "lucarium/compare/results/comparison_result.h"
#include "lucarium/compare/results/summary.h"
#include "lucarium/film/image_io.h"
#include "lucarium/metrics/metrics.h"

namespace lucarium {

double differing_pixels(const std::vector<float>& test, const std::vector<float>& reference) {
  const double floor = 0.01 * mean_luminance(reference);
  size_t different = 0;
  for (size_t pixel = 0; pixel + 2 < reference.size(); pixel += 3) {
    bool same = true;
    for (size_t i = pixel; i < pixel + 3; ++i) {
      const double x = test[i], r = reference[i];
      same = same && std::fabs(x - r) <= 0.01 * (std::fabs(r) + floor);
    }
    different += !same;
  }
  return 3.0 * static_cast<double>(different) / static_cast<double>(reference.size());
}

const ImagePairs::Errors& ImagePairs::measure_pair(const std::string& test, const std::string& reference,
                                                   float exposure) {
  const auto [found, is_new] = known_.try_emplace({test, reference});
  if (!is_new) return found->second;
  const Film x = read_image(folder_ / test), r = read_image(folder_ / reference);
  const std::vector<float> image = x.image(), wanted = r.image();
  const ImageMetrics metrics = compute_metrics(r.width(), r.height(), image, wanted, exposure);
  for (const Metric& metric : metric_table()) found->second[metric.name] = metrics.*metric.value;
  found->second["differing_pixels"] = differing_pixels(image, wanted);
  return found->second;
}

std::map<std::string, double> ImagePairs::measure(const ComparisonResult& result, const SummaryKey& test,
                                                  const SummaryKey& reference) {
  Errors sums;
  size_t pairs = 0;
  for (const PieceResult* x : pieces_of(result, test)) {
    for (const PieceResult* r : pieces_of(result, reference)) {
      if (x->seed != r->seed) continue;
      ++pairs;
      for (const auto& [name, error] : measure_pair(x->image, r->image, result.scenes[x->scene].exposure))
        sums[name] += error;
    }
  }
  for (auto& [name, sum] : sums) sum /= static_cast<double>(pairs);
  return sums;
}

}  // namespace lucarium
