// SPDX-License-Identifier: Apache-2.0
#include "lucarium/conformance/block_comparison.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "lucarium/conformance/check_context.h"

namespace lucarium::check {
namespace {

constexpr uint32_t block = 8;

struct Moments {
  double mean = 0, variance_of_mean = 0;
};

Moments moments(const std::vector<double>& values) {
  const double n = static_cast<double>(values.size());
  Moments m;
  for (const double v : values) m.mean += v / n;
  for (const double v : values) m.variance_of_mean += (v - m.mean) * (v - m.mean) / (n - 1) / n;
  return m;
}

/// Mean of one channel over one block, for each image.
std::vector<double> block_means(const std::vector<std::vector<float>>& images, uint32_t width, uint32_t height,
                                uint32_t x0, uint32_t y0, uint32_t channel) {
  std::vector<double> means;
  const uint32_t x1 = std::min(x0 + block, width), y1 = std::min(y0 + block, height);
  for (const std::vector<float>& image : images) {
    double sum = 0;
    for (uint32_t y = y0; y < y1; ++y) {
      for (uint32_t x = x0; x < x1; ++x) sum += image[3 * (size_t{y} * width + x) + channel];
    }
    means.push_back(sum / ((x1 - x0) * (y1 - y0)));
  }
  return means;
}

}  // namespace

BlockTest compare_blocks(std::vector<std::vector<float>> a, std::vector<std::vector<float>> b, uint32_t width,
                         uint32_t height) {
  BlockTest result;
  double squares = 0, noise = 0, scale = 0;
  for (uint32_t y = 0; y < height; y += block) {
    for (uint32_t x = 0; x < width; x += block) {
      for (uint32_t channel = 0; channel < 3; ++channel) {
        const Moments m = moments(block_means(a, width, height, x, y, channel));
        const Moments n = moments(block_means(b, width, height, x, y, channel));
        squares += (m.mean - n.mean) * (m.mean - n.mean);
        noise += m.variance_of_mean + n.variance_of_mean;
        scale += n.mean * n.mean;
      }
    }
  }
  if (scale > 0) {
    result.rms = std::sqrt(std::max(0.0, squares - noise) / scale);
    result.noise = std::sqrt(noise / scale);
  } else {
    result.rms = squares > 0 ? INFINITY : 0;
  }
  constexpr double channels = 3;
  const ImageTest test =
      test_images(ImageEstimate::from_replicates(width, height, std::move(a)),
                  ImageEstimate::from_replicates(width, height, std::move(b)),
                  {.level = level, .image_level = level / channels, .block = block, .tolerance = rounding});
  for (const ImageTestLevel& one : test.levels) {
    if (one.name == "blocks") result.blocks = one;
    if (one.name == "image") result.image = one;
  }
  return result;
}

BlockTest compare_seeds(const ImageOfSeed& a, const ImageOfSeed& b, double bias) {
  std::vector<std::vector<float>> ours, theirs;
  BlockTest test;
  for (uint64_t seed = 1; seed <= seeds; ++seed) {
    ours.push_back(a(seed));
    theirs.push_back(b(seed));
    if (seed < min_seeds) continue;
    test = compare_blocks(ours, theirs, picture_side, picture_side);
    if (test.rms + 2 * test.noise <= bias) break;  // within it beyond doubt
  }
  return test;
}

bool BlockTest::passes(double bias) const { return bias > 0 ? rms <= bias : blocks.failures + image.failures == 0; }

std::string BlockTest::describe(double bias) const {
  const std::string size = fmt::format("difference {:.2g} % beyond noise of {:.2g} %", 100 * rms, 100 * noise);
  if (bias > 0) return size;
  return fmt::format("worst |t| = {:.1f} of {} blocks, {:.1f} of the image; {}", std::abs(blocks.worst_t),
                     blocks.tests + blocks.constant, std::abs(image.worst_t), size);
}

}  // namespace lucarium::check
