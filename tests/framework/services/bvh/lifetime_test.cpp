// SPDX-License-Identifier: Apache-2.0
// Updates of a hierarchy, the choice of its traversal, and its memory.
#include <doctest/doctest.h>

#include <cstdlib>
#include <cstring>
#include <limits>

#include "lucarium/base/error.h"
#include "tracer.h"

using namespace lucarium;
using namespace lucarium::test;

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
      for (const uint32_t v : {t.v0, t.v1, t.v2}) soup.vertices[v].position = float4(soup.corner(v) + shift, 0.f);
    }
    same_as_new(false);
    CHECK(bvh.statistics().sah_cost < 1.5 * cost);
    // More triangles do not fit into the buffers.
    const Soup more = random_soup(5000, 64);
    soup = more;
    CHECK(same_as_new(true));
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
  const bool sixteen = tracer.device().info().native_float_lanes >= 16;
  const BvhTraversal wide = sixteen ? BvhTraversal::wide_16 : BvhTraversal::wide_8;
  CHECK(chosen("wide") == wide);
  CHECK(chosen("wide-portable") == (sixteen ? BvhTraversal::wide_16_portable : BvhTraversal::wide_8_portable));
  CHECK(chosen("wide-16") == BvhTraversal::wide_16);
  CHECK(chosen("wide-8") == BvhTraversal::wide_8);
  CHECK(chosen("wide-16-portable") == BvhTraversal::wide_16_portable);
  CHECK(chosen("wide-8-portable") == BvhTraversal::wide_8_portable);
  CHECK(chosen("scalar") == BvhTraversal::scalar);
  CHECK(chosen("") == (tracer.device().info().type == DeviceType::cpu ? wide : BvhTraversal::scalar));
  try {
    chosen("quick");
    FAIL("accepted");
  } catch (const Error& error) {
    CHECK(error.error_class() == ErrorClass::usage);
    CHECK(std::string(error.what()).find("wide, wide-portable, wide-16") != std::string::npos);
  }
  unsetenv("LUCARIUM_BVH");
}

TEST_CASE("memory is stated, counted under 'bvh' and given back") {
  Tracer tracer;
  const Soup soup = random_soup(20000, 81);
  {
    const Bvh bvh = tracer.make(soup);
    const size_t held = tracer.device().memory().by_owner()["bvh"];
    CHECK(held >= bvh.statistics().bytes);
    CHECK(held < bvh.statistics().bytes + 2 * 64);  // each of two buffers ends at a cache line
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
