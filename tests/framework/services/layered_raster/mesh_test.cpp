// SPDX-License-Identifier: Apache-2.0
// Shared edges: closed meshes have as many fronts as backs in every pixel, fans cover each pixel once. Conservative
// coverage, and MASK and BLEND.
#include <doctest/doctest.h>

#include "lucarium/scene/builtin/builder.h"
#include "scene.h"
#include "test_support.h"
#include "tolerance.h"

using namespace lucarium;
using namespace lucarium::test;

namespace {

/// An image of size² pixels over the sphere of the given radius about the origin.
LayeredView view_along(const glm::vec3& direction, float radius, uint32_t size, float shift = 0) {
  const glm::vec3 other = std::abs(direction.x) < 0.9f ? glm::vec3(1, 0, 0) : glm::vec3(0, 1, 0);
  const glm::vec3 right = glm::normalize(glm::cross(other, direction));
  const float pixel = 2 * radius / static_cast<float>(size);
  return orthographic_view({}, direction, right, pixel, size, size, radius, glm::vec2(-radius - shift * pixel));
}

Soup ball_soup(int levels) {
  Soup soup;
  for (const auto& face : icosphere(levels)) soup.add_triangle(face[0], face[1], face[2]);
  return soup;
}

}  // namespace

TEST_CASE("a convex closed mesh has a front and a back in every pixel, or nothing") {
  constexpr uint32_t size = 150;
  LayeredScene scene(scene_of(ball_soup(3)), {.max_width = size, .max_height = size});
  Random random(1);
  for (int i = 0; i < 5; ++i) {
    const HostLayers layers = scene.store(view_along(random.direction(), 1.1f, size, random.uniform()));
    uint32_t wrong = 0, covered = 0;
    for (uint32_t y = 0; y < size; ++y)
      for (uint32_t x = 0; x < size; ++x) {
        const auto pixel = layers.at(x, y);
        if (pixel.empty()) continue;
        ++covered;
        if (pixel.size() != 2) {
          ++wrong;
          continue;
        }
        const bool tie = pixel[1].depth - pixel[0].depth < 1e-5f;
        wrong += ((pixel[0].triangle ^ pixel[1].triangle) & LAYERED_AWAY) == 0;
        wrong += !tie && (pixel[0].triangle & LAYERED_AWAY) != 0;
      }
    CHECK(wrong == 0);
    CHECK(covered == test::relative(3.14159 / 4 * size * size / 1.21, 0.01));
  }
}

TEST_CASE("a closed mesh has as many fronts as backs in every pixel, in turns") {
  constexpr uint32_t size = 120;
  LayeredScene scene(scene_of(rough_sphere(40, 60, 5)), {.max_width = size, .max_height = size});
  Random random(2);
  for (int i = 0; i < 5; ++i) {
    const HostLayers layers = scene.store(view_along(random.direction(), 1.6f, size, random.uniform()));
    uint32_t unbalanced = 0, out_of_turn = 0;
    for (uint32_t y = 0; y < size; ++y)
      for (uint32_t x = 0; x < size; ++x) {
        const auto pixel = layers.at(x, y);
        int balance = 0;
        for (size_t k = 0; k < pixel.size(); ++k) {
          const bool away = pixel[k].triangle & LAYERED_AWAY;
          balance += away ? -1 : 1;
          // Where surfaces meet at less than the snapping of vertices moves them, their order is free.
          const bool apart = (k == 0 || pixel[k].depth - pixel[k - 1].depth > 0.01f) &&
                             (k + 1 == pixel.size() || pixel[k + 1].depth - pixel[k].depth > 0.01f);
          out_of_turn += apart && away != (k % 2 == 1);
        }
        unbalanced += balance != 0;
      }
    CHECK(layers.fragments.size() > size * size / 2);
    CHECK(unbalanced == 0);
    CHECK(out_of_turn == 0);
  }
}

TEST_CASE("triangles without area have no fragments, wherever their corners are snapped to") {
  constexpr uint32_t size = 100;
  Random random(3);
  Soup lines;
  for (int i = 0; i < 60; ++i) {
    glm::vec3 corners[3] = {random.in_cube(0.6f)};
    for (int k = 1; k < 3; ++k) {
      corners[k] = corners[0];
      corners[k][i % 3] = random.uniform(-0.6f, 0.6f);
    }
    lines.add_triangle(corners[0], corners[1], corners[2]);
  }
  LayeredScene scene(scene_of(lines), {.max_width = size, .max_height = size});
  for (int i = 0; i < 20; ++i) CHECK(scene.store(view_along(random.direction(), 1.1f, size)).fragments.empty());
}

