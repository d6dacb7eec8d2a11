// SPDX-License-Identifier: Apache-2.0
// The warps between micro-buffers and directions.
#include <doctest/doctest.h>

#include "lucarium/base/numbers.h"
#include "synthetic_forest.h"

using namespace lucarium;
using test::Defines;
using test::dvec3;

namespace {

struct Square {
  std::vector<float4> directions, values;
  std::vector<float2> back;
};

Square warp_square(const Defines& defines, uint32_t lobe, uint32_t edge, const glm::vec3& view, float alpha,
                   float eta = 0) {
  const Program& program = test::micro_program("test_micro_rendering/gather/warp.cl", defines);
  const size_t count = static_cast<size_t>(edge) * edge;
  const auto directions = test::test_buffer<float4>(count), values = test::test_buffer<float4>(count);
  const auto back = test::test_buffer<float2>(count);
  test::run_kernel(program, "warp_square", count, 1, [&](PassBuilder& pass) {
    pass.arg("lobe", lobe).arg("edge", edge).arg("view", float4(view, alpha)).arg("eta", eta);
    pass.arg("directions", directions).arg("values", values).arg("back", back);
  });
  return {directions.download(), values.download(), back.download()};
}

const glm::vec3 slanted(float degrees) {
  const float a = glm::radians(degrees);
  return {0.6f * std::sin(a), 0.8f * std::sin(a), std::cos(a)};
}

/// Height-correlated GGX of bsdf.clh without Fresnel's factor, times the cosine, and Phong's lobe.
double ggx(const dvec3& v, const dvec3& l, double alpha) {
  const dvec3 h = glm::normalize(v + l);
  const double a2 = alpha * alpha, t = h.z * h.z * (a2 - 1) + 1, d = a2 / (pi * t * t);
  return d * 0.5 / (l.z * std::sqrt(a2 + (1 - a2) * v.z * v.z) + v.z * std::sqrt(a2 + (1 - a2) * l.z * l.z)) * l.z;
}
double phong(const dvec3& v, const dvec3& l, double alpha) {
  const double n = 2 / (alpha * alpha) - 2;
  return (n + 2) / (2 * pi) * std::pow(std::max(glm::dot(l, dvec3(-v.x, -v.y, v.z)), 0.0), n) * l.z;
}

/// Walter et al. 2007, eq. 21, without 1 - F, times the cosine; l on the far side, where z is mirrored, and v too.
double refraction(const dvec3& v, const dvec3& l, double alpha, double eta) {
  const dvec3 down(l.x, l.y, -l.z);
  dvec3 h = glm::normalize(eta * v + down);
  if (h.z < 0) h = -h;
  const double vh = glm::dot(v, h), lh = -glm::dot(down, h);
  if (vh <= 0 || lh <= 0) return 0;
  const double a2 = alpha * alpha, t = h.z * h.z * (a2 - 1) + 1, d = a2 / (pi * t * t);
  // G2 / (4 cos cos), height-correlated.
  const double visibility =
      0.5 / (l.z * std::sqrt(a2 + (1 - a2) * v.z * v.z) + v.z * std::sqrt(a2 + (1 - a2) * l.z * l.z));
  return eta * eta * 4 * vh * lh / std::pow(eta * vh - lh, 2) * d * visibility * l.z;
}

/// Integral of f(l) cos L(l) over the hemisphere, L a smooth light; midpoints in both angles.
template <class F>
double quadrature(F f) {
  const int rows = 800, columns = 1600;
  double sum = 0;
  for (int i = 0; i < rows; ++i)
    for (int j = 0; j < columns; ++j) {
      const double theta = 0.5 * pi * (i + 0.5) / rows, phi = 2 * pi * (j + 0.5) / columns, s = std::sin(theta);
      sum += s * f(dvec3(s * std::cos(phi), s * std::sin(phi), std::cos(theta)));
    }
  return sum * pi * pi / (double(rows) * columns);
}
double light(const dvec3& l) { return 1 + 0.5 * l.x - 0.3 * l.y + 0.4 * l.x * l.y; }

double weighted(const Square& square) {
  double sum = 0;
  for (size_t i = 0; i < square.directions.size(); ++i) {
    const dvec3 w = square.directions[i].xyz();
    if (w.z > 0) sum += square.values[i].y * light(w);
  }
  return sum / static_cast<double>(square.directions.size());
}

}  // namespace

