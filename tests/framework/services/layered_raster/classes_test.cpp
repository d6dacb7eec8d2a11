// SPDX-License-Identifier: Apache-2.0
// Classes of triangles and the masks of views: what is drawn, closed forms per class, and MASK and BLEND kept.
#include <doctest/doctest.h>

#include <algorithm>

#include "scene.h"
#include "test_support.h"
#include "tolerance.h"

using namespace lucarium;
using namespace lucarium::test;

namespace {

constexpr uint8_t ball = 1, other_ball = 2, plate = 4;

void append(Soup& soup, const Soup& more) {
  const auto first = static_cast<uint32_t>(soup.vertices.size());
  soup.vertices.insert(soup.vertices.end(), more.vertices.begin(), more.vertices.end());
  for (const Triangle& t : more.triangles) soup.triangles.push_back({first + t.v0, first + t.v1, first + t.v2, 0});
}

/// Two closed bodies that overlap and an open plate, and the class of each triangle.
Soup bodies(std::vector<uint8_t>& classes) {
  Soup soup = rough_sphere(30, 40, 5, {-0.2f, 0.1f, 0});
  classes.assign(soup.triangles.size(), ball);
  append(soup, rough_sphere(24, 30, 6, {0.4f, -0.1f, 0.2f}));
  classes.resize(soup.triangles.size(), other_ball);
  const glm::vec3 a(-1.2f, -1, -1.1f), b(1.3f, -0.9f, -0.4f), c(1.2f, 1.1f, 0.9f), d(-1.3f, 1, 0.2f);
  soup.add_triangle(a, b, c);
  soup.add_triangle(a, c, d);
  classes.resize(soup.triangles.size(), plate);
  return soup;
}

/// An image of size² pixels along +k, x along the next axis, of the cube of half width `radius`.
LayeredView axis_view(int k, float radius, uint32_t size, uint32_t classes) {
  glm::vec3 direction(0), right(0);
  direction[k] = right[(k + 1) % 3] = 1;
  LayeredView view = orthographic_view({}, direction, right, 2 * radius / static_cast<float>(size), size, size, radius,
                                       glm::vec2(-radius));
  view.classes = classes;
  return view;
}

glm::dvec3 area_vector(const Soup& soup, uint32_t triangle) {
  const Triangle& t = soup.triangles[triangle];
  const glm::dvec3 a(soup.corner(t.v0)), b(soup.corner(t.v1)), c(soup.corner(t.v2));
  return 0.5 * glm::cross(b - a, c - a);
}

int dominant_axis(const glm::dvec3& n) {
  const glm::dvec3 size = glm::abs(n);
  return size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
}

}  // namespace

TEST_CASE("fragments of a class are its projected area in pixels, and closed classes balance every column") {
  constexpr uint32_t size = 900;
  constexpr float radius = 2.1f;
  const double pixel_area = 4.0 * radius * radius / (double{size} * size);
  std::vector<uint8_t> classes;
  const Soup soup = bodies(classes);
  LayeredScene scene(scene_of(soup), {.max_width = size, .max_height = size, .classes = true});
  for (const uint32_t mask : {uint32_t{ball}, uint32_t{other_ball}, uint32_t{plate}, uint32_t{ball | other_ball}}) {
    CAPTURE(mask);
    size_t fragments = 0, others = 0, unbalanced = 0;
    double expected = 0;
    for (uint32_t t = 0; t < soup.triangles.size(); ++t)
      if (classes[t] & mask) {
        const glm::dvec3 n = glm::abs(area_vector(soup, t));
        expected += (n.x + n.y + n.z) / pixel_area;
      }
    for (int k = 0; k < 3; ++k) {
      const HostLayers layers = scene.store(axis_view(k, radius, size, mask), {}, classes);
      fragments += layers.fragments.size();
      for (uint32_t y = 0; y < size; ++y)
        for (uint32_t x = 0; x < size; ++x) {
          int balance = 0;
          for (const LayeredFragment& f : layers.at(x, y)) {
            balance += f.triangle & LAYERED_AWAY ? 1 : -1;
            others += !(classes[f.triangle & ~LAYERED_AWAY] & mask);
          }
          unbalanced += balance != 0;
        }
    }
    CHECK(static_cast<double>(fragments) == test::relative(expected, 1e-3));
    CHECK(others == 0);
    if (mask == plate)
      CHECK(unbalanced == fragments);
    else
      CHECK(unbalanced == 0);
  }
}