TEST_CASE("lines among triangles take nothing away from them, were it the thinnest") {
  constexpr uint32_t size = 100, count = 2400;  // 150 blocks
  for (const uint32_t step : {2390u, 13u}) {    // two lines, then some in every block
    CAPTURE(step);
    Random random(4);
    Soup with_lines, without;
    for (uint32_t i = 0; i < count; ++i) {
      const glm::vec3 a = random.in_cube(0.6f), edge = random.in_cube(0.3f);
      const bool needle = i % 3 == 0;  // of a few units in the last place, with a corner along its edge
      const bool line = i % step == 5;
      const glm::vec3 c = line ? a : a + (needle ? 0.4f : 1.f) * edge + (needle ? 3e-7f : 0.3f) * random.in_cube(1);
      with_lines.add_triangle(a, a + edge, c);
      if (line) {
        without.add_triangle(glm::vec3(9, 0, 0), glm::vec3(9, 1, 0), glm::vec3(9, 0, 1));  // beside the image
      } else {
        without.add_triangle(a, a + edge, c);
      }
    }
    LayeredScene scene(scene_of(with_lines), {.max_width = size, .max_height = size});
    LayeredScene other(scene_of(without), {.max_width = size, .max_height = size});
    const LayeredView view = view_along(random.direction(), 1.1f, size);
    const HostLayers got = scene.store(view), expected = other.store(view);
    CHECK(got.pixel_start == expected.pixel_start);
    REQUIRE(got.fragments.size() == expected.fragments.size());
    CHECK(std::memcmp(got.fragments.data(), expected.fragments.data(),
                      got.fragments.size() * sizeof(LayeredFragment)) == 0);
    const bool needles = std::any_of(got.fragments.begin(), got.fragments.end(),
                                     [](const LayeredFragment& f) { return (f.triangle & ~LAYERED_AWAY) % 3 == 0; });
    CHECK(needles);
  }
}

TEST_CASE("fans about pixel centres cover each pixel once") {
  for (const uint32_t spokes : {3u, 4u, 8u, 17u, 100u}) {
    CAPTURE(spokes);
    Soup soup;
    const glm::vec3 center(20.5f, 20.5f, 0);
    std::vector<glm::vec3> rim;
    for (uint32_t i = 0; i < spokes; ++i) {
      const float angle = 6.2831853f * static_cast<float>(i) / static_cast<float>(spokes);
      // Corners on pixel centres and edges through them.
      rim.push_back({std::round(18 * std::cos(angle)) + 20.5f, std::round(18 * std::sin(angle)) + 20.5f, 1});
    }
    for (uint32_t i = 0; i < spokes; ++i) soup.add_triangle(center, rim[i], rim[(i + 1) % spokes]);
    LayeredScene scene(scene_of(soup), {.max_width = 41, .max_height = 41});
    const HostLayers layers = scene.store(pixel_view(41, 41));
    uint32_t twice = 0, holes = 0;
    for (uint32_t y = 0; y < 41; ++y)
      for (uint32_t x = 0; x < 41; ++x) {
        twice += layers.at(x, y).size() > 1;
        double inside = 1e9;
        for (uint32_t i = 0; i < spokes; ++i) {
          const glm::dvec2 a = rim[i], b = rim[(i + 1) % spokes];
          inside = std::min(inside, (b.x - a.x) * (y + 0.5 - a.y) - (b.y - a.y) * (x + 0.5 - a.x));
        }
        holes += inside > 0 && layers.at(x, y).size() != 1;
      }
    CHECK(twice == 0);
    CHECK(holes == 0);
  }
}

