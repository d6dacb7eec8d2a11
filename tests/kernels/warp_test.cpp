// SPDX-License-Identifier: Apache-2.0
// kernels/lucarium/warp.clh: points follow their densities, inverses undo the maps. kernels/lucarium/math.clh: sine and
// cosine.
#include <doctest/doctest.h>

#include <cmath>
#include <functional>
#include <numbers>

#include "chi2.h"
#include "kernel_fixture.h"
#include "lucarium/base/numbers.h"
#include "test_support.h"
#include "tolerance.h"

using namespace lucarium;

namespace {

const Program& warp_program() {
  static const Program instance = test::kernel_program("sampling");
  return instance;
}

/// A warp with its distribution in coordinates (a, b) of [0,1]^2 whose cells have closed-form probabilities:
/// P([0, a] x [0, b]) = cumulative(a) b.
struct Warp {
  const char* name;
  uint id;
  float parameter;
  std::function<glm::dvec2(const float4&)> coordinates;
  std::function<double(double)> cumulative;
  std::function<double(const float4&)> density;
};

double azimuth(const float4& w) {
  const double turns = std::atan2(double(w.y), double(w.x)) / (2 * pi);
  return turns < 0 ? turns + 1 : turns;
}

glm::dvec2 zonal(const float4& w) { return {0.5 * (1 - double(w.z)), azimuth(w)}; }

std::vector<Warp> warps() {
  const auto linear = [](double a) { return a; };
  const double cone = 0.9;
  return {
      {"disk", 0, 0, [](const float4& p) { return glm::dvec2(double(p.x) * p.x + double(p.y) * p.y, azimuth(p)); },
       linear, [](const float4&) { return 1 / pi; }},
      {"cosine hemisphere", 1, 0, zonal,
       [](double a) {
         const double z = std::max(0.0, 1 - 2 * a);
         return 1 - z * z;
       },
       [](const float4& w) { return w.z / pi; }},
      {"sphere", 2, 0, zonal, linear, [](const float4&) { return 1 / (4 * pi); }},
      {"hemisphere", 3, 0, zonal, [](double a) { return std::min(1.0, 2 * a); },
       [](const float4&) { return 1 / (2 * pi); }},
      {"cone", 4, static_cast<float>(cone), zonal, [=](double a) { return std::min(1.0, 2 * a / (1 - cone)); },
       [=](const float4&) { return 1 / (2 * pi * (1 - cone)); }},
      // The triangle's weights: the share 1 - x - y is the square root's complement of a uniform number.
      {"triangle", 5, 0,
       [](const float4& p) {
         const double sum = double(p.x) + p.y;
         return glm::dvec2(sum * sum, sum > 0 ? p.x / sum : 0);
       },
       linear, [](const float4&) { return 2.0; }},
      {"power cosine", 6, 5, zonal, [](double a) { return 1 - std::pow(std::max(0.0, 1 - 2 * a), 6); },
       [](const float4& w) { return 6 / (2 * pi) * std::pow(double(w.z), 5); }},
  };
}

}  // namespace

