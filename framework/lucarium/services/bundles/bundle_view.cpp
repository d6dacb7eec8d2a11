// SPDX-License-Identifier: Apache-2.0
#include "lucarium/services/bundles/bundle_view.h"

#include <algorithm>
#include <cmath>

#include "lucarium/base/numbers.h"

namespace lucarium {
namespace {

constexpr double kMargin = 3;  // pixels: jitter, rounding, and a border that no triangle reaches

double bundle_pixel(const Bounds& bounds, double pixel) {
  return std::max(pixel, 2.0 * bounds.radius() / (LAYERED_MAX_EDGE - kMargin));
}

struct Interval {
  double low = 1e300, high = -1e300;
};

Interval project(const Bounds& bounds, const glm::dvec3& axis) {
  Interval result;
  for (int corner = 0; corner < 8; ++corner) {
    const glm::dvec3 p(corner & 1 ? bounds.max.x : bounds.min.x, corner & 2 ? bounds.max.y : bounds.min.y,
                       corner & 4 ? bounds.max.z : bounds.min.z);
    const double x = glm::dot(axis, p);
    result.low = std::min(result.low, x);
    result.high = std::max(result.high, x);
  }
  return result;
}

float4 row(const glm::dvec3& axis, double offset) {
  return {static_cast<float>(axis.x), static_cast<float>(axis.y), static_cast<float>(axis.z),
          static_cast<float>(offset)};
}

}  // namespace

uint32_t bundle_side(const Bounds& bounds, double pixel) {
  return std::min(static_cast<uint32_t>(std::ceil(2.0 * bounds.radius() / bundle_pixel(bounds, pixel) + kMargin)),
                  LAYERED_MAX_EDGE);
}

BundleView make_bundle_view(const Bounds& bounds, const BundleDirection& direction, double pixel, uint32_t seed) {
  const double p = bundle_pixel(bounds, pixel);
  const glm::dvec3 z = glm::normalize(glm::dvec3(direction.direction));
  const glm::dvec3 helper = std::abs(z.y) < 0.9 ? glm::dvec3(0, 1, 0) : glm::dvec3(1, 0, 0);
  const glm::dvec3 u = glm::normalize(glm::cross(helper, z)), v = glm::cross(z, u);
  const double angle = 2 * pi * direction.rotation;
  const glm::dvec3 x = std::cos(angle) * u + std::sin(angle) * v, y = glm::cross(z, x);
  const Interval extent_x = project(bounds, x), extent_y = project(bounds, y), depth = project(bounds, z);
  const uint32_t side = bundle_side(bounds, pixel);
  const auto pixels = [&](const Interval& extent) {
    return std::min(static_cast<uint32_t>(std::ceil((extent.high - extent.low) / p)) + 2u, side);
  };
  BundleView result;
  result.pixel_area = p * p;
  // The lowest coordinate lies within the first pixel, at its jittered place.
  result.view.row_x = row(x / p, 1 - direction.jitter.x - extent_x.low / p);
  result.view.row_y = row(y / p, 1 - direction.jitter.y - extent_y.low / p);
  const double center = 0.5 * (depth.low + depth.high),
               range = 1.001 * (depth.high - depth.low) + 1e-6 * bounds.radius();
  result.view.row_w = row(z, -center);
  result.view.depth_min = static_cast<float>(-0.5 * range);
  result.view.depth_scale = static_cast<float>(1 / range);
  result.view.width = pixels(extent_x);
  result.view.height = pixels(extent_y);
  result.view.seed = seed;
  return result;
}

}  // namespace lucarium
