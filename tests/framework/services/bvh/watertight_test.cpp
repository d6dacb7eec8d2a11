// SPDX-License-Identifier: Apache-2.0
// Closed meshes let no ray out, and distances are those of the triangle's plane.
#include <doctest/doctest.h>

#include <cmath>

#include "test_support.h"
#include "tracer.h"

using namespace lucarium;
using namespace lucarium::test;

namespace {

/// The 12 triangles of an axis-aligned box around the origin.
Soup box_soup(float half) {
  Soup soup;
  for (uint32_t corner = 0; corner < 8; ++corner)
    soup.add_vertex({corner & 1 ? half : -half, corner & 2 ? half : -half, corner & 4 ? half : -half});
  const uint32_t faces[6][4] = {{0, 1, 3, 2}, {4, 6, 7, 5}, {0, 4, 5, 1}, {2, 3, 7, 6}, {0, 2, 6, 4}, {1, 5, 7, 3}};
  for (const auto& face : faces) {
    soup.triangles.push_back({face[0], face[1], face[2], 0});
    soup.triangles.push_back({face[0], face[2], face[3], 0});
  }
  return soup;
}

}  // namespace

TEST_CASE("no ray escapes a closed mesh") {
  Tracer tracer;
  const int batches = full_run() ? 25 : 1;  // 10⁸ rays together: two meshes, two traversals
  // At the origin, and far from it, where coordinates are coarse.
  for (const glm::vec3 offset : {glm::vec3(0), glm::vec3(300, -200, 1000)}) {
    const Soup soup = rough_sphere(50, 64, 21, offset);
    const Bvh bvhs[] = {tracer.make(soup, BvhTraversal::wide), tracer.make(soup, BvhTraversal::scalar)};
    Random random(22);
    for (int batch = 0; batch < batches; ++batch) {
      std::vector<Ray> rays;
      for (uint32_t i = 0; i < 1000000; ++i) {
        // Half of the rays aim at points on edges, and at corners.
        const Triangle& t = soup.triangles[random.below(static_cast<uint32_t>(soup.triangles.size()))];
        const glm::vec3 a = soup.corner(t.v0), b = soup.corner(t.v1);
        const glm::vec3 origin = offset + random.in_cube(0.15f);
        const glm::vec3 target = i % 8 == 0 ? a : glm::mix(a, b, random.uniform());
        rays.push_back(make_ray(origin, i % 2 ? random.direction() : glm::normalize(target - origin)));
        // Runs of coherent rays: 16 through the neighbourhood of one point.
        if (i / 16 % 4 == 0 && i % 16 != 0) {
          const Ray& lead = rays[i - i % 16];
          rays.back() = make_ray(lead.origin.xyz(), glm::normalize(lead.direction.xyz() + random.in_cube(0.02f)));
        }
      }
      for (const Bvh& bvh : bvhs) {
        const Results results = tracer.trace(bvh, rays);
        size_t escaped = 0, bad = 0;
        for (size_t i = 0; i < rays.size(); ++i) {
          const Hit& hit = results.hits[i];
          escaped += hit.triangle == LUCARIUM_NO_HIT || results.occluded[i] != 1;
          bad += !(hit.distance > 0.2f && hit.distance < 1.9f && hit.u >= 0 && hit.v >= 0 && hit.u + hit.v < 1.00001f);
        }
        CHECK(escaped == 0);
        CHECK(bad == 0);
      }
    }
  }
}

TEST_CASE("no ray escapes an axis-aligned box along its edges and diagonals") {
  Tracer tracer;
  const Soup soup = box_soup(1);
  std::vector<Ray> rays;
  for (int x = -20; x <= 20; ++x)
    for (int y = -20; y <= 20; ++y)
      for (int z = -20; z <= 20; ++z)
        if (x || y || z) {
          rays.push_back(make_ray({0, 0, 0}, glm::normalize(glm::vec3(x, y, z))));
          rays.push_back(make_ray({0.25f, 0, -0.f}, glm::normalize(glm::vec3(x, y, z))));
        }
  for (const BvhTraversal traversal : traversals) {
    const Results results = tracer.trace(tracer.make(soup, traversal), rays);
    size_t escaped = 0;
    for (size_t i = 0; i < rays.size(); ++i)
      escaped += results.hits[i].triangle == LUCARIUM_NO_HIT || results.occluded[i] != 1;
    CHECK(escaped == 0);
  }
}

TEST_CASE("distances are exact close to large triangles") {
  // Rays that leave one wall of a room near another one: corners are 10⁴ times as far away as the hit.
  Tracer tracer;
  const float half = 11.3f;
  const Soup soup = box_soup(half);
  std::vector<Ray> rays;
  Random random(35);
  for (int i = 0; i < 20000; ++i) {
    glm::vec3 origin = random.in_cube(half);
    const uint32_t axis = random.below(3);
    origin[axis] = half - 1e-3f;
    origin[(axis + 1) % 3] = -half + std::pow(10.f, random.uniform(-3, 0));
    rays.push_back(make_ray(origin, random.direction()));
  }
  for (const BvhTraversal traversal : traversals) {
    const Results results = tracer.trace(tracer.make(soup, traversal), rays);
    double worst = 0;
    for (size_t i = 0; i < rays.size(); ++i) {
      const glm::dvec3 o(rays[i].origin.xyz()), d(rays[i].direction.xyz());
      double exact = INFINITY;
      for (int axis = 0; axis < 3; ++axis)
        exact = std::min(exact, ((d[axis] > 0 ? double{half} : -double{half}) - o[axis]) / d[axis]);
      worst = std::max(worst, std::abs(double{results.hits[i].distance} - exact) / exact);
    }
    CHECK(worst < 1e-6);
  }
}
