// SPDX-License-Identifier: Apache-2.0
// Hits of random, coherent and degenerate rays; all traversals agree to the bit.
#include <doctest/doctest.h>

#include <array>
#include <cstring>
#include <limits>

#include "lucarium/services/bvh/wide.h"
#include "test_support.h"
#include "tolerance.h"
#include "tracer.h"

using namespace lucarium;
using namespace lucarium::test;

namespace {

bool missed(const Hit& hit) {
  return hit.triangle == LUCARIUM_NO_HIT && hit.distance == INFINITY && hit.u == 0 && hit.v == 0;
}

/// Closest hit in double precision by Möller and Trumbore's test over all triangles. `doubtful`: some triangle's edge
/// is so close to the ray that single precision may decide otherwise.
struct Exact {
  double distance = INFINITY, u = 0, v = 0;
  uint32_t triangle = LUCARIUM_NO_HIT;
  bool doubtful = false;
};

Exact intersect_all(const Soup& soup, const Ray& ray) {
  Exact best;
  const glm::dvec3 o(ray.origin.xyz()), d(ray.direction.xyz());
  for (uint32_t i = 0; i < soup.triangles.size(); ++i) {
    const Triangle& t = soup.triangles[i];
    const glm::dvec3 a(soup.corner(t.v0)), b(soup.corner(t.v1)), c(soup.corner(t.v2));
    const glm::dvec3 p = glm::cross(d, c - a), q = glm::cross(o - a, b - a);
    const double determinant = glm::dot(b - a, p);
    if (determinant == 0) continue;
    const double u = glm::dot(o - a, p) / determinant, v = glm::dot(d, q) / determinant;
    const double distance = glm::dot(c - a, q) / determinant;
    // Corners are rounded relative to the origin; that moves barycentrics by about 2⁻²² size / height of the triangle.
    const double flatness = glm::length(b - a) * glm::length(c - a) / std::abs(determinant);
    const double doubt = 1e-6 * flatness * (1 + glm::length(o) / (1e-30 + glm::length(b - a) + glm::length(c - a)));
    const double inside = std::min({u, v, 1 - u - v});
    if (distance > -1e-4 && distance <= ray.direction.w * 1.0001 && std::abs(inside) < doubt) best.doubtful = true;
    if (inside < 0 || distance <= 0 || distance > ray.direction.w) continue;
    if (std::abs(distance - best.distance) < 1e-4 * (1 + distance)) best.doubtful = true;
    if (distance < best.distance) best = {distance, u, v, i, best.doubtful};
  }
  return best;
}

void check_against_exact(Tracer& tracer, const Soup& soup, const std::vector<Ray>& rays) {
  for (const BvhTraversal traversal : traversals) {
    CAPTURE(static_cast<int>(traversal));
    const Results results = tracer.trace(tracer.make(soup, traversal), rays);
    size_t wrong = 0, doubtful = 0, hit = 0;
    for (size_t i = 0; i < rays.size(); ++i) {
      const Exact exact = intersect_all(soup, rays[i]);
      const Hit& found = results.hits[i];
      CHECK(results.occluded[i] == (found.triangle != LUCARIUM_NO_HIT));
      if (exact.doubtful) {
        ++doubtful;
        continue;
      }
      hit += exact.triangle != LUCARIUM_NO_HIT;
      if (exact.triangle == LUCARIUM_NO_HIT) {
        wrong += !missed(found);
        continue;
      }
      const double tolerance = 1e-4 * (1 + exact.distance);
      wrong += found.triangle != exact.triangle || std::abs(double{found.distance} - exact.distance) > tolerance ||
               std::abs(double{found.u} - exact.u) > 0.02 || std::abs(double{found.v} - exact.v) > 0.02;
    }
    CHECK(wrong == 0);
    CHECK(doubtful < rays.size() / 10);
    if (soup.triangles.size() > 100) CHECK(hit > rays.size() / 20);
  }
}

}  // namespace

TEST_CASE("hits agree with a test of all triangles in double precision") {
  Tracer tracer;
  for (const uint32_t count : {1u, 8u, 100u, 3000u})
    check_against_exact(tracer, random_soup(count, count), random_rays(full_run() ? 20000 : 2000, count + 1));
  check_against_exact(tracer, rough_sphere(20, 30, 4), random_rays(2000, 5, 1.2f));
}

