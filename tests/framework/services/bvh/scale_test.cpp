// SPDX-License-Identifier: Apache-2.0
// Intersection of triangles that are tiny beside their distance, and of whole scenes that are tiny or huge.
#include <doctest/doctest.h>

#include <cstring>

#include "test_support.h"
#include "tracer.h"

using namespace lucarium;
using namespace lucarium::test;

namespace {

/// Distance of a triangle's first corner from a ray's line, in double precision.
double lateral_distance(const Soup& soup, const Ray& ray, const Hit& hit) {
  const glm::dvec3 direction = glm::normalize(glm::dvec3(ray.direction.xyz()));
  const glm::dvec3 corner = glm::dvec3(soup.corner(soup.triangles[hit.triangle].v0)) - glm::dvec3(ray.origin.xyz());
  return glm::length(corner - direction * glm::dot(corner, direction));
}

/// Triangles of at most this half size [m] in a cube of 20 m.
Soup dust(uint32_t count, float half) {
  Soup soup;
  Random random(4);
  for (uint32_t i = 0; i < count; ++i) {
    const glm::vec3 middle = random.in_cube(10);
    soup.add_triangle(middle + random.in_cube(half), middle + random.in_cube(half), middle + random.in_cube(half));
  }
  return soup;
}

/// A camera's rays, rays of one direction from close by, rays without order, and narrow cones of 16 rays.
std::vector<Ray> rays_through_dust(uint32_t each) {
  std::vector<Ray> rays;
  Random random(5);
  for (uint32_t i = 0; i < each; ++i) {
    const float x = (static_cast<float>(i % 256) - 128) / 300, y = (static_cast<float>(i / 256) - 128) / 300;
    rays.push_back(make_ray({0, 0, 25}, glm::normalize(glm::vec3(x, y, -1))));
  }
  for (uint32_t i = 0; i < each; i += 16) {
    const glm::vec3 direction = random.direction(), origin = random.in_cube(10);
    for (int k = 0; k < 16; ++k) rays.push_back(make_ray(origin + random.in_cube(0.1f), direction));
  }
  for (uint32_t i = 0; i < each; ++i) rays.push_back(make_ray(random.in_cube(10), random.direction()));
  for (uint32_t i = 0; i < each; i += 16) {
    const glm::vec3 direction = random.direction(), origin = random.in_cube(10);
    for (int k = 0; k < 16; ++k) rays.push_back(make_ray(origin, glm::normalize(direction + random.in_cube(0.05f))));
  }
  return rays;
}

}  // namespace

TEST_CASE("rays do not hit tiny triangles that they pass far from") {
  Tracer tracer;
  const std::vector<Ray> rays = rays_through_dust(1u << 16);
  for (const float half : {1e-6f, 3e-6f, 1e-5f, 1e-4f, 1e-3f}) {
    const Soup soup = dust(20000, half);
    for (const BvhTraversal traversal : traversals) {
      CAPTURE(half);
      CAPTURE(static_cast<int>(traversal));
      const Results results = tracer.trace(tracer.make(soup, traversal), rays);
      size_t wrong = 0;
      for (size_t i = 0; i < rays.size(); ++i) {
        if (results.hits[i].triangle == LUCARIUM_NO_HIT) continue;
        // Corners are rounded when they are seen from the origin and sheared: 3 u of up to 70 m for three axes.
        wrong += lateral_distance(soup, rays[i], results.hits[i]) > 4 * double{half} + 2e-5;
      }
      CHECK(wrong == 0);
    }
  }
}

TEST_CASE("rays hit tiny triangles that they are aimed at") {
  Tracer tracer;
  const Soup soup = dust(20000, 1e-3f);
  std::vector<Ray> rays;
  Random random(6);
  for (const Triangle& t : soup.triangles) {
    const glm::vec3 middle = (soup.corner(t.v0) + soup.corner(t.v1) + soup.corner(t.v2)) / 3.f;
    const glm::vec3 normal = glm::cross(soup.corner(t.v1) - soup.corner(t.v0), soup.corner(t.v2) - soup.corner(t.v0));
    const float shape = glm::length(normal) / 1e-6f;
    const glm::vec3 direction = glm::normalize(normal);
    rays.push_back(make_ray(middle - 2.f * direction, direction, shape > 0.1f ? INFINITY : -1.f));
  }
  for (const BvhTraversal traversal : traversals) {
    const Results results = tracer.trace(tracer.make(soup, traversal), rays);
    size_t aimed = 0, hit = 0;
    for (size_t i = 0; i < rays.size(); ++i) {
      aimed += rays[i].direction.w > 0;
      hit += results.hits[i].triangle == i || results.hits[i].distance < 1.99f;
    }
    CHECK(aimed > 5000);
    CHECK(hit == aimed);
  }
}

TEST_CASE("no ray escapes a closed mesh of any size, near its origin or far from it, in any traversal") {
  Tracer tracer;
  const uint32_t count = full_run() ? 4000000 : 200000;
  for (const float scale : {1.f / 4096, 1.f, 4096.f}) {
    for (const glm::vec3 offset : {glm::vec3(0), glm::vec3(300, -200, 1000)}) {
      CAPTURE(scale);
      CAPTURE(offset.z);
      Soup soup = rough_sphere(50, 64, 21, offset);
      for (Vertex& vertex : soup.vertices) vertex.position = float4(scale * vertex.position.xyz(), 0.f);
      Random random(23);
      std::vector<Ray> rays;
      for (uint32_t i = 0; i < count; ++i) {
        const Triangle& t = soup.triangles[random.below(static_cast<uint32_t>(soup.triangles.size()))];
        const glm::vec3 origin = scale * (offset + random.in_cube(0.15f));
        const glm::vec3 target = glm::mix(soup.corner(t.v0), soup.corner(t.v1), i % 8 == 0 ? 0.f : random.uniform());
        rays.push_back(make_ray(origin, i % 2 ? random.direction() : glm::normalize(target - origin)));
        if (i / 16 % 4 == 0 && i % 16 != 0) {  // coherent, from origins that differ
          const Ray& lead = rays[i - i % 16];
          rays.back() = make_ray(lead.origin.xyz() + scale * random.in_cube(0.01f),
                                 glm::normalize(lead.direction.xyz() + random.in_cube(0.02f)));
        }
      }
      for (const BvhTraversal traversal : traversals) {
        CAPTURE(static_cast<int>(traversal));
        const Results results = tracer.trace(tracer.make(soup, traversal), rays);
        size_t escaped = 0, bad = 0;
        for (size_t i = 0; i < rays.size(); ++i) {
          const Hit& hit = results.hits[i];
          escaped += hit.triangle == LUCARIUM_NO_HIT || results.occluded[i] != 1;
          bad += !(hit.distance > 0.2f * scale && hit.distance < 1.9f * scale);
        }
        CHECK(escaped == 0);
        CHECK(bad == 0);
      }
    }
  }
}
