// SPDX-License-Identifier: Apache-2.0
// Which pixels LayeredRaster covers and in which order, against edge functions in double precision, which are exact for
// vertices on the grid of 1/256 pixel.
#include <doctest/doctest.h>

#include <cmath>

#include "scene.h"
#include "test_support.h"

using namespace lucarium;
using namespace lucarium::test;

namespace {

/// Doubled signed area of (a, b, p); positive when p lies on the side of the front of a triangle that faces along the
/// view.
double edge(const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& p) {
  return (b.x - a.x) * (p.y - a.y) - (b.y - a.y) * (p.x - a.x);
}

/// Whether a centre exactly on this edge of a positively oriented triangle belongs to it (y downwards: left and top).
bool owns_edge(const glm::dvec2& a, const glm::dvec2& b) { return b.y < a.y || (b.y == a.y && b.x > a.x); }

/// -1: not covered; otherwise 1 when the front faces along the view, else 0.
int covers(const std::array<glm::vec3, 3>& corners, const glm::dvec2& p) {
  std::array<glm::dvec2, 3> v = {glm::dvec2(corners[0]), glm::dvec2(corners[1]), glm::dvec2(corners[2])};
  const double area = edge(v[0], v[1], v[2]);
  if (area == 0) return -1;
  if (area < 0) std::swap(v[1], v[2]);
  for (int k = 0; k < 3; ++k) {
    const glm::dvec2 &a = v[k], &b = v[(k + 1) % 3];
    const double value = edge(a, b, p);
    if (value < 0 || (value == 0 && !owns_edge(a, b))) return -1;
  }
  return area > 0;
}

double depth_at(const std::array<glm::vec3, 3>& c, const glm::dvec2& p) {
  const double area = edge(glm::dvec2(c[0]), glm::dvec2(c[1]), glm::dvec2(c[2]));
  return (edge(glm::dvec2(c[1]), glm::dvec2(c[2]), p) * c[0].z + edge(glm::dvec2(c[2]), glm::dvec2(c[0]), p) * c[1].z +
          edge(glm::dvec2(c[0]), glm::dvec2(c[1]), p) * c[2].z) /
         area;
}

/// What interpolation in single precision from a tile's corner may lose: much for slivers, whose depth has steep
/// slopes.
double depth_error(const std::array<glm::vec3, 3>& c) {
  const double area = std::abs(edge(glm::dvec2(c[0]), glm::dvec2(c[1]), glm::dvec2(c[2])));
  double longest = 0, range = 0;
  for (int k = 0; k < 3; ++k) {
    longest = std::max(longest, glm::length(glm::dvec2(c[k]) - glm::dvec2(c[(k + 1) % 3])));
    range = std::max(range, std::abs(double{c[k].z} - c[(k + 1) % 3].z));
  }
  return 1e-5 + range * std::min(1.0, 2e-6 + 4e-6 * longest / area);
}

std::array<glm::vec3, 3> corners_of(const Soup& soup, uint32_t triangle) {
  const Triangle& t = soup.triangles[triangle];
  return {soup.corner(t.v0), soup.corner(t.v1), soup.corner(t.v2)};
}

float on_grid(float value) { return std::round(value * 256) / 256; }

/// Triangles of all sizes, slivers, needles along rows and columns, and corners on pixel centres.
Soup mixed_triangles(uint32_t count, float width, float height, uint32_t seed) {
  Soup soup;
  Random random(seed);
  for (uint32_t i = 0; i < count; ++i) {
    const glm::vec2 center(random.uniform(-0.2f, 1.2f) * width, random.uniform(-0.2f, 1.2f) * height);
    const float size = width * std::exp(random.uniform(-5, 0.5f));
    std::array<glm::vec3, 3> c;
    for (glm::vec3& p : c)
      p = glm::vec3(center + size * glm::vec2(random.uniform(-1, 1), random.uniform(-1, 1)), random.uniform(-15, 15));
    if (i % 5 == 1) c[2] = glm::mix(c[0], c[1], random.uniform(0, 1)) + random.in_cube(0.02f);  // sliver
    if (i % 5 == 2)
      for (glm::vec3& p : c) p.x = std::floor(p.x) + 0.5f, p.y = std::floor(p.y) + 0.5f;
    if (i % 15 == 3) c[1].y = c[0].y;
    for (glm::vec3& p : c) p.x = on_grid(p.x), p.y = on_grid(p.y);
    soup.add_triangle(c[0], c[1], c[2]);
  }
  return soup;
}

/// What is less than a step apart is a tie, in which LAYERED_AWAY comes first: the others count as a step farther.
uint32_t depth_step(const LayeredFragment& f) {
  return static_cast<uint32_t>((f.depth + 16) / 32 * 4194304.0f) + (f.triangle & LAYERED_AWAY ? 0 : 1);
}

/// Every pixel: exactly the fragments of the oracle, with their side and depth, in order.
void check_against_oracle(const Soup& soup, const HostLayers& layers) {
  uint32_t wrong_pixels = 0, wrong_depths = 0, wrong_order = 0, fragments = 0;
  std::vector<std::vector<uint32_t>> expected(size_t{layers.width} * layers.height);
  for (uint32_t t = 0; t < soup.triangles.size(); ++t) {
    const auto c = corners_of(soup, t);
    const auto limit = [](float v, uint32_t size) { return static_cast<uint32_t>(std::clamp(v, 0.f, float(size))); };
    const uint32_t x1 = limit(std::max({c[0].x, c[1].x, c[2].x}) + 1, layers.width);
    const uint32_t y1 = limit(std::max({c[0].y, c[1].y, c[2].y}) + 1, layers.height);
    for (uint32_t y = limit(std::min({c[0].y, c[1].y, c[2].y}), layers.height); y < y1; ++y)
      for (uint32_t x = limit(std::min({c[0].x, c[1].x, c[2].x}), layers.width); x < x1; ++x)
        if (const int side = covers(c, {x + 0.5, y + 0.5}); side >= 0)
          expected[y * layers.width + x].push_back(t | (side ? LAYERED_AWAY : 0));
  }
  for (uint32_t y = 0; y < layers.height; ++y)
    for (uint32_t x = 0; x < layers.width; ++x) {
      std::vector<uint32_t> found;
      const auto pixel = layers.at(x, y);
      for (size_t i = 0; i < pixel.size(); ++i) {
        found.push_back(pixel[i].triangle);
        const auto c = corners_of(soup, pixel[i].triangle & ~LAYERED_AWAY);
        const double depth = depth_at(c, {x + 0.5, y + 0.5});
        const double slack = depth_error(c);
        wrong_depths += std::abs(depth - pixel[i].depth) > slack;
        if (i > 0) {
          const auto key = [](const LayeredFragment& f) {
            return std::tuple(depth_step(f), !(f.triangle & LAYERED_AWAY), f.triangle & ~LAYERED_AWAY);
          };
          wrong_order += !(key(pixel[i - 1]) < key(pixel[i]));
        }
        ++fragments;
      }
      auto& wanted = expected[y * layers.width + x];
      const auto by_triangle = [](uint32_t a, uint32_t b) { return (a & ~LAYERED_AWAY) < (b & ~LAYERED_AWAY); };
      std::sort(found.begin(), found.end(), by_triangle);
      wrong_pixels += found != wanted;
    }
  CHECK(fragments == layers.fragments.size());
  CHECK(fragments > 400);
  CHECK(wrong_pixels == 0);
  CHECK(wrong_depths == 0);
  CHECK(wrong_order == 0);
}

}  // namespace

