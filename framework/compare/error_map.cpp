// SPDX-License-Identifier: Apache-2.0
#include "lucarium/compare/error_map.h"

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>

#include "lucarium/compare/metrics.h"

namespace lucarium {
namespace {

float srgb_to_linear(float s) { return s <= 0.04045f ? s / 12.92f : std::pow((s + 0.055f) / 1.055f, 2.4f); }

glm::vec3 linear_color(int r, int g, int b) {
  return {srgb_to_linear(static_cast<float>(r) / 255.f), srgb_to_linear(static_cast<float>(g) / 255.f),
          srgb_to_linear(static_cast<float>(b) / 255.f)};
}

float luminance_at(const std::vector<float>& rgb, size_t pixel) {
  return 0.2126f * rgb[3 * pixel] + 0.7152f * rgb[3 * pixel + 1] + 0.0722f * rgb[3 * pixel + 2];
}

}  // namespace

std::vector<float> signed_error_map(const std::vector<float>& test, const std::vector<float>& reference) {
  const glm::vec3 dark = linear_color(0x21, 0x66, 0xac), right = linear_color(0xf7, 0xf7, 0xf7),
                  bright = linear_color(0xb2, 0x18, 0x2b);
  const float floor = 0.01f * static_cast<float>(mean_luminance(reference)) + 1e-30f;
  std::vector<float> map(reference.size());
  for (size_t pixel = 0; pixel < reference.size() / 3; ++pixel) {
    const float truth = luminance_at(reference, pixel);
    float error = (luminance_at(test, pixel) - truth) / (truth + floor);
    error = std::isfinite(error) ? std::clamp(error, -1.f, 1.f) : 1.f;
    const glm::vec3 color = glm::mix(right, error < 0 ? dark : bright, std::abs(error));
    for (int c = 0; c < 3; ++c) map[3 * pixel + static_cast<size_t>(c)] = color[c];
  }
  return map;
}

}  // namespace lucarium
