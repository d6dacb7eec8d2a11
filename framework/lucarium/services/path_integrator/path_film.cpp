// SPDX-License-Identifier: Apache-2.0
// What PathIntegrator writes into a film. Declared in path_integrator.h.
#include <array>
#include <memory>

#include "lucarium/base/error.h"
#include "lucarium/services/path_integrator/path_integrator_state.h"

namespace lucarium {
namespace {

/// Mean of compensated sums: pixels × 2 float4, the sum and what rounding lost.
void write_mean(const float4* sums, size_t pixels, uint64_t samples, std::vector<float>& target) {
  const double scale = samples > 0 ? 1.0 / static_cast<double>(samples) : 0.0;
  for (size_t p = 0; p < pixels; ++p) {
    const float4 &sum = sums[2 * p], &lost = sums[2 * p + 1];
    target[3 * p] = static_cast<float>((double{sum.x} + lost.x) * scale);
    target[3 * p + 1] = static_cast<float>((double{sum.y} + lost.y) * scale);
    target[3 * p + 2] = static_cast<float>((double{sum.z} + lost.z) * scale);
  }
}

}  // namespace

std::vector<std::vector<float>> PathIntegrator::replicate_images() const {
  const State& s = *state_;
  s.scheduler.finish();
  std::vector<std::vector<float>> images;
  for (uint32_t r = 0; r < s.sums.replicates.size(); ++r) {
    // Sample n belongs to replicate n mod R.
    const uint64_t samples = s.samples / s.options.replicates + (r < s.samples % s.options.replicates ? 1 : 0);
    images.emplace_back(size_t{s.plan.pixels} * 3);
    write_mean(s.sums.replicates[r].elements().get(), s.plan.pixels, samples, images.back());
  }
  return images;
}

void PathIntegrator::resolve(Film& film) const {
  const State& s = *state_;
  if (film.pixel_count() != s.plan.pixels)
    throw Error(ErrorClass::internal, "the film has another size than the frame");
  s.scheduler.finish();
  const std::array<const char*, LUCARIUM_PATH_LAYERS> names = {"emission", "direct", "indirect"};
  const size_t stride = size_t{s.plan.pixels} * 2;
  const std::shared_ptr<const float4[]> sums = s.sums.layers.elements();
  for (size_t layer = 0; layer < names.size(); ++layer) {
    FilmLayer& target = film.layer(names[layer], {"R", "G", "B"}, true);
    target.pixels.resize(size_t{s.plan.pixels} * 3);
    write_mean(sums.get() + layer * stride, s.plan.pixels, s.samples, target.pixels);
  }
  if (s.options.replicates < 2 || s.samples < s.options.replicates) return;

  // Variance of the mean of R independent replicates: s² / R.
  const std::vector<std::vector<float>> images = replicate_images();
  const double count = static_cast<double>(images.size());
  FilmLayer& variance = film.layer("Variance");
  variance.pixels.assign(size_t{s.plan.pixels} * 3, 0.f);
  for (size_t i = 0; i < variance.pixels.size(); ++i) {
    double mean = 0, squares = 0;
    for (const auto& image : images) mean += image[i] / count;
    for (const auto& image : images) squares += (image[i] - mean) * (image[i] - mean);
    variance.pixels[i] = static_cast<float>(squares / (count - 1) / count);
  }
  film.metadata["variance_dof"] = std::to_string(images.size() - 1);  // degrees of freedom
}

}  // namespace lucarium
