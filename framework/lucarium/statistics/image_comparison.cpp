// SPDX-License-Identifier: Apache-2.0
#include "lucarium/statistics/image_comparison.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "lucarium/base/error.h"
#include "lucarium/statistics/student_t.h"

namespace lucarium {
namespace {

constexpr double kRounding = 1e-5;            ///< relative, of a film's values
constexpr double kConstantDifference = 1e-4;  ///< relative, beyond which values without noise differ

/// Cells of a coarser image: means over blocks of side × side pixels, cut at the borders.
struct Grid {
  uint32_t columns = 0, rows = 0;
  std::vector<double> mean, variance, dof;  ///< 3 per cell
};

struct Blocks {
  uint32_t width, height, side;
  uint32_t columns() const { return (width + side - 1) / side; }
  uint32_t rows() const { return (height + side - 1) / side; }
  size_t cells() const { return size_t{columns()} * rows() * 3; }
  /// Calls visit(index of the value, index of its cell's value, values in that cell).
  template <class Visit>
  void each(Visit visit) const {
    for (uint32_t y = 0; y < height; ++y)
      for (uint32_t x = 0; x < width; ++x) {
        const uint32_t column = x / side, row = y / side;
        const double count = double(std::min(side, width - column * side)) * std::min(side, height - row * side);
        for (uint32_t c = 0; c < 3; ++c)
          visit((size_t{y} * width + x) * 3 + c, (size_t{row} * columns() + column) * 3 + c, count);
      }
  }
};

/// Mean and variance of the mean of R values per cell, given value by value.
void finish_replicates(const std::vector<std::vector<double>>& values, std::vector<double>& mean,
                       std::vector<double>& variance) {
  const double count = static_cast<double>(values.size());
  for (size_t i = 0; i < mean.size(); ++i) {
    double sum = 0, squares = 0;
    for (const auto& one : values) sum += one[i];
    mean[i] = sum / count;
    for (const auto& one : values) squares += (one[i] - mean[i]) * (one[i] - mean[i]);
    variance[i] = squares / (count - 1) / count;
  }
}

Grid make_grid(const ImageEstimate& image, uint32_t side) {
  const Blocks blocks{image.width, image.height, side};
  Grid grid{blocks.columns(), blocks.rows(), std::vector<double>(blocks.cells()), std::vector<double>(blocks.cells()),
            std::vector<double>(blocks.cells(), image.dof)};
  if (side == 1) {
    grid.mean = image.mean;
    grid.variance = image.variance;
    return grid;
  }
  if (!image.replicates.empty()) {
    std::vector<std::vector<double>> means;
    for (const std::vector<float>& replicate : image.replicates) {
      means.emplace_back(blocks.cells());
      blocks.each([&](size_t value, size_t cell, double count) { means.back()[cell] += replicate[value] / count; });
    }
    finish_replicates(means, grid.mean, grid.variance);
    return grid;
  }
  // Independent pixels: variances add up, degrees of freedom by Welch and Satterthwaite.
  std::vector<double> squares(blocks.cells());
  blocks.each([&](size_t value, size_t cell, double count) {
    const double variance = image.variance[value] / (count * count);
    grid.mean[cell] += image.mean[value] / count;
    grid.variance[cell] += variance;
    squares[cell] += variance * variance / image.dof;
  });
  for (size_t i = 0; i < squares.size(); ++i)
    if (squares[i] > 0) grid.dof[i] = grid.variance[i] * grid.variance[i] / squares[i];
  return grid;
}

/// p-values of a level are gathered for the test of their distribution.
ImageTestLevel test_level(const std::string& name, const Grid& a, const Grid& b, double level_of_all, bool per_channel,
                          double tolerance) {
  ImageTestLevel result;
  result.name = name;
  for (size_t i = 0; i < a.mean.size(); ++i) (a.variance[i] + b.variance[i] > 0 ? result.tests : result.constant) += 1;
  result.level = per_channel || result.tests == 0 ? level_of_all : sidak_level(level_of_all, result.tests);
  std::vector<double> p_values;
  for (size_t i = 0; i < a.mean.size(); ++i) {
    const double size = 0.5 * (std::abs(a.mean[i]) + std::abs(b.mean[i]));
    const double difference = std::max(0.0, std::abs(a.mean[i] - b.mean[i]) - tolerance * size);
    if (a.variance[i] + b.variance[i] == 0) {
      result.failures += difference > kConstantDifference * size;
      continue;
    }
    const double floor = kRounding * size * kRounding * size;
    const double va = std::max(a.variance[i], floor), vb = std::max(b.variance[i], floor);
    const double dof = (va + vb) * (va + vb) / (va * va / a.dof[i] + vb * vb / b.dof[i]);
    const double t = difference / std::sqrt(va + vb), p = student_t_tail(t, dof);
    p_values.push_back(p);
    result.failures += p < result.level;
    if (p > result.smallest_p) continue;
    result.smallest_p = p;
    result.worst_t = a.mean[i] > b.mean[i] ? t : -t;
    result.worst_channel = static_cast<uint32_t>(i % 3);
    result.worst_x = static_cast<uint32_t>(i / 3 % a.columns);
    result.worst_y = static_cast<uint32_t>(i / 3 / a.columns);
  }
  std::sort(p_values.begin(), p_values.end());
  const double count = static_cast<double>(p_values.size());
  for (size_t i = 0; i < p_values.size(); ++i) {
    const double k = static_cast<double>(i);
    result.ks_statistic = std::max({result.ks_statistic, p_values[i] - k / count, (k + 1) / count - p_values[i]});
  }
  if (!p_values.empty()) result.ks_p = kolmogorov_tail(result.ks_statistic, p_values.size());
  return result;
}

}  // namespace

ImageEstimate ImageEstimate::from_replicates(uint32_t width, uint32_t height,
                                             std::vector<std::vector<float>> replicates) {
  if (replicates.size() < 2)
    throw Error(ErrorClass::input, "an image test needs at least 2 independent renders of each side");
  const size_t values = size_t{width} * height * 3;
  std::vector<std::vector<double>> wide;
  for (const std::vector<float>& image : replicates) {
    if (image.size() != values) throw Error(ErrorClass::input, "the renders of an image test differ in size");
    if (!std::all_of(image.begin(), image.end(), [](float v) { return std::isfinite(v); }))
      throw Error(ErrorClass::input, "a render of an image test holds NaN or infinity");
    wide.emplace_back(image.begin(), image.end());
  }
  ImageEstimate estimate{width,
                         height,
                         std::vector<double>(values),
                         std::vector<double>(values),
                         static_cast<double>(replicates.size() - 1),
                         {}};
  finish_replicates(wide, estimate.mean, estimate.variance);
  estimate.replicates = std::move(replicates);
  return estimate;
}

ImageEstimate ImageEstimate::from_film(const Film& film, const std::string& shown_name) {
  const FilmLayer* variance = film.find("Variance");
  const auto dof = film.metadata.find("variance_dof");
  if (!variance || dof == film.metadata.end())
    throw_error(ErrorClass::input,
                "{} has no estimate of its error; render it with path_tracing and replicates=16 or more", shown_name);
  const std::vector<float> image = film.image();
  if (variance->pixels.size() != image.size())
    throw_error(ErrorClass::input, "{}: layer Variance has another size than the image", shown_name);
  return {film.width(),
          film.height(),
          std::vector<double>(image.begin(), image.end()),
          std::vector<double>(variance->pixels.begin(), variance->pixels.end()),
          std::strtod(dof->second.c_str(), nullptr),
          {}};
}

ImageTest test_images(const ImageEstimate& a, const ImageEstimate& b, const ImageTestOptions& options) {
  if (a.width != b.width || a.height != b.height)
    throw_error(ErrorClass::input, "the image test compares {}x{} with {}x{} pixels", a.width, a.height, b.width,
                b.height);
  ImageTest test;
  const auto add = [&](const char* name, uint32_t side, double level, bool per_channel) {
    test.levels.push_back(
        test_level(name, make_grid(a, side), make_grid(b, side), level, per_channel, options.tolerance));
  };
  add("pixels", 1, options.level, false);
  add("blocks", options.block, options.level, false);
  add("image", std::max(a.width, a.height), options.image_level, true);
  for (size_t i = 0; i < a.mean.size(); ++i) {
    test.mean_a += a.mean[i] / static_cast<double>(a.mean.size());
    test.mean_b += b.mean[i] / static_cast<double>(b.mean.size());
  }
  test.passed =
      std::all_of(test.levels.begin(), test.levels.end(), [](const ImageTestLevel& l) { return l.failures == 0; });
  return test;
}

std::string to_text(const ImageTest& test) {
  std::string text;
  for (const ImageTestLevel& l : test.levels)
    text += fmt::format(
        "{:6} {} of {} differ at level {:.2g} ({} constant); largest |t| {:.2f} at ({}, {}) channel {}, p {:.2g}; "
        "p-values "
        "uniform: KS {:.4f}, p {:.2g}\n",
        l.name, l.failures, l.tests, l.level, l.constant, std::abs(l.worst_t), l.worst_x, l.worst_y, l.worst_channel,
        l.smallest_p, l.ks_statistic, l.ks_p);
  const double ratio = test.mean_b != 0 ? test.mean_a / test.mean_b : 1;
  return text + fmt::format("means  {:.6g} and {:.6g}, ratio {:.5f}: {}\n", test.mean_a, test.mean_b, ratio,
                            test.passed ? "the same up to noise" : "DIFFERENT");
}

double kolmogorov_tail(double distance, size_t values) {
  const double root = std::sqrt(static_cast<double>(values));
  const double x = (root + 0.12 + 0.11 / root) * distance;
  if (x < 0.2) return 1;
  double sum = 0, sign = 1;
  for (int k = 1; k <= 100; ++k, sign = -sign) sum += sign * std::exp(-2.0 * k * k * x * x);
  return std::clamp(2 * sum, 0.0, 1.0);
}

}  // namespace lucarium