TEST_CASE("all traversals give the same bits, with counts below the capacity and whatever the grouping") {
  Tracer tracer;
  const Soup soup = random_soup(5000, 11);
  const std::vector<Ray> rays = random_rays(3001, 12);
  const Results all = tracer.trace(tracer.make(soup), rays);
  for (const BvhTraversal traversal : traversals) {
    const Bvh bvh = tracer.make(soup, traversal);
    for (const uint32_t count : {0u, 1u, 33u, 1023u, 1024u, 1025u, 3001u, 9999u}) {
      CAPTURE(count);
      const uint32_t traced = std::min(count, 3000u);
      const Results some = tracer.trace(bvh, rays, count, 3000);
      CHECK(std::memcmp(some.hits.data(), all.hits.data(), traced * sizeof(Hit)) == 0);
      CHECK(std::memcmp(some.occluded.data(), all.occluded.data(), traced * sizeof(uint32_t)) == 0);
      for (size_t i = traced; i < rays.size(); ++i) {
        CHECK(some.hits[i].triangle == 0xeeeeeeeeu);
        CHECK(some.occluded[i] == 0xeeeeeeeeu);
      }
    }
  }
}

TEST_CASE("runs of coherent rays, traced as packets, give the same bits as single rays") {
  Tracer tracer;
  const Soup soup = random_soup(5000, 13);
  // A camera's rays, row by row; every fifth row is in disorder, so that packets and single rays take turns.
  const uint32_t width = 200, height = 100;
  std::vector<Ray> rays;
  Random random(14);
  for (uint32_t i = 0; i < width * height; ++i) {
    const float x = static_cast<float>(i % width) / 100 - 1, y = static_cast<float>(i / width) / 100 - 0.5f;
    const bool disorder = i / width % 5 == 0;
    const glm::vec3 direction = disorder ? random.direction() : glm::normalize(glm::vec3(x, y, -1.2f));
    rays.push_back(make_ray({0.01f * random.uniform(), 0, i / width % 2 ? 14.f : 5.f}, direction,
                            i % 11 == 0 ? random.uniform(0, 20) : INFINITY));
    if (i % 97 == 0) rays.back().direction.w = -1;
  }
  const Results single = tracer.trace(tracer.make(soup, BvhTraversal::scalar), rays);
  size_t hit = 0;
  for (const Hit& found : single.hits) hit += found.triangle != LUCARIUM_NO_HIT;
  CHECK(hit > rays.size() / 10);
  for (const BvhTraversal traversal : {BvhTraversal::wide_16, BvhTraversal::wide_8}) {
    const Results packets = tracer.trace(tracer.make(soup, traversal), rays);
    CHECK(std::memcmp(packets.hits.data(), single.hits.data(), rays.size() * sizeof(Hit)) == 0);
    CHECK(packets.occluded == single.occluded);
  }
}

TEST_CASE("equal distances go to the lower triangle") {
  Tracer tracer;
  Soup soup = random_soup(500, 31);
  const uint32_t first = static_cast<uint32_t>(soup.triangles.size());
  for (int copy = 0; copy < 40; ++copy) soup.add_triangle({20, -1, -1}, {20, 1, -1}, {20, 0, 2});
  std::vector<Ray> rays;
  Random random(32);
  for (int i = 0; i < 208; ++i) {  // single ones, then such that are traced as packets
    const float reach = i < 96 ? 0.2f : 0.01f;
    rays.push_back(make_ray({30, random.uniform(-reach, reach), random.uniform(-reach, reach)}, {-1, 0, 0}));
  }
  for (const BvhTraversal traversal : traversals)
    for (const Hit& hit : tracer.trace(tracer.make(soup, traversal), rays).hits) {
      CHECK(hit.triangle == first);
      CHECK(hit.distance == test::relative(10, 1e-6));
    }
}

TEST_CASE("both sides are hit, and only within the length of the ray") {
  Tracer tracer;
  Soup soup;
  soup.add_triangle({-1, -1, 5}, {1, -1, 5}, {0, 2, 5});
  const std::vector<Ray> rays = {make_ray({0, 0, 0}, {0, 0, 1}),    make_ray({0, 0, 10}, {0, 0, -1}),
                                 make_ray({0, 0, 0}, {0, 0, 1}, 5), make_ray({0, 0, 0}, {0, 0, 1}, 4.99f),
                                 make_ray({0, 0, 0}, {0, 0, -1}),   make_ray({0, 0, 5}, {0, 0, 1}),
                                 make_ray({0, 0, 0}, {0, 0, 1}, 0), make_ray({0.2f, 0.5f, 0}, {0, 0, 1}, 1e30f)};
  const bool expected[] = {true, true, true, false, false, false, false, true};
  for (const BvhTraversal traversal : traversals) {
    const Results results = tracer.trace(tracer.make(soup, traversal), rays);
    for (size_t i = 0; i < rays.size(); ++i) {
      CAPTURE(i);
      CHECK((results.hits[i].triangle == 0) == expected[i]);
      CHECK(missed(results.hits[i]) != expected[i]);
      CHECK(results.occluded[i] == expected[i]);
      if (expected[i]) CHECK(results.hits[i].distance == test::relative(5, 1e-6));
    }
    // The hit point is (1 - u - v) a + u b + v c.
    CHECK(results.hits[7].v == test::relative(0.5f));
    CHECK(results.hits[7].u == test::relative(0.35f));
  }
}