TEST_CASE("conservative coverage holds every pixel that a triangle touches, and few others") {
  constexpr uint32_t width = 100, height = 80;
  Soup soup = image_triangles(60, width, height, 3);
  Random random(4);
  for (int i = 0; i < 60; ++i) {  // needles and specks that cover no centre
    const glm::vec3 a(random.uniform(0, width), random.uniform(0, height), 0);
    const glm::vec3 b = a + random.in_cube(i % 2 ? 30.f : 0.2f);
    soup.add_triangle(a, b, glm::mix(a, b, 0.3f) + random.in_cube(0.05f));
  }
  LayeredScene scene(scene_of(soup), {.max_width = width, .max_height = height, .conservative = true});
  const HostLayers layers = scene.store(pixel_view(width, height));
  // Separating axes of a square of half width `half` and a triangle.
  const auto touches = [&](const Triangle& t, double x, double y, double half) {
    const glm::dvec2 v[3] = {soup.corner(t.v0), soup.corner(t.v1), soup.corner(t.v2)};
    std::vector<glm::dvec2> axes = {{1, 0}, {0, 1}};
    for (int k = 0; k < 3; ++k) axes.emplace_back(v[k].y - v[(k + 1) % 3].y, v[(k + 1) % 3].x - v[k].x);
    for (const glm::dvec2& axis : axes) {
      const double reach = half * (std::abs(axis.x) + std::abs(axis.y)), at = axis.x * x + axis.y * y;
      const double d[3] = {glm::dot(axis, v[0]) - at, glm::dot(axis, v[1]) - at, glm::dot(axis, v[2]) - at};
      if (std::min({d[0], d[1], d[2]}) > reach || std::max({d[0], d[1], d[2]}) < -reach) return false;
    }
    return true;
  };
  uint32_t missing = 0, needless = 0;
  for (uint32_t y = 0; y < height; ++y)
    for (uint32_t x = 0; x < width; ++x) {
      std::vector<bool> found(soup.triangles.size());
      for (const LayeredFragment& f : layers.at(x, y)) found[f.triangle & ~LAYERED_AWAY] = true;
      for (uint32_t t = 0; t < soup.triangles.size(); ++t) {
        missing += !found[t] && touches(soup.triangles[t], x + 0.5, y + 0.5, 0.5);
        needless += found[t] && !touches(soup.triangles[t], x + 0.5, y + 0.5, 0.52);
      }
    }
  CHECK(missing == 0);
  CHECK(needless == 0);
}

TEST_CASE("MASK discards, BLEND keeps with probability alpha") {
  Soup soup;
  soup.add_triangle({-10, -10, 1}, {300, -10, 1}, {-10, 300, 1});
  soup.add_triangle({-10, -10, 2}, {300, -10, 2}, {-10, 300, 2});
  const auto fragments = [&](AlphaMode mode, float alpha, uint32_t seed,
                             LayeredVariant variant = LayeredVariant::tiles) {
    SceneMaterial material;
    material.alpha_mode = mode;
    material.base_color.w = alpha;
    LayeredScene scene(scene_of(soup, material), {.max_width = 100, .max_height = 100});
    LayeredView view = pixel_view(100, 100);
    view.seed = seed;
    return scene.store(view, {.variant = variant});
  };
  CHECK(fragments(AlphaMode::mask, 0.4f, 1).fragments.empty());
  CHECK(fragments(AlphaMode::mask, 0.6f, 1).fragments.size() == 20000);
  const HostLayers blended = fragments(AlphaMode::blend, 0.3f, 1);
  // Binomial, standard deviation 65; both triangles decide by themselves.
  CHECK(std::abs(static_cast<int>(blended.fragments.size()) - 6000) < 300);
  uint32_t both = 0;
  for (uint32_t y = 0; y < 100; ++y)
    for (uint32_t x = 0; x < 100; ++x) both += blended.at(x, y).size() == 2;
  CHECK(std::abs(static_cast<int>(both) - 900) < 150);
  // Neighbours decide by themselves: 99 pairs in each of 100 rows.
  uint32_t pairs = 0;
  const auto nearer = [&](uint32_t x, uint32_t y) {
    return !blended.at(x, y).empty() && (blended.at(x, y)[0].triangle & ~LAYERED_AWAY) == 0;
  };
  for (uint32_t y = 0; y < 100; ++y)
    for (uint32_t x = 1; x < 100; ++x) pairs += nearer(x - 1, y) && nearer(x, y);
  CHECK(std::abs(static_cast<int>(pairs) - 891) < 180);
  CHECK(fragments(AlphaMode::blend, 0.3f, 1).pixel_start == blended.pixel_start);
  CHECK(fragments(AlphaMode::blend, 0.3f, 1, LayeredVariant::exact).pixel_start == blended.pixel_start);
  CHECK(fragments(AlphaMode::blend, 0.3f, 2).pixel_start != blended.pixel_start);
}
