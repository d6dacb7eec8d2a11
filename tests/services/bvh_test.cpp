// SPDX-License-Identifier: Apache-2.0
#include <doctest/doctest.h>

#include <bit>
#include <cstring>
#include <limits>

#include "lucarium/base/error.h"
#include "test_support.h"
#include "tolerance.h"
#include "tracer.h"

using namespace lucarium;
using namespace lucarium::test;

namespace {

bool missed(const Hit& hit) {
  return hit.triangle == LUCARIUM_NO_HIT && hit.distance == INFINITY && hit.u == 0 && hit.v == 0;
}

/// Closest hit in double precision by Möller and Trumbore's test over all triangles. `doubtful`: some triangle's edge is
/// so close to the ray that single precision may decide otherwise.
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

std::vector<Ray> random_rays(uint32_t count, uint32_t seed, float half = 12) {
  std::vector<Ray> rays;
  Random random(seed);
  for (uint32_t i = 0; i < count; ++i) {
    Ray ray = make_ray(random.in_cube(half), random.direction());
    if (i % 3 == 0) ray.direction.w = random.uniform(0, half);
    if (i % 7 == 0) {  // along an axis, with zeros of both signs
      const uint32_t axis = random.below(3);
      glm::vec3 d(0.f);
      d[axis] = i & 1 ? 1.f : -1.f;
      d[(axis + 1) % 3] = -0.f;
      ray.direction = float4(d, ray.direction.w);
    }
    rays.push_back(ray);
  }
  return rays;
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
  for (const BvhTraversal traversal : {BvhTraversal::wide, BvhTraversal::wide_portable}) {
    const Results packets = tracer.trace(tracer.make(soup, traversal), rays);
    CHECK(std::memcmp(packets.hits.data(), single.hits.data(), rays.size() * sizeof(Hit)) == 0);
    CHECK(packets.occluded == single.occluded);
  }
}

TEST_CASE("no ray escapes a closed mesh") {
  Tracer tracer;
  const int batches = full_run() ? 25 : 1;  // 10⁸ rays in all: two meshes, two traversals
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

TEST_CASE("equal distances go to the lower triangle") {
  Tracer tracer;
  Soup soup = random_soup(500, 31);
  const uint32_t first = static_cast<uint32_t>(soup.triangles.size());
  for (int copy = 0; copy < 40; ++copy) soup.add_triangle({20, -1, -1}, {20, 1, -1}, {20, 0, 2});
  std::vector<Ray> rays;
  Random random(32);
  for (int i = 0; i < 200; ++i)
    rays.push_back(make_ray({30, random.uniform(-0.2f, 0.2f), random.uniform(-0.2f, 0.2f)}, {-1, 0, 0}));
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
  const std::vector<Ray> rays = {
      make_ray({0, 0, 0}, {0, 0, 1}),        make_ray({0, 0, 10}, {0, 0, -1}),        make_ray({0, 0, 0}, {0, 0, 1}, 5),
      make_ray({0, 0, 0}, {0, 0, 1}, 4.99f), make_ray({0, 0, 0}, {0, 0, -1}),         make_ray({0, 0, 5}, {0, 0, 1}),
      make_ray({0, 0, 0}, {0, 0, 1}, 0),     make_ray({0.2f, 0.5f, 0}, {0, 0, 1}, 1e30f)};
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

TEST_CASE("inactive, infinite and undefined rays miss") {
  Tracer tracer;
  const Soup soup = rough_sphere(10, 12, 41);
  const float nan = std::numeric_limits<float>::quiet_NaN(), infinity = INFINITY;
  std::vector<Ray> rays = {make_ray({0, 0, 0}, {0, 0, 1}, -1.f),       make_ray({0, 0, 0}, {0, 0, 1}, -infinity),
                           make_ray({0, 0, 0}, {0, 0, 1}, nan),        make_ray({0, 0, 0}, {0, 0, 0}),
                           make_ray({0, 0, 0}, {nan, 0, 1}),           make_ray({0, 0, 0}, {0, infinity, 0}),
                           make_ray({nan, 0, 0}, {0, 0, 1}),           make_ray({0, infinity, 0}, {0, 0, 1}),
                           make_ray({0, 0, -1e30f}, {0, 0, 1}),        make_ray({nan, nan, nan}, {nan, nan, nan}, nan)};
  for (const BvhTraversal traversal : traversals) {
    const Results results = tracer.trace(tracer.make(soup, traversal), rays);
    for (size_t i = 0; i < rays.size(); ++i) {
      CAPTURE(i);
      CHECK(missed(results.hits[i]));
      CHECK(results.occluded[i] == 0);
    }
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

TEST_CASE("after an update the hits are those of a new hierarchy") {
  Tracer tracer;
  const std::vector<Ray> rays = random_rays(5000, 61);
  for (const BvhTraversal traversal : traversals) {
    Soup soup = random_soup(2000, 62);
    const uint32_t vertex = soup.triangles.back().v0;
    const float4 kept = soup.vertices[vertex].position;
    soup.vertices[vertex].position.x = std::numeric_limits<float>::quiet_NaN();
    Bvh bvh = tracer.make(soup, traversal);
    const auto same_as_new = [&](bool topology) {
      const uint64_t before = bvh.generation();
      bvh.update(soup.vertices, soup.triangles, topology);
      const Results updated = tracer.trace(bvh, rays), fresh = tracer.trace(tracer.make(soup, traversal), rays);
      CHECK(std::memcmp(updated.hits.data(), fresh.hits.data(), rays.size() * sizeof(Hit)) == 0);
      CHECK(updated.occluded == fresh.occluded);
      return bvh.generation() != before;
    };
    // A small motion is refitted in place.
    for (Vertex& v : soup.vertices) v.position.y = 0.9f * v.position.y + 0.1f * v.position.z;
    CHECK_FALSE(same_as_new(false));
    // A triangle that could not be hit when the hierarchy was built comes to life.
    soup.vertices[vertex].position = kept;
    same_as_new(false);
    CHECK(bvh.statistics().ignored_triangles == 0);
    // A triangle dies.
    soup.vertices[vertex].position.z = INFINITY;
    same_as_new(false);
    // Everything moves somewhere else: the cost leaves the limit and the hierarchy is built again.
    const double cost = bvh.statistics().sah_cost;
    Random random(63);
    for (const Triangle& t : soup.triangles) {
      const glm::vec3 shift = random.in_cube(10);
      for (const uint32_t v : {t.v0, t.v1, t.v2})
        soup.vertices[v].position = float4(soup.corner(v) + shift, 0.f);
    }
    same_as_new(false);
    CHECK(bvh.statistics().sah_cost < 1.5 * cost);
    // More triangles do not fit into the buffers.
    const Soup more = random_soup(5000, 64);
    soup = more;
    CHECK(same_as_new(true));
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

TEST_CASE("the traversal can be chosen by environment") {
  Tracer tracer;
  const Soup soup = random_soup(10, 71);
  const auto chosen = [&](const char* value) {
    setenv("LUCARIUM_BVH", value, 1);
    const Bvh bvh(tracer.device(), soup.vertices, soup.triangles);
    unsetenv("LUCARIUM_BVH");
    return bvh.traversal();
  };
  CHECK(chosen("wide") == BvhTraversal::wide);
  CHECK(chosen("wide-portable") == BvhTraversal::wide_portable);
  CHECK(chosen("scalar") == BvhTraversal::scalar);
  CHECK(chosen("") == (tracer.device().info().type == DeviceType::cpu ? BvhTraversal::wide : BvhTraversal::scalar));
  try {
    chosen("quick");
    FAIL("accepted");
  } catch (const Error& error) {
    CHECK(error.error_class() == ErrorClass::usage);
    CHECK(std::string(error.what()).find("wide, wide-portable or scalar") != std::string::npos);
  }
  unsetenv("LUCARIUM_BVH");
}

TEST_CASE("memory is stated, counted under 'bvh' and given back") {
  Tracer tracer;
  const Soup soup = random_soup(20000, 81);
  {
    const Bvh bvh = tracer.make(soup);
    CHECK(tracer.device().memory().by_owner()["bvh"] == bvh.statistics().bytes);
    CHECK(bvh.statistics().triangles == 20000);
    CHECK(bvh.statistics().sah_cost > 1);
  }
  CHECK(tracer.device().memory().by_owner()["bvh"] == 0);
  DeviceOptions small;
  small.memory_limit_bytes = 1 << 20;
  const std::shared_ptr<Device> device = Device::open(small);
  try {
    const Bvh bvh(*device, soup.vertices, soup.triangles, BvhTraversal::wide);
    FAIL("fits");
  } catch (const Error& error) {
    CHECK(error.error_class() == ErrorClass::device);
  }
}
