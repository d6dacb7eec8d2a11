// SPDX-License-Identifier: Apache-2.0
#include "lucarium/services/bundles/environment_guide.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "lucarium/base/luminance.h"
#include "lucarium/base/numbers.h"

namespace lucarium {
namespace {

/// The cell k with c[k] <= x < c[k + 1] and the place in it.
std::pair<uint32_t, double> search(const double* c, uint32_t count, double x) {
  const double* next = std::upper_bound(c + 1, c + count, x);
  const uint32_t k = static_cast<uint32_t>(next - c - 1);
  const double size = c[k + 1] - c[k];
  return {k, size > 0 ? std::clamp((x - c[k]) / size, 0.0, 1.0) : 0.5};
}

}  // namespace

EnvironmentGuide::EnvironmentGuide(const Environment& environment)
    : width_(environment.width),
      height_(environment.height),
      environment_from_world_(environment.environment_from_world) {
  rows_.assign(height_ + 1, 0.0);
  columns_.assign(size_t{height_} * (width_ + 1), 0.0);
  for (uint32_t j = 0; j < height_; ++j) {
    double* row = &columns_[size_t{j} * (width_ + 1)];
    for (uint32_t i = 0; i < width_; ++i) {
      const glm::vec3 c = environment.radiance[size_t{j} * width_ + i] * environment.factor;
      row[i + 1] = row[i] + std::max(0.0, luminance<double>(c.x, c.y, c.z));
    }
    const double solid_angle = std::cos(pi * j / height_) - std::cos(pi * (j + 1) / height_);
    rows_[j + 1] = rows_[j] + row[width_] * solid_angle;
    for (uint32_t i = 1; i <= width_; ++i) row[i] = row[width_] > 0 ? row[i] / row[width_] : double(i) / width_;
  }
  const double total = rows_[height_];
  for (uint32_t j = 1; j <= height_; ++j)
    rows_[j] = total > 0 ? rows_[j] / total : 0.5 - 0.5 * std::cos(pi * j / height_);
}

glm::vec3 EnvironmentGuide::sample(double u, double v) const {
  const auto [j, y] = search(rows_.data(), height_, v);
  const auto [i, x] = search(&columns_[size_t{j} * (width_ + 1)], width_, u);
  const double top = std::cos(pi * j / height_), bottom = std::cos(pi * (j + 1) / height_);
  const double cos_theta = top + y * (bottom - top), sin_theta = std::sqrt(std::max(0.0, 1 - cos_theta * cos_theta));
  const double phi = 2 * pi * ((i + x) / width_ - 0.5);
  const glm::vec3 local(static_cast<float>(sin_theta * std::cos(phi)), static_cast<float>(cos_theta),
                        static_cast<float>(sin_theta * std::sin(phi)));
  return glm::transpose(environment_from_world_) * local;
}

double EnvironmentGuide::density(const glm::vec3& direction) const {
  const glm::vec3 local = environment_from_world_ * direction;
  const double u = 0.5 + std::atan2(local.z, local.x) / (2 * pi);
  const double v = std::acos(std::clamp(double{local.y}, -1.0, 1.0)) / pi;
  const uint32_t i = std::min(static_cast<uint32_t>(u * width_), width_ - 1);
  const uint32_t j = std::min(static_cast<uint32_t>(v * height_), height_ - 1);
  const double* row = &columns_[size_t{j} * (width_ + 1)];
  const double band = 2 * pi * (std::cos(pi * j / height_) - std::cos(pi * (j + 1) / height_));
  return (rows_[j + 1] - rows_[j]) * (row[i + 1] - row[i]) * width_ / band;
}

std::shared_ptr<const EnvironmentGuide> make_environment_guide(const Environment* environment) {
  if (!environment || environment->width == 0) return nullptr;
  return std::make_shared<EnvironmentGuide>(*environment);
}

}  // namespace lucarium
