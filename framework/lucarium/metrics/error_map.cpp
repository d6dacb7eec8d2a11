// SPDX-License-Identifier: Apache-2.0
#include "lucarium/metrics/error_map.h"

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>

#include "lucarium/base/luminance.h"
#include "lucarium/base/srgb.h"
#include "lucarium/metrics/metrics.h"

namespace lucarium {
namespace {

glm::vec3 linear_color(unsigned hex) {
  const auto channel = [hex](unsigned shift) {
    return static_cast<float>(linear_from_srgb((hex >> shift & 255u) / 255.0));
  };
  return {channel(16), channel(8), channel(0)};
}

float luminance_at(const std::vector<float>& rgb, size_t pixel) {
  return luminance(rgb[3 * pixel], rgb[3 * pixel + 1], rgb[3 * pixel + 2]);
}

/// Every value, from `low` to `high`, as a colour between evenly spaced ones.
std::vector<float> color_values(const std::vector<float>& values, float low, float high,
                                const std::vector<unsigned>& scale) {
  std::vector<glm::vec3> colors;
  for (const unsigned hex : scale) colors.push_back(linear_color(hex));
  std::vector<float> picture;
  picture.reserve(3 * values.size());
  for (const float value : values) {
    const float at = (std::clamp(value, low, high) - low) / (high - low) * static_cast<float>(colors.size() - 1);
    const size_t below = std::min(static_cast<size_t>(at), colors.size() - 2);
    const glm::vec3 color = glm::mix(colors[below], colors[below + 1], at - static_cast<float>(below));
    picture.insert(picture.end(), {color.r, color.g, color.b});
  }
  return picture;
}

}  // namespace

std::vector<float> signed_relative_error(const std::vector<float>& test, const std::vector<float>& reference) {
  // 1e-30 keeps the quotients of a black reference defined.
  const float floor = 0.01f * static_cast<float>(mean_luminance(reference)) + 1e-30f;
  std::vector<float> error(reference.size() / 3);
  for (size_t pixel = 0; pixel < error.size(); ++pixel) {
    const float truth = luminance_at(reference, pixel);
    const float relative = (luminance_at(test, pixel) - truth) / (truth + floor);
    error[pixel] = std::isfinite(relative) ? relative : 1.f;
  }
  return error;
}

std::vector<float> color_signed_error(const std::vector<float>& error) {
  return color_values(error, -1, 1, {0x2166ac, 0xf7f7f7, 0xb2182b});
}

std::vector<float> color_error(const std::vector<float>& error) {
  return color_values(error, 0, 1,
                      {0x000004, 0x1c1044, 0x4f127b, 0x812581, 0xb5367a, 0xe55964, 0xfb8761, 0xfec287, 0xfcfdbf});
}

}  // namespace lucarium
