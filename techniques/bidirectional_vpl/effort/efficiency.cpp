// SPDX-License-Identifier: Apache-2.0
#include "bidirectional_vpl/effort/efficiency.h"

#include <algorithm>
#include <cmath>

#include "lucarium/base/luminance.h"

namespace lucarium::bidirectional {

namespace {

// Times of events over that of a shadow ray, geometric means over four scenes on two cores with AVX2
// (docs/measurements/bidirectional_vpl.md): a camera path's vertex with its closest hit, a connection, each of its
// candidates, a light path's vertex, a splat, a path.
constexpr double kVertex = 4.6, kConnection = 5.3, kCandidate = 0.046, kLightPathVertex = 4.6, kSplat = 8.3,
                 kPath = 1.5;

constexpr int kBlur = 2;                     // pixels to each side
constexpr uint32_t kBlocks[] = {8, 16, 32};  // pixels along blocks in which light may be missing
constexpr double kSignificantInBlock = 5;    // standard errors; there are many blocks
constexpr double kSignificant = 4;           // standard errors; a trial has few samples to estimate them from

double count_of(const std::map<std::string, double>& counters, const char* name) {
  const auto found = counters.find(name);
  return found == counters.end() ? 0 : found->second;
}

std::array<double, 3> channels(const float4& v) {
  return {static_cast<double>(v.x), static_cast<double>(v.y), static_cast<double>(v.z)};
}

struct Estimate {
  double mean = 0, squared_error = 0;
};

/// Pixels from (x0, y0) to before (x1, y1).
struct Block {
  uint32_t x0, y0, x1, y1;
};

/// The light of a block's pixels, as weights see it, of a sample.
Estimate weighted_light(const TrialImage& image, const PixelWeights& weights, const Block& block) {
  std::vector<double> totals;
  double before = 0;
  for (const std::vector<float4>& sums : image.sums) {
    double after = 0;
    for (uint32_t y = block.y0; y < block.y1; ++y) {
      for (uint32_t x = block.x0; x < block.x1; ++x) {
        const size_t i = size_t{y} * image.width + x;
        const auto light = channels(sums[i]);
        for (size_t c = 0; c < 3; ++c) after += std::sqrt(weights[i][c]) * light[c];
      }
    }
    totals.push_back(after - before);
    before = after;
  }
  const double n = image.samples();
  Estimate result;
  result.mean = before / n;
  for (const double total : totals)
    result.squared_error += (total - result.mean) * (total - result.mean) / (n * (n - 1));
  return result;
}

/// The square of the light that a block lacks in all samples, beyond so many standard errors.
double squared_lack(const TrialImage& trial, const TrialImage& reference, const PixelWeights& weights,
                    const Block& block, double significant) {
  const Estimate found = weighted_light(trial, weights, block), expected = weighted_light(reference, weights, block);
  const double chance = significant * std::sqrt(found.squared_error + expected.squared_error);
  const double missing = std::max(expected.mean - found.mean - chance, 0.0) * trial.samples();
  return missing * missing;
}

}  // namespace

double work_of(const std::map<std::string, double>& counters) {
  return kPath * count_of(counters, "paths") + kVertex * count_of(counters, "camera_rays") +
         count_of(counters, "light_sample_rays") + kConnection * count_of(counters, "connection_rays") +
         kCandidate * count_of(counters, "candidates") + kLightPathVertex * count_of(counters, "light_path_rays") +
         kSplat * count_of(counters, "splat_rays");
}

PixelWeights pixel_weights(const TrialImage& reference) {
  const std::vector<float4>& sums = reference.sums.back();
  const double n = reference.samples();
  double mean_luminance = 0;
  for (const float4& sum : sums) {
    const auto [r, g, b] = channels(sum);
    mean_luminance += luminance(r, g, b) / (n * static_cast<double>(sums.size()));
  }
  const double least = std::max(0.01 * mean_luminance * mean_luminance, 1e-30);
  const auto width = static_cast<int>(reference.width), height = static_cast<int>(reference.height);
  PixelWeights weights(sums.size());
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      std::array<double, 3> mean = {};
      double pixels = 0;
      for (int v = std::max(y - kBlur, 0); v <= std::min(y + kBlur, height - 1); ++v) {
        for (int u = std::max(x - kBlur, 0); u <= std::min(x + kBlur, width - 1); ++u, ++pixels) {
          const auto light = channels(sums[static_cast<size_t>(v) * reference.width + static_cast<size_t>(u)]);
          for (size_t c = 0; c < 3; ++c) mean[c] += light[c];
        }
      }
      for (size_t c = 0; c < 3; ++c) {
        mean[c] /= pixels * n;
        weights[static_cast<size_t>(y) * reference.width + static_cast<size_t>(x)][c] = 1 / (mean[c] * mean[c] + least);
      }
    }
  }
  return weights;
}

size_t lit_pixels(const TrialImage& image) {
  return static_cast<size_t>(std::count_if(image.sums.back().begin(), image.sums.back().end(),
                                           [](const float4& sum) { return sum.x + sum.y + sum.z > 0; }));
}

double relative_variance(const TrialImage& trial, const PixelWeights& weights) {
  const double n = trial.samples();
  double variance = 0;
  for (size_t i = 0; i < weights.size(); ++i) {
    const auto sums = channels(trial.sums.back()[i]), squares = channels(trial.squares[i]);
    for (size_t c = 0; c < 3; ++c)
      variance += weights[i][c] * std::max(squares[c] - sums[c] * sums[c] / n, 0.0) / (n - 1);
  }
  return variance / (3 * static_cast<double>(weights.size()));
}

double hidden_variance(const TrialImage& trial, const TrialImage& reference, const PixelWeights& weights) {
  double largest = squared_lack(trial, reference, weights, {0, 0, trial.width, trial.height}, kSignificant);
  for (const uint32_t side : kBlocks) {
    double lack = 0;
    for (uint32_t y = 0; y < trial.height; y += side)
      for (uint32_t x = 0; x < trial.width; x += side)
        lack += squared_lack(trial, reference, weights,
                             {x, y, std::min(x + side, trial.width), std::min(y + side, trial.height)},
                             kSignificantInBlock);
    largest = std::max(largest, lack);
  }
  return largest / (trial.samples() * 3 * static_cast<double>(weights.size()));
}

}  // namespace lucarium::bidirectional