TEST_CASE("the inverse warp undoes the warp") {
  for (const char* warp : {"0", "1"})
    for (uint32_t lobe = 0; lobe < 2; ++lobe)
      for (const float alpha : {0.02f, 0.1f, 0.5f, 1.f})
        for (const float angle : {0.f, 30.f, 60.f, 80.f}) {
          if (warp[0] == '1' && lobe == 1 && alpha < 0.05f) continue;  // narrower than a cell
          CAPTURE(warp[0]);
          CAPTURE(lobe);
          CAPTURE(alpha);
          CAPTURE(angle);
          const Square square = warp_square({{"MICRO_WARP", warp}}, lobe, 64, slanted(angle), alpha);
          double worst = 0;
          for (size_t i = 0; i < square.back.size(); ++i) {
            // A warp may reach below the horizon, where there is no inverse.
            if (!(square.directions[i].z > 1e-3f)) continue;
            worst = std::max<double>({worst, std::abs(square.back[i].x), std::abs(square.back[i].y)});
          }
          CHECK(worst < 1e-5);
        }
}

TEST_CASE("solid angles of micro-pixels are those of the mapping, by its differences") {
  // Cells between the midpoints of a fine square; the concentric map's kinks lie on its diagonals.
  constexpr uint32_t edge = 384;
  struct Lobe {
    const char* warp;
    uint32_t lobe;
    float alpha, angle;
  };
  for (const Lobe& c : {Lobe{"0", 0, 1, 0}, Lobe{"1", 0, 1, 0}, Lobe{"0", 1, 0.3f, 40}, Lobe{"0", 1, 0.1f, 60}}) {
    CAPTURE(c.warp[0]);
    CAPTURE(c.lobe);
    CAPTURE(c.alpha);
    const Square square = warp_square({{"MICRO_WARP", c.warp}}, c.lobe, edge, slanted(c.angle), c.alpha);
    double projected = 0, share = 0, masses = 0, cells = 0;
    for (uint32_t y = 0; y + 1 < edge; ++y) {
      for (uint32_t x = 0; x + 1 < edge; ++x) {
        const size_t corner[4] = {y * edge + x, y * edge + x + 1, (y + 1) * edge + x + 1, (y + 1) * edge + x};
        dvec3 w[4];
        double density = 0, lowest = 1;
        for (int k = 0; k < 4; ++k) {
          w[k] = square.directions[corner[k]].xyz();
          lowest = std::min(lowest, w[k].z);
          density += 0.25 * square.values[corner[k]].x;
        }
        if (lowest < 0.1) continue;  // densities fall to zero at the horizon: differences say nothing there
        const double angle = 0.5 * glm::length(glm::cross(w[2] - w[0], w[3] - w[1]));
        masses += angle * density * edge * edge;
        ++cells;
        projected += angle * 0.25 * (w[0].z + w[1].z + w[2].z + w[3].z);
        share += pi / (double(edge) * edge);
      }
    }
    MESSAGE("solid angle times N p " << masses / cells << ", projected " << projected / share);
    CHECK(std::abs(masses / cells - 1) < 0.005);
    // Equal shares of pi; a table's are those of its cells' centres.
    if (c.lobe == 0) CHECK(std::abs(projected / share - 1) < (c.warp[0] == '0' ? 0.001 : 0.005));
  }
}

TEST_CASE("solid angles of Lambert's micro-pixels") {
  for (const uint32_t edge : {8u, 16u, 24u, 48u}) {
    CAPTURE(edge);
    const Square square = warp_square({}, 0, edge, {0, 0, 1}, 1);
    double solid = 0;
    const double pixels = double(edge) * edge;
    for (size_t i = 0; i < square.directions.size(); ++i) {
      const double density = square.values[i].x;  // p_omega
      solid += 1 / density / pixels;
    }
    CHECK(std::abs(solid / (2 * pi) - (1 - 0.61 / std::sqrt(double(edge)))) < 0.005);
  }
}

