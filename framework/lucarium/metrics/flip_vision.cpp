// SPDX-License-Identifier: Apache-2.0
#include "lucarium/metrics/flip_vision.h"

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>

namespace lucarium {
namespace {

// Linear Rec.709 to CIE XYZ, D65: 10135552/24577794 and so on, as in the authors' implementation. Columns are R, G, B.
constexpr glm::dmat3 xyz_from_rgb_rows(0.41238656, 0.35759149, 0.18045049,  //
                                       0.21263682, 0.71518298, 0.07218020,  //
                                       0.01933062, 0.11919716, 0.95037259);
const glm::mat3 xyz_from_rgb(glm::transpose(xyz_from_rgb_rows));
const glm::mat3 rgb_from_xyz(glm::inverse(glm::transpose(xyz_from_rgb_rows)));
const glm::vec3 white = xyz_from_rgb * glm::vec3(1);

constexpr float color_exponent = 0.7f, knee_input = 0.4f, knee_output = 0.95f;  // q_c, p_c, p_t
constexpr double feature_sigma_degrees = 0.041;
constexpr double widest_sensitivity = 0.04;  // the greatest b below, which sets the radius of all

/// a √(π/b) exp(−π² r²/b), r in degrees: contrast sensitivity as a filter over the image.
struct Sensitivity {
  double a, b;
};
constexpr Sensitivity achromatic{1, 0.0047}, red_green{1, 0.0053}, blue_yellow[2] = {{34.1, 0.04}, {13.5, 0.025}};

/// One axis of the filter without its factor a √(π/b): it is a product of two of these.
std::vector<double> sensitivity_taps(const Sensitivity& s, double pixels_per_degree) {
  const int radius =
      static_cast<int>(std::ceil(3 * std::sqrt(widest_sensitivity / (2 * M_PI * M_PI)) * pixels_per_degree));
  std::vector<double> taps;
  for (int i = -radius; i <= radius; ++i) {
    const double degrees = i / pixels_per_degree;
    taps.push_back(std::exp(-M_PI * M_PI * degrees * degrees / s.b));
  }
  return taps;
}

double sum_of(const std::vector<double>& taps) {
  double sum = 0;
  for (const double tap : taps) sum += tap;
  return sum;
}

/// Taps of sum 1, without the outer ones that a sum of floats cannot feel.
std::vector<float> normalized(const std::vector<double>& taps) {
  const double sum = sum_of(taps);
  size_t skip = 0;
  while (skip < taps.size() / 2 && taps[skip] < 1e-9 * sum) ++skip;
  std::vector<float> result;
  for (size_t i = skip; i < taps.size() - skip; ++i) result.push_back(static_cast<float>(taps[i] / sum));
  return result;
}

/// Positive taps of sum 1, negative ones of sum −1.
std::vector<float> balanced(const std::vector<double>& taps) {
  double positive = 0, negative = 0;
  for (const double tap : taps) (tap > 0 ? positive : negative) += std::abs(tap);
  std::vector<float> result;
  for (const double tap : taps) result.push_back(static_cast<float>(tap / (tap > 0 ? positive : negative)));
  return result;
}

struct Size {
  size_t width, height;
};
using Plane = std::vector<float>;

/// out(x, y) = Σ_k taps[k] in(x + k − radius, y), edges clamped.
Plane filter_rows(const Plane& in, Size size, const std::vector<float>& taps) {
  const size_t radius = taps.size() / 2;
  Plane out(in.size(), 0.f), padded(size.width + 2 * radius);
  for (size_t y = 0; y < size.height; ++y) {
    const float* row = in.data() + y * size.width;
    std::fill_n(padded.begin(), radius, row[0]);
    std::copy_n(row, size.width, padded.begin() + static_cast<ptrdiff_t>(radius));
    std::fill_n(padded.begin() + static_cast<ptrdiff_t>(radius + size.width), radius, row[size.width - 1]);
    float* sums = out.data() + y * size.width;
    for (size_t k = 0; k < taps.size(); ++k) {
      const float tap = taps[k];
      const float* shifted = padded.data() + k;
      for (size_t x = 0; x < size.width; ++x) sums[x] += tap * shifted[x];
    }
  }
  return out;
}

/// out(x, y) = Σ_k taps[k] in(x, y + k − radius), edges clamped.
Plane filter_columns(const Plane& in, Size size, const std::vector<float>& taps) {
  const auto radius = static_cast<ptrdiff_t>(taps.size() / 2), last = static_cast<ptrdiff_t>(size.height) - 1;
  Plane out(in.size(), 0.f);
  for (size_t y = 0; y < size.height; ++y) {
    float* sums = out.data() + y * size.width;
    for (size_t k = 0; k < taps.size(); ++k) {
      const ptrdiff_t source = std::clamp(static_cast<ptrdiff_t>(y + k) - radius, ptrdiff_t{0}, last);
      const float tap = taps[k];
      const float* row = in.data() + static_cast<size_t>(source) * size.width;
      for (size_t x = 0; x < size.width; ++x) sums[x] += tap * row[x];
    }
  }
  return out;
}

Plane blur(const Plane& in, Size size, const std::vector<float>& taps) {
  return filter_columns(filter_rows(in, size, taps), size, taps);
}

Plane magnitude(const Plane& x, const Plane& y) {
  Plane out(x.size());
  for (size_t p = 0; p < out.size(); ++p) out[p] = std::sqrt(x[p] * x[p] + y[p] * y[p]);
  return out;
}

float lab_curve(float t) {
  constexpr float delta = 6.f / 29;
  return t > delta * delta * delta ? std::cbrt(t) : t / (3 * delta * delta) + 4.f / 29;
}

/// (L*, a* .01 L*, b* .01 L*) of linear RGB.
glm::vec3 hunt_lab(const glm::vec3& rgb) {
  const glm::vec3 xyz = xyz_from_rgb * rgb / white;
  const float x = lab_curve(xyz.x), y = lab_curve(xyz.y), z = lab_curve(xyz.z);
  const float lightness = 116 * y - 16, hunt = 0.01f * lightness;
  return {lightness, hunt * 500 * (x - y), hunt * 200 * (y - z)};
}

/// HyAB distance (Abasi et al. 2020), compressed.
float color_difference(float lightness, float a, float b) {
  return std::pow(std::abs(lightness) + std::sqrt(a * a + b * b), color_exponent);
}

}  // namespace

FlipVision::FlipVision(double pixels_per_degree) {
  achromatic_ = normalized(sensitivity_taps(achromatic, pixels_per_degree));
  red_green_ = normalized(sensitivity_taps(red_green, pixels_per_degree));
  double weights[2];
  for (int i = 0; i < 2; ++i) {
    const std::vector<double> taps = sensitivity_taps(blue_yellow[i], pixels_per_degree);
    weights[i] = blue_yellow[i].a * std::sqrt(M_PI / blue_yellow[i].b) * sum_of(taps) * sum_of(taps);
    blue_yellow_[i] = normalized(taps);
  }
  for (int i = 0; i < 2; ++i) blue_yellow_weight_[i] = static_cast<float>(weights[i] / (weights[0] + weights[1]));

  const double sigma = feature_sigma_degrees * pixels_per_degree;
  const int radius = static_cast<int>(std::ceil(3 * sigma));
  std::vector<double> smooth, first, second;
  for (int i = -radius; i <= radius; ++i) {
    const double gaussian = std::exp(-i * i / (2 * sigma * sigma));
    smooth.push_back(gaussian);
    first.push_back(-i * gaussian);
    second.push_back((i * i / (sigma * sigma) - 1) * gaussian);
  }
  smooth_ = normalized(smooth);
  first_derivative_ = balanced(first);
  second_derivative_ = balanced(second);
}

FlipPercept FlipVision::perceive(uint32_t width, uint32_t height, const std::vector<float>& rgb) const {
  const Size size{width, height};
  const size_t pixels = size.width * size.height;
  // YCxCz without its factors 116, 500, 200 and its offset, which a filter of sum 1 lets through.
  Plane y(pixels), cx(pixels), cz(pixels);
  for (size_t p = 0; p < pixels; ++p) {
    const glm::vec3 xyz = xyz_from_rgb * glm::vec3(rgb[3 * p], rgb[3 * p + 1], rgb[3 * p + 2]) / white;
    y[p] = xyz.y;
    cx[p] = xyz.x - xyz.y;
    cz[p] = xyz.y - xyz.z;
  }
  FlipPercept percept;
  {
    const Plane smooth = filter_rows(y, size, smooth_);
    percept.edge = magnitude(filter_columns(filter_rows(y, size, first_derivative_), size, smooth_),
                             filter_columns(smooth, size, first_derivative_));
    percept.point = magnitude(filter_columns(filter_rows(y, size, second_derivative_), size, smooth_),
                              filter_columns(smooth, size, second_derivative_));
  }
  y = blur(y, size, achromatic_);
  cx = blur(cx, size, red_green_);
  const Plane wide = blur(cz, size, blue_yellow_[0]), narrow = blur(cz, size, blue_yellow_[1]);
  percept.lightness.resize(pixels);
  percept.hunt_a.resize(pixels);
  percept.hunt_b.resize(pixels);
  for (size_t p = 0; p < pixels; ++p) {
    const float z = y[p] - (blue_yellow_weight_[0] * wide[p] + blue_yellow_weight_[1] * narrow[p]);
    const glm::vec3 filtered = rgb_from_xyz * (glm::vec3(cx[p] + y[p], y[p], z) * white);
    const glm::vec3 lab = hunt_lab(glm::clamp(filtered, 0.f, 1.f));
    percept.lightness[p] = lab.x;
    percept.hunt_a[p] = lab.y;
    percept.hunt_b[p] = lab.z;
  }
  return percept;
}

std::vector<float> flip_error(const FlipPercept& reference, const FlipPercept& test) {
  const glm::vec3 extremes = hunt_lab({0, 1, 0}) - hunt_lab({0, 0, 1});
  const float greatest = color_difference(extremes.x, extremes.y, extremes.z), knee = knee_input * greatest;
  std::vector<float> error(reference.lightness.size());
  for (size_t p = 0; p < error.size(); ++p) {
    const float difference =
        color_difference(reference.lightness[p] - test.lightness[p], reference.hunt_a[p] - test.hunt_a[p],
                         reference.hunt_b[p] - test.hunt_b[p]);
    const float color = difference < knee ? difference * (knee_output / knee)
                                          : knee_output + (difference - knee) / (greatest - knee) * (1 - knee_output);
    const float feature =
        std::sqrt(static_cast<float>(M_SQRT1_2) *
                  std::max(std::abs(reference.edge[p] - test.edge[p]), std::abs(reference.point[p] - test.point[p])));
    error[p] = std::min(1.f, std::pow(color, 1 - std::min(1.f, feature)));
  }
  return error;
}

}  // namespace lucarium