TEST_CASE("hits of slivers lie between their corners, however uncertain their plane is") {
  Tracer tracer;
  Soup soup;
  std::vector<Ray> rays;
  Random random(43);
  for (int i = 0; i < 2000; ++i) {
    const glm::vec3 a = random.in_cube(10), b = a + random.in_cube(2);
    soup.add_triangle(a, b, glm::mix(a, b, random.uniform()) + random.in_cube(i % 2 ? 1e-5f : 1e-6f));
    const glm::vec3 origin = random.in_cube(10);
    rays.push_back(make_ray(origin, glm::normalize(glm::mix(a, b, random.uniform()) - origin)));
  }
  for (const BvhTraversal traversal : traversals) {
    const Results results = tracer.trace(tracer.make(soup, traversal), rays);
    size_t hit = 0, outside = 0;
    for (size_t i = 0; i < rays.size(); ++i) {
      const Hit& found = results.hits[i];
      if (found.triangle == LUCARIUM_NO_HIT) continue;
      ++hit;
      const glm::vec3 o = rays[i].origin.xyz(), d = rays[i].direction.xyz(), size = glm::abs(d);
      const int axis = size.x > size.y && size.x > size.z ? 0 : size.y > size.z ? 1 : 2;
      float nearest = INFINITY, farthest = -INFINITY;
      for (const uint32_t vertex :
           {soup.triangles[found.triangle].v0, soup.triangles[found.triangle].v1, soup.triangles[found.triangle].v2}) {
        const float depth = (soup.corner(vertex)[axis] - o[axis]) / d[axis];
        nearest = std::min(nearest, depth), farthest = std::max(farthest, depth);
      }
      outside += found.distance < nearest - 1e-5f || found.distance > farthest + 1e-5f;
    }
    CHECK(hit > 50);
    CHECK(outside == 0);
  }
}

TEST_CASE("inactive, infinite and undefined rays miss") {
  Tracer tracer;
  const Soup soup = rough_sphere(10, 12, 41);
  const float nan = std::numeric_limits<float>::quiet_NaN(), infinity = INFINITY;
  std::vector<Ray> rays = {make_ray({0, 0, 0}, {0, 0, 1}, -1.f), make_ray({0, 0, 0}, {0, 0, 1}, -infinity),
                           make_ray({0, 0, 0}, {0, 0, 1}, nan),  make_ray({0, 0, 0}, {0, 0, 0}),
                           make_ray({0, 0, 0}, {nan, 0, 1}),     make_ray({0, 0, 0}, {0, infinity, 0}),
                           make_ray({nan, 0, 0}, {0, 0, 1}),     make_ray({0, infinity, 0}, {0, 0, 1}),
                           make_ray({0, 0, -1e30f}, {0, 0, 1}),  make_ray({nan, nan, nan}, {nan, nan, nan}, nan),
                           make_ray({0, 0, 0}, {0, 0, 1e19f})};  // its square is infinite
  for (const BvhTraversal traversal : traversals) {
    const Results results = tracer.trace(tracer.make(soup, traversal), rays);
    for (size_t i = 0; i < rays.size(); ++i) {
      CAPTURE(i);
      CHECK(missed(results.hits[i]));
      CHECK(results.occluded[i] == 0);
    }
  }
  // One among 16 coherent rays, the others of which hit.
  rays.clear();
  for (int mistake = 0; mistake < 6; ++mistake)
    for (const size_t place : {1u, 8u, 15u}) {
      for (int i = 0; i < 16; ++i)
        rays.push_back(make_ray({0, 0, 0}, glm::normalize(glm::vec3(1, 0.3f, 0.01f * static_cast<float>(i)))));
      Ray& ray = rays[rays.size() - 16 + place];
      if (mistake < 3) ray.direction.w = std::array{-1.f, -infinity, nan}[static_cast<size_t>(mistake)];
      if (mistake == 3) ray.origin.x = nan;
      if (mistake == 4) ray.direction = float4(1e19f * ray.direction.xyz(), INFINITY);
      if (mistake == 5) ray.direction = float4(0, 0, 0, INFINITY);
    }
  const Results single = tracer.trace(tracer.make(soup, BvhTraversal::scalar), rays);
  for (const BvhTraversal traversal : traversals) {
    CAPTURE(static_cast<int>(traversal));
    const Results results = tracer.trace(tracer.make(soup, traversal), rays);
    size_t hit = 0;
    for (const Hit& found : results.hits) hit += !missed(found);
    CHECK(hit == rays.size() / 16 * 15);
    CHECK(std::memcmp(results.hits.data(), single.hits.data(), rays.size() * sizeof(Hit)) == 0);
  }
}

