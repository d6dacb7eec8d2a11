// SPDX-License-Identifier: Apache-2.0
// Perspective and cube views against rays in double precision; clipping at the near plane and of what is huge.
#include <doctest/doctest.h>

#include <optional>

#include "scene.h"
#include "test_support.h"
#include "tolerance.h"

using namespace lucarium;
using namespace lucarium::test;

namespace {

struct ImagePlane {
  glm::dvec3 eye, direction, right, down;  ///< right, down: per pixel at depth 1 (perspective) or at all (orthographic)
  double half_width, half_height;
  bool perspective;
};

/// Depth at which a point of the image sees a triangle's plane inside the triangle.
std::optional<double> see(const ImagePlane& plane, const Soup& soup, const Triangle& t, double x, double y) {
  const glm::dvec3 offset = plane.right * (x - plane.half_width) + plane.down * (y - plane.half_height);
  const glm::dvec3 d = plane.perspective ? plane.direction + offset : plane.direction;
  const glm::dvec3 o = plane.perspective ? plane.eye : plane.eye + offset;
  const glm::dvec3 a = soup.corner(t.v0), e1 = glm::dvec3(soup.corner(t.v1)) - a,
                   e2 = glm::dvec3(soup.corner(t.v2)) - a;
  const glm::dvec3 p = glm::cross(d, e2), s = o - a, q = glm::cross(s, e1);
  const double det = glm::dot(e1, p), u = glm::dot(s, p) / det, v = glm::dot(d, q) / det;
  if (!(u >= 0 && v >= 0 && u + v <= 1)) return std::nullopt;
  return glm::dot(e2, q) / det;
}

/// Every pixel around whose centre (0.02 pixels) rays agree on a triangle must agree with the fragments.
void check_against_rays(const ImagePlane& plane, const Soup& soup, const HostLayers& layers, double near_depth,
                        double tolerance) {
  uint32_t wrong = 0, wrong_depth = 0, compared = 0, unclear = 0;
  for (uint32_t y = 0; y < layers.height; ++y)
    for (uint32_t x = 0; x < layers.width; ++x) {
      std::vector<std::optional<float>> found(soup.triangles.size());
      for (const LayeredFragment& f : layers.at(x, y)) {
        wrong += found[f.triangle & ~LAYERED_AWAY].has_value();
        found[f.triangle & ~LAYERED_AWAY] = f.depth;
      }
      for (uint32_t t = 0; t < soup.triangles.size(); ++t) {
        int seen = 0;
        double depth = 0, smallest = 1e30, largest = -1e30;
        for (int k = 0; k < 5; ++k) {
          const double dx = k == 1 ? 0.02 : k == 2 ? -0.02 : 0, dy = k == 3 ? 0.02 : k == 4 ? -0.02 : 0;
          const auto hit = see(plane, soup, soup.triangles[t], x + 0.5 + dx, y + 0.5 + dy);
          if (!hit || *hit < near_depth) continue;
          ++seen;
          if (k == 0) depth = *hit;
          smallest = std::min(smallest, *hit);
          largest = std::max(largest, *hit);
        }
        if (seen != 0 && seen != 5) {
          ++unclear;
          continue;
        }
        compared += seen == 5;
        wrong += (seen == 5) != found[t].has_value();
        if (seen == 5 && found[t])
          wrong_depth += std::abs(*found[t] - depth) > tolerance * std::abs(depth) + (largest - smallest);
      }
    }
  CHECK(wrong == 0);
  CHECK(wrong_depth == 0);
  CHECK(compared > 3000);
  CHECK(unclear < compared / 20);
}

Soup around(uint32_t count, float half, uint32_t seed) {
  Soup soup;
  Random random(seed);
  for (uint32_t i = 0; i < count; ++i) {
    const glm::vec3 center = random.in_cube(half);
    const float size = half * std::exp(random.uniform(-3, 0.5f));
    soup.add_triangle(center + random.in_cube(size), center + random.in_cube(size), center + random.in_cube(size));
  }
  return soup;
}

ImagePlane plane_of(const glm::vec3& eye, const glm::vec3& direction, const glm::vec3& down, double tan_half,
                    uint32_t width, uint32_t height) {
  const double pixel = 2 * tan_half / width;
  return {
      eye,          direction, pixel * glm::dvec3(glm::cross(down, direction)), pixel * glm::dvec3(down), 0.5 * width,
      0.5 * height, true};
}

}  // namespace

TEST_CASE("perspective views, with triangles through the near plane and behind the eye") {
  const Soup soup = around(150, 5, 1);
  LayeredScene scene(scene_of(soup), {.max_width = 80, .max_height = 60, .perspective = true});
  Random random(2);
  for (const float near_depth : {0.5f, 0.001f}) {
    CAPTURE(near_depth);
    const glm::vec3 eye = random.in_cube(2), direction = random.direction();
    const glm::vec3 down = glm::normalize(glm::cross(direction, random.direction()));
    const HostLayers layers = scene.store(perspective_view(eye, direction, down, 0.8f, 80, 60, near_depth, 30));
    check_against_rays(plane_of(eye, direction, down, 0.8, 80, 60), soup, layers, near_depth, 2e-3);
  }
}

