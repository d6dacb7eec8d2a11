// SPDX-License-Identifier: Apache-2.0
#include "lucarium/compare/results/image_pairs.h"

#include <cmath>

#include "lucarium/compare/results/comparison_result.h"
#include "lucarium/compare/results/summary.h"
#include "lucarium/film/image_io.h"
#include "lucarium/metrics/metrics.h"

namespace lucarium {

namespace {

/// Three floats per pixel; null where the film has no such layer.
const std::vector<float>* layer_colors(const Film& film, const std::string& name) {
  for (const FilmLayer& layer : film.layers()) {
    if (layer.name == name && layer.pixels.size() == 3 * film.pixel_count()) return &layer.pixels;
  }
  return nullptr;
}

}  // namespace

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

const ImagePairs::Errors& ImagePairs::measure_layer_pair(const std::string& test, const std::string& reference,
                                                         const std::string& layer, float exposure) {
  const auto [found, is_new] = known_.try_emplace({test + ":" + layer, reference});
  if (!is_new) return found->second;
  const Film x = read_image(folder_ / test), r = read_image(folder_ / reference);
  const std::vector<float>*image = layer_colors(x, layer), *wanted = layer_colors(r, layer);
  if (!image || !wanted) return found->second;
  const ImageMetrics metrics = compute_metrics(r.width(), r.height(), *image, *wanted, exposure);
  for (const Metric& metric : metric_table()) found->second[metric.name] = metrics.*metric.value;
  return found->second;
}

std::map<std::string, double> ImagePairs::measure_layer(const ComparisonResult& result, const SummaryKey& test,
                                                        const std::string& layer) {
  const auto& [scene, variant, budget] = test;
  const SceneResult& entry = result.scenes.at(scene);
  const ReferenceResult& reference = entry.references.at(entry.variants.at(variant).reference);
  const std::vector<const PieceResult*> pieces = pieces_of(result, test);
  Errors means;
  for (const PieceResult* piece : pieces) {
    const Errors& errors = measure_layer_pair(piece->image, reference.image, layer, entry.exposure);
    if (errors.empty()) return {};
    for (const auto& [name, error] : errors) means[name] += error / static_cast<double>(pieces.size());
  }
  return means;
}

}  // namespace lucarium