TEST_CASE("a scene without triangles, or with none that can be hit, is all misses") {
  Tracer tracer;
  Soup empty, degenerate;
  const float nan = std::numeric_limits<float>::quiet_NaN();
  for (int i = 0; i < 50; ++i) {
    degenerate.add_triangle({0, 0, nan}, {1, 0, 5}, {0, 1, 5});
    degenerate.add_triangle({-1, -1, 5}, {-1, -1, 5}, {2, 2, 5});
  }
  for (const Soup* soup : {&empty, &degenerate})
    for (const BvhTraversal traversal : traversals) {
      const Bvh bvh = tracer.make(*soup, traversal);
      CHECK(bvh.statistics().triangles == 0);
      CHECK(bvh.statistics().ignored_triangles == soup->triangles.size());
      const Results results = tracer.trace(bvh, random_rays(500, 51));
      for (const Hit& hit : results.hits) CHECK(missed(hit));
      for (const uint32_t occluded : results.occluded) CHECK(occluded == 0);
    }
}

TEST_CASE("deep hierarchies get the stack they need") {
  // Sizes that shrink geometrically make surface-area splits peel off one triangle at a time.
  Tracer tracer;
  Soup nested;
  for (int i = 0; i < 2500; ++i) {
    const float size = std::pow(0.99f, static_cast<float>(i));
    nested.add_triangle({0, 0, size}, {size, 0, size}, {0, size, size});
  }
  // From the common corner upwards: the first hit is the smallest triangle that reaches over the ray.
  std::vector<Ray> rays;
  std::vector<uint32_t> expected;
  for (uint32_t i = 5; i < 2400; ++i) {
    const float inside = 0.5f * 0.995f * nested.corner(nested.triangles[i].v0).z;
    rays.push_back(make_ray({inside, inside, 0}, {0, 0, 1}));
    expected.push_back(i);
  }
  for (const BvhTraversal traversal : traversals) {
    const Results results = tracer.trace(tracer.make(nested, traversal), rays);
    size_t wrong = 0;
    for (size_t i = 0; i < rays.size(); ++i) wrong += results.hits[i].triangle != expected[i] || !results.occluded[i];
    CHECK(wrong == 0);
  }
}

TEST_CASE("narrow nodes get more stack than the usual one") {
  // Coinciding corners, all boxes one within the other: 4-wide nodes need more than the 128 entries of most scenes.
  Tracer tracer;
  Soup nested;
  LargeArray<BoundedTriangle> bounded;
  std::vector<Ray> rays;
  for (uint32_t i = 0; i < 3000; ++i) {
    const float size = std::pow(0.98f, static_cast<float>(i));
    nested.add_triangle({0, 0, 0}, {size, 0, 0}, {0, size, 0});
    Bounds box;
    REQUIRE(bound_triangle(nested.vertices, nested.triangles[i], box));
    bounded.emplace_back(box, i);
    rays.push_back(make_ray({0.25f * size, 0.25f * size, 1}, {0, 0, -1}));
  }
  CHECK(WideBvh(build_binary_bvh(bounded, 4, 1), 4, 4, {}, 1).stack_size() > 128);
  for (const BvhTraversal traversal : traversals) {
    const Results results = tracer.trace(tracer.make(nested, traversal), rays);
    size_t wrong = 0;
    for (size_t i = 0; i < rays.size(); ++i)
      wrong += results.hits[i].triangle != 0 || results.hits[i].distance != 1 || !results.occluded[i];
    CHECK(wrong == 0);
  }
}