TEST_CASE("masks share the fragments out: together they are all, none has another's") {
  constexpr uint32_t size = 130;
  std::vector<uint8_t> classes;
  Soup soup = bodies(classes);
  // One that is clipped, of a class of its own, behind the others.
  soup.add_triangle({-1e5f, -2e5f, 2}, {3e5f, 0, 2}, {-1e5f, 2e5f, 2});
  classes.push_back(128);
  LayeredScene with(scene_of(soup), {.max_width = size, .max_height = size, .classes = true});
  LayeredScene without(scene_of(soup), {.max_width = size, .max_height = size});
  for (const LayeredVariant variant : {LayeredVariant::tiles, LayeredVariant::exact, LayeredVariant::linked_list}) {
    const LayeredStoreOptions options{.variant = variant};
    const auto store = [&](uint32_t mask) { return with.store(axis_view(2, 2.1f, size, mask), options, classes); };
    const HostLayers all = without.store(axis_view(2, 2.1f, size, 0), options);
    CHECK(same_layers(store(255), all));
    CHECK(store(64).fragments.empty());
    CHECK(store(128).fragments.size() == size_t{size} * size);
    // Fragments of a mask are those of all whose class it has, in the same order.
    for (const uint32_t mask : {1u, 2u, 4u, 6u, 128u, 129u}) {
      CAPTURE(mask);
      const HostLayers some = store(mask);
      uint32_t wrong = 0;
      for (uint32_t y = 0; y < size; ++y)
        for (uint32_t x = 0; x < size; ++x) {
          std::vector<LayeredFragment> expected;
          for (const LayeredFragment& f : all.at(x, y))
            if (classes[f.triangle & ~LAYERED_AWAY] & mask) expected.push_back(f);
          const auto found = some.at(x, y);
          const auto same = [](const LayeredFragment& a, const LayeredFragment& b) {
            return std::memcmp(&a, &b, sizeof a) == 0;
          };
          wrong += !std::ranges::equal(found, expected, same);
        }
      CHECK(wrong == 0);
    }
  }
}

TEST_CASE("conservative views of the dominant axes hold every triangle, each in one view") {
  constexpr uint32_t size = 64;
  std::vector<uint8_t> classes;
  const Soup soup = bodies(classes);
  for (uint32_t t = 0; t < soup.triangles.size(); ++t)
    classes[t] = static_cast<uint8_t>(1 << dominant_axis(area_vector(soup, t)));
  LayeredScene scene(scene_of(soup), {.max_width = size, .max_height = size, .conservative = true, .classes = true});
  std::vector<uint8_t> seen(soup.triangles.size(), 0);
  for (int k = 0; k < 3; ++k)
    for (const LayeredFragment& f : scene.store(axis_view(k, 2.1f, size, 1u << k), {}, classes).fragments)
      seen[f.triangle & ~LAYERED_AWAY] |= static_cast<uint8_t>(1 << k);
  CHECK(seen == classes);
}

TEST_CASE("kept alpha: MASK and BLEND have the fragments of opaque triangles") {
  constexpr uint32_t width = 90, height = 70;
  const Soup soup = image_triangles(300, width, height, 4);
  const auto fragments = [&](AlphaMode mode, bool keep) {
    SceneMaterial material;
    material.alpha_mode = mode;
    material.base_color.w = 0.4f;
    LayeredScene scene(scene_of(soup, material), {.max_width = width, .max_height = height, .keep_alpha = keep});
    return scene.store(pixel_view(width, height));
  };
  const HostLayers opaque = fragments(AlphaMode::opaque, false);
  CHECK(opaque.fragments.size() > 10000);
  CHECK(same_layers(fragments(AlphaMode::opaque, true), opaque));
  for (const AlphaMode mode : {AlphaMode::mask, AlphaMode::blend}) {
    CHECK(same_layers(fragments(mode, true), opaque));
    CHECK(fragments(mode, false).fragments.size() < opaque.fragments.size() / 2);
  }
}