TEST_CASE("coverage, sides, depths and order of random triangles") {
  for (const auto& [width, height, count] : {std::tuple(200u, 120u, 400u), std::tuple(17u, 33u, 200u)}) {
    CAPTURE(width);
    const Soup soup = mixed_triangles(count, float(width), float(height), count);
    LayeredScene scene(scene_of(soup), {.max_width = width, .max_height = height});
    check_against_oracle(soup, scene.store(pixel_view(width, height)));
  }
}

TEST_CASE("an image smaller than the largest") {
  const Soup soup = mixed_triangles(200, 50, 40, 7);
  LayeredScene scene(scene_of(soup), {.max_width = 100, .max_height = 90});
  HostLayers layers = scene.store(pixel_view(50, 40));
  check_against_oracle(soup, layers);
}

TEST_CASE("triangles far larger than the image of a few pixels that they reach") {
  for (const uint32_t size : {4u, 8u}) {
    CAPTURE(size);
    Soup soup;
    // Covers all of the first four by four pixels.
    soup.add_triangle({4, 4, 0}, {-200, 4, 0}, {4, -200, 0});
    Random random(size);
    for (int i = 0; i < 400; ++i) {
      const float radius = std::exp(random.uniform(3, 7.5f));
      std::array<glm::vec3, 3> c;
      for (glm::vec3& p : c)
        p = glm::vec3(on_grid(radius * random.uniform(-1, 1)), on_grid(radius * random.uniform(-1, 1)),
                      random.uniform(-15, 15));
      soup.add_triangle(c[0], c[1], c[2]);
    }
    LayeredScene scene(scene_of(soup), {.max_width = size, .max_height = size});
    check_against_oracle(soup, scene.store(pixel_view(size, size)));
  }
}

TEST_CASE("more fragments in a pixel than a row has layers") {
  const Soup soup = mixed_triangles(6000, 24, 20, 3);
  LayeredScene scene(scene_of(soup), {.max_width = 24, .max_height = 20});
  const HostLayers layers = scene.store(pixel_view(24, 20));
  size_t largest = 0;
  for (uint32_t y = 0; y < 20; ++y)
    for (uint32_t x = 0; x < 24; ++x) largest = std::max(largest, layers.at(x, y).size());
  CHECK(largest > 2 * LAYERED_MAX_LAYERS);
  check_against_oracle(soup, layers);
}
