// SPDX-License-Identifier: Apache-2.0
#include "lucarium/scene/device/environment_tables.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/constants.hpp>

#include "lucarium/base/luminance.h"

namespace lucarium {

namespace {

double luminance(const glm::vec3& c) { return lucarium::luminance<double>(c.r, c.g, c.b); }

/// Mean over a cell of the linear interpolation between cell centres: (left + 6 centre + right) / 8.
double cell_mean(double before, double centre, double after) { return (before + 6 * centre + after) / 8; }

/// cos of the polar angle at the upper edge of a row.
double edge_cosine(uint32_t row, uint32_t height) { return std::cos(glm::pi<double>() * row / height); }

/// Per texel: mean bilinear luminance over its cell.
std::vector<double> cell_luminance(const Environment& e) {
  const uint32_t w = e.width, h = e.height;
  std::vector<double> horizontal(size_t(w) * h), result(size_t(w) * h);
  for (uint32_t j = 0; j < h; ++j) {
    const glm::vec3* row = e.radiance.data() + size_t(j) * w;
    for (uint32_t i = 0; i < w; ++i) {
      horizontal[size_t(j) * w + i] =
          cell_mean(luminance(row[(i + w - 1) % w]), luminance(row[i]), luminance(row[(i + 1) % w]));
    }
  }
  for (uint32_t j = 0; j < h; ++j) {
    const size_t above = size_t(j == 0 ? 0 : j - 1) * w, below = size_t(std::min(j + 1, h - 1)) * w,
                 here = size_t(j) * w;
    for (uint32_t i = 0; i < w; ++i) {
      result[here + i] = cell_mean(horizontal[above + i], horizontal[here + i], horizontal[below + i]);
    }
  }
  return result;
}

/// Appends 0 … 1: the running sum of the weights, floored at 1 % of their mean where positive. Returns the plain sum.
double append_cdf(const double* weights, size_t count, std::vector<float>& cdf) {
  double sum = 0;
  for (size_t i = 0; i < count; ++i) sum += weights[i];
  const double floor = 0.01 * sum / static_cast<double>(count);
  const auto raised = [&](double weight) { return weight > 0 ? std::max(weight, floor) : 0.0; };
  double total = 0, running = 0;
  for (size_t i = 0; i < count; ++i) total += raised(weights[i]);
  size_t last_positive = count - 1;
  while (last_positive > 0 && !(weights[last_positive] > 0)) --last_positive;
  cdf.push_back(0.f);
  for (size_t i = 0; i < count; ++i) {
    running += total > 0 ? raised(weights[i]) / total : 1.0 / static_cast<double>(count);
    const bool complete = total > 0 ? i >= last_positive : i + 1 == count;
    cdf.push_back(complete ? 1.f : std::min(static_cast<float>(running), 1.f));
  }
  return sum;
}

}  // namespace

glm::vec3 environment_integral(const Environment& environment) {
  if (environment.width == 0) return environment.factor * (4 * glm::pi<float>());
  glm::dvec3 sum(0);
  for (uint32_t j = 0; j < environment.height; ++j) {
    glm::dvec3 row(0);
    for (uint32_t i = 0; i < environment.width; ++i) {
      row += glm::dvec3(environment.radiance[size_t(j) * environment.width + i]);
    }
    sum += row * (edge_cosine(j, environment.height) - edge_cosine(j + 1, environment.height));
  }
  return environment.factor * glm::vec3(sum * (2 * glm::pi<double>() / environment.width));
}

EnvironmentTables make_environment_tables(const Environment& environment) {
  EnvironmentTables tables;
  const uint32_t w = environment.width, h = environment.height;
  if (w == 0) return tables;
  const std::vector<double> cells = cell_luminance(environment);
  std::vector<float> rows;
  rows.reserve(size_t(w + 1) * h);
  std::vector<double> marginal(h);
  for (uint32_t j = 0; j < h; ++j) {
    const double solid_angle = edge_cosine(j, h) - edge_cosine(j + 1, h);
    marginal[j] = append_cdf(cells.data() + size_t(j) * w, w, rows) * solid_angle;
  }
  append_cdf(marginal.data(), h, tables.cdf);
  tables.cdf.insert(tables.cdf.end(), rows.begin(), rows.end());

  // Densities from the very differences that the search sees, so that they match its frequencies exactly.
  tables.texels.resize(size_t(w) * h);
  for (uint32_t j = 0; j < h; ++j) {
    const float* row = rows.data() + size_t(j) * (w + 1);
    const double row_probability = static_cast<double>(tables.cdf[j + 1]) - tables.cdf[j];
    for (uint32_t i = 0; i < w; ++i) {
      const double density = row_probability * (static_cast<double>(row[i + 1]) - row[i]) * w * h;
      tables.texels[size_t(j) * w + i] = float4(environment.radiance[size_t(j) * w + i], static_cast<float>(density));
    }
  }
  return tables;
}

}  // namespace lucarium