TEST_CASE("payloads that are clipped agree between the ways to store") {
  const Soup soup = around(150, 5, 4);
  LayeredScene scene(scene_of(soup), {.max_width = 80, .max_height = 60, .perspective = true});
  const LayeredView view = perspective_view({1, 0, 0}, {0, 0, 1}, {0, -1, 0}, 1, 80, 60, 0.01f, 30);
  const HostLayers tiles = scene.store(view), lists = scene.store(view, {.variant = LayeredVariant::exact});
  CHECK(tiles.pixel_start == lists.pixel_start);
  REQUIRE(tiles.fragments.size() == lists.fragments.size());
  CHECK(std::memcmp(tiles.fragments.data(), lists.fragments.data(), 8 * tiles.fragments.size()) == 0);
}

TEST_CASE("orthographic views of triangles far larger than the image") {
  Soup soup;
  Random random(5);
  for (int i = 0; i < 40; ++i) {
    const auto corner = [&] {
      return glm::vec3(1e5f * random.uniform(-1, 1), 1e5f * random.uniform(-1, 1), random.uniform(-9, 9));
    };
    soup.add_triangle(corner(), corner(), corner());
  }
  soup.add_triangle({100, 0, 0}, {110, 0, 0}, {100, 10, 0});        // beside the image
  soup.add_triangle({1e30f, 0, 0}, {1e30f, 1, 0}, {2e30f, 10, 0});  // nowhere
  soup.add_triangle({NAN, 0, 0}, {10, 0, 0}, {0, 10, 0});
  LayeredScene scene(scene_of(soup), {.max_width = 64, .max_height = 48});
  const ImagePlane plane{{32, 24, 0}, {0, 0, 1}, {1, 0, 0}, {0, 1, 0}, 32, 24, false};
  check_against_rays(plane, soup, scene.store(pixel_view(64, 48)), -1e9, 1e-3);
}

TEST_CASE("a closed mesh that is clipped keeps its balance") {
  // The near plane and the guard band cut a sphere around which the eye moves; what is cut open shows more backs.
  LayeredScene scene(scene_of(rough_sphere(30, 40, 8)), {.max_width = 100, .max_height = 100, .perspective = true});
  Random random(3);
  uint32_t wrong = 0, fragments = 0;
  for (int i = 0; i < 4; ++i) {
    const glm::vec3 eye = 0.3f * random.direction(), direction = random.direction();
    const glm::vec3 down = glm::normalize(glm::cross(direction, random.direction()));
    const HostLayers layers = scene.store(perspective_view(eye, direction, down, 3, 100, 100, 1e-4f, 10));
    for (uint32_t y = 0; y < 100; ++y)
      for (uint32_t x = 0; x < 100; ++x) {
        int balance = 0;
        for (const LayeredFragment& f : layers.at(x, y)) balance += f.triangle & LAYERED_AWAY ? 1 : -1;
        wrong += balance != 1;  // from inside: out once more than in
        fragments += static_cast<uint32_t>(layers.at(x, y).size());
      }
  }
  CHECK(wrong == 0);
  CHECK(fragments >= 40000);
}

TEST_CASE("cube views see a surface around the eye once in every pixel") {
  constexpr uint32_t size = 48;
  const glm::vec3 eye(0.05f, -0.1f, 0.02f);
  Soup soup = rough_sphere(30, 40, 6);
  for (Vertex& v : soup.vertices) {  // star-shaped about the eye
    const glm::vec3 p = eye + glm::normalize(v.position.xyz()) * (1 + 0.2f * glm::length(v.position.xyz()));
    v.position = float4(p, 0);
  }
  LayeredScene scene(scene_of(soup), {.max_width = size, .max_height = size, .perspective = true});
  double solid_angle = 0;
  int face = 0;
  std::array<bool, 6> axes{};
  for (const LayeredView& view : cube_views(eye, size, 0.01f, 10)) {
    CAPTURE(face);
    const HostLayers layers = scene.store(view);
    const glm::vec3 direction = view.row_w.xyz();
    for (int axis = 0; axis < 6; ++axis) axes[axis] = axes[axis] || direction[axis / 2] == (axis % 2 ? -1.f : 1.f);
    uint32_t wrong = 0, off = 0;
    for (uint32_t y = 0; y < size; ++y)
      for (uint32_t x = 0; x < size; ++x) {
        const auto pixel = layers.at(x, y);
        if (pixel.size() != 1 || !(pixel[0].triangle & LAYERED_AWAY)) {
          ++wrong;
          continue;
        }
        // The point that the view sees there, from its own rows: on the triangle's plane.
        const glm::vec3 right = (view.row_x.xyz() - direction * (size * 0.5f)) / (size * 0.5f);
        const glm::vec3 down = (view.row_y.xyz() - direction * (size * 0.5f)) / (size * 0.5f);
        const float sx = (static_cast<float>(x) + 0.5f) / (size * 0.5f) - 1,
                    sy = (static_cast<float>(y) + 0.5f) / (size * 0.5f) - 1;
        const glm::vec3 p = eye + pixel[0].depth * (direction + sx * right + sy * down);
        const Triangle& t = soup.triangles[pixel[0].triangle & ~LAYERED_AWAY];
        const glm::vec3 n =
            glm::normalize(glm::cross(soup.corner(t.v1) - soup.corner(t.v0), soup.corner(t.v2) - soup.corner(t.v0)));
        off += std::abs(glm::dot(n, p - soup.corner(t.v0))) > 1e-3f;
        const double r2 = 1 + double{sx} * sx + double{sy} * sy;
        solid_angle += 4.0 / (size * size) / (r2 * std::sqrt(r2));
      }
    CHECK(wrong == 0);
    CHECK(off == 0);
    ++face;
  }
  CHECK(solid_angle == test::relative(4 * 3.14159265, 1e-3));
  for (const bool seen : axes) CHECK(seen);
}