TEST_CASE("warped points follow their density and can be mapped back") {
  const uint n = test::full_run() ? 1000000 : 200000;
  const int columns = 51, rows = 102;
  const int tests = static_cast<int>(warps().size());
  for (const Warp& warp : warps()) {
    CAPTURE(warp.name);
    const auto points = test::test_buffer<float4>(n);
    const auto inverses = test::test_buffer<float2>(n), squares = test::test_buffer<float2>(n);
    test::run_kernel(warp_program(), "warp_points", n, 64, [&](PassBuilder& pass) {
      pass.arg("warp", warp.id).arg("parameter", warp.parameter).arg("seed", 1u + warp.id).arg("count", n);
      pass.arg("points", points).arg("inverses", inverses).arg("squares", squares);
    });
    const auto p = points.download();
    const auto inverse = inverses.download(), square = squares.download();
    std::vector<uint64_t> observed(columns * rows);
    std::vector<double> expected;
    double worst_density = 0, worst_inverse = 0;
    int outside = 0;
    for (uint i = 0; i < n; ++i) {
      const glm::dvec2 c = warp.coordinates(p[i]);
      outside += !(c.x >= -1e-6 && c.x <= 1 + 1e-6 && c.y >= 0 && c.y <= 1);
      const int x = std::clamp(static_cast<int>(c.x * columns), 0, columns - 1);
      const int y = std::clamp(static_cast<int>(c.y * rows), 0, rows - 1);
      ++observed[x * rows + y];
      worst_density = std::max(worst_density, std::abs(p[i].w - warp.density(p[i])) / (warp.density(p[i]) + 1e-3));
      // Distance on the square, whose y wraps for the zonal maps.
      double dx = std::abs(double(inverse[i].x) - square[i].x), dy = std::abs(double(inverse[i].y) - square[i].y);
      if (warp.id >= 2 && warp.id != 5) dy = std::min(dy, 1 - dy);
      // Where the map squeezes a side of the square into a point, the inverse has few digits.
      const double sine = warp.id == 0 || warp.id == 5 ? 1 : std::hypot(double(p[i].x), double(p[i].y));
      worst_inverse = std::max(worst_inverse, std::max(dx, dy) * std::min(1.0, sine));
    }
    for (int x = 0; x < columns; ++x) {
      const double mass = warp.cumulative((x + 1.0) / columns) - warp.cumulative(double(x) / columns);
      for (int y = 0; y < rows; ++y) expected.push_back(mass * n / rows);
    }
    const auto result = test::chi2_test(observed, expected);
    CHECK(outside == 0);
    CHECK(result.stray == 0);
    CHECK(result.p >= test::sidak(0.01, tests));
    CHECK(worst_density < 2e-5);
    CHECK(worst_inverse < 5e-6);
  }
}

TEST_CASE("sincos_turns is as exact as single precision allows") {
  const uint n = 1 << 16;
  for (const float scale : {1.f, 1000.f}) {
    const auto buffer = test::test_buffer<float4>(n);
    test::run_kernel(warp_program(), "sine_table", n, 64,
                     [&](PassBuilder& pass) { pass.arg("count", n).arg("scale", scale).arg("values", buffer); });
    double worst = 0;
    for (const float4& v : buffer.download()) {
      worst = std::max(worst, std::abs(std::sin(2 * pi * double(v.x)) - v.y));
      worst = std::max(worst, std::abs(std::cos(2 * pi * double(v.x)) - v.z));
    }
    CHECK(worst < 2e-7);
  }
}

TEST_CASE("atan2_turns is as exact as single precision allows, at any radius") {
  const uint n = 1 << 16;
  const auto buffer = test::test_buffer<float4>(n);
  test::run_kernel(warp_program(), "angle_table", n, 64,
                   [&](PassBuilder& pass) { pass.arg("count", n).arg("values", buffer); });
  double worst = 0;
  for (const float4& v : buffer.download()) {
    const double exact = std::atan2(double(v.y), double(v.x)) / (2 * pi);
    worst = std::max(worst, std::abs(exact - v.z) / std::abs(exact));
  }
  CHECK(worst < 4e-7);
}

TEST_CASE("the chi-squared helper gives the textbook's values") {
  CHECK(test::chi2_p_value(3.841458820694124, 1) == test::relative(0.05, 1e-9));
  CHECK(test::chi2_p_value(18.307038053275146, 10) == test::relative(0.05, 1e-9));
  CHECK(test::chi2_p_value(1074.679449, 1000) == test::relative(0.05, 1e-6));
  CHECK(test::chi2_p_value(900, 1000) == test::relative(0.9894, 1e-3));
  CHECK(test::chi2_test({10, 0, 3}, {10, 0, 3}).stray == 0);
  CHECK(test::chi2_test({10, 1, 3}, {10, 0, 3}).stray == 1);
  // A sampler that puts 3 % too many points into one half fails.
  CHECK(test::chi2_test({51500, 48500}, {50000, 50000}).p < 1e-6);
}