TEST_CASE("the mean over the warped pixels is the reflected light") {
  const double diffuse = quadrature([](const dvec3& l) { return l.z / pi * light(l); });
  for (const char* warp : {"0", "1"}) {
    const Square square = warp_square({{"MICRO_WARP", warp}}, 0, 24, {0, 0, 1}, 1);
    CHECK(std::abs(weighted(square) / diffuse - 1) < 0.003);
  }
  const glm::vec3 v = slanted(60);
  const dvec3 view = v;
  for (const double alpha : {0.5, 0.3, 0.1}) {
    CAPTURE(alpha);
    const double expected = quadrature([&](const dvec3& l) { return ggx(view, l, alpha) * light(l); });
    CHECK(std::abs(weighted(warp_square({}, 1, 24, v, float(alpha))) / expected - 1) < 0.03);
    CHECK(std::abs(weighted(warp_square({{"MICRO_WARP", "1"}}, 1, 24, v, float(alpha))) / expected - 1) < 0.015);
  }
  for (const double exponent : {1.0, 5.0, 20.0}) {
    CAPTURE(exponent);
    const double alpha = std::sqrt(2 / (exponent + 2));
    const double expected = quadrature([&](const dvec3& l) { return phong(view, l, alpha) * light(l); });
    const Square square = warp_square({{"MICRO_WARP", "1"}, {"LUCARIUM_PHONG", ""}}, 1, 24, v, float(alpha));
    CHECK(std::abs(weighted(square) / expected - 1) < 0.015);
  }
}

TEST_CASE("tables hold all of a lobe, however narrow") {
  for (const double alpha : {0.02, 0.1, 0.3})
    for (const float angle : {0.f, 40.f, 60.f, 75.f}) {
      const glm::vec3 v = slanted(angle);
      const dvec3 view = v;
      const double expected = quadrature([&](const dvec3& l) { return ggx(view, l, alpha) * light(l); });
      for (const int size : {8, 16, 32, 64}) {
        if (size == 8 && (alpha < 0.1 || angle > 60)) continue;  // cells that are much wider than the lobe displace it
        CAPTURE(alpha);
        CAPTURE(angle);
        CAPTURE(size);
        const Square square =
            warp_square({{"MICRO_WARP", "1"}, {"MICRO_TABLE_SIZE", std::to_string(size)}}, 1, 24, v, float(alpha));
        CHECK(std::abs(weighted(square) / expected - 1) < 0.015);
      }
    }
}

TEST_CASE("unwarped cells inside the disc are weighted by the lobe") {
  const double diffuse = quadrature([](const dvec3& l) { return l.z / pi * light(l); });
  CHECK(std::abs(weighted(warp_square({{"MICRO_WARP", "2"}}, 0, 64, {0, 0, 1}, 1)) / diffuse - 1) < 0.01);
}

TEST_CASE("the refracted lobe: its inverse, its solid angles and its integral") {
  for (const float eta : {1 / 1.5f, 1.5f})
    for (const float angle : {0.f, 15.f, 30.f, 60.f})
      for (const float alpha : {0.1f, 0.3f, 0.5f}) {
        // Whole rings of midpoints lie on one side of the critical angle or the other; there is none under it at 60
        // degrees.
        if (eta > 1 && (angle == 0 || (angle == 60 && alpha == 0.1f))) continue;
        CAPTURE(eta);
        CAPTURE(angle);
        CAPTURE(alpha);
        const glm::vec3 v = slanted(angle);
        const dvec3 view = v;
        const double expected =
            quadrature([&](const dvec3& l) { return refraction(view, l, double(alpha), double(eta)) * light(l); });
        const Square square = warp_square({}, 2, 24, v, alpha, eta);
        CHECK(std::abs(weighted(square) / expected - 1) < 0.03);
        double worst = 0, back = 0;
        for (size_t i = 0; i < square.back.size(); ++i) {
          const dvec3 w = square.directions[i].xyz();
          if (!(w.z > 1e-2)) continue;
          back = std::max<double>({back, std::abs(square.back[i].x), std::abs(square.back[i].y)});
          worst =
              std::max(worst, std::abs(square.values[i].w * w.z / refraction(view, w, double(alpha), double(eta)) - 1));
        }
        CHECK(back < 1e-4);
        CHECK(worst < 1e-3);
        if (alpha > 0.2f && eta < 1)
          CHECK(std::abs(weighted(warp_square({{"MICRO_WARP", "1"}}, 2, 24, v, alpha, eta)) / expected - 1) < 0.03);
      }
}
