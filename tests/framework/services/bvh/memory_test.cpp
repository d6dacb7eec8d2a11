// SPDX-License-Identifier: Apache-2.0
// What a hierarchy takes on the device and on the host, and what remains when it is refused.
#include <doctest/doctest.h>

#include <cstring>
#include <functional>
#include <limits>

#include "lucarium/base/error.h"
#include "tracer.h"

using namespace lucarium;
using namespace lucarium::test;

namespace {

std::string refusal(const std::function<void()>& action) {
  try {
    action();
  } catch (const Error& error) {
    CHECK(error.error_class() == ErrorClass::device);
    return error.what();
  }
  return "";
}

bool same_hits(const Results& a, const Results& b) {
  return std::memcmp(a.hits.data(), b.hits.data(), a.hits.size() * sizeof(Hit)) == 0 && a.occluded == b.occluded;
}

}  // namespace

TEST_CASE("the limit for one allocation is for each buffer, the total for all of them") {
  const Soup soup = random_soup(20000, 81);
  size_t bytes = 0;
  {
    Tracer tracer;
    bytes = tracer.make(soup).statistics().bytes;
  }
  const auto build = [&](size_t total, size_t single) {
    DeviceOptions options;
    options.memory_limit_bytes = total;
    options.allocation_limit_bytes = single;
    const std::shared_ptr<Device> device = Device::open(options);
    return refusal([&] { const Bvh bvh(*device, soup.vertices, soup.triangles, BvhTraversal::wide); });
  };
  // Leaf blocks are the larger part, about 5/6.
  CHECK(build(2 * bytes, bytes - bytes / 20).empty());
  CHECK(build(2 * bytes, bytes / 2).find("leaf blocks of bvh") != std::string::npos);
  CHECK(build(bytes - 1, bytes - 1).find("hierarchy of bvh") != std::string::npos);
}

TEST_CASE("what does not fit is refused and leaves the hierarchy as it was") {
  const Soup small = random_soup(2000, 91), large = random_soup(40000, 92);
  DeviceOptions options;
  options.memory_limit_bytes = 2 << 20;
  Tracer tracer(options);
  const std::vector<Ray> rays = random_rays(2000, 93);
  Bvh bvh = tracer.make(small);
  const Results before = tracer.trace(bvh, rays);
  const uint64_t generation = bvh.generation();
  const size_t bytes = bvh.statistics().bytes, held = tracer.device().memory().by_owner()["bvh"];
  CHECK(refusal([&] { bvh.update(large.vertices, large.triangles, true); }).find("hierarchy of bvh") !=
        std::string::npos);
  CHECK(bvh.generation() == generation);
  CHECK(bvh.statistics().bytes == bytes);
  CHECK(tracer.device().memory().by_owner()["bvh"] == held);
  CHECK(same_hits(tracer.trace(bvh, rays), before));
  bvh.update(small.vertices, small.triangles, false);
  CHECK(same_hits(tracer.trace(bvh, rays), before));
}

TEST_CASE("the host keeps nothing of a hierarchy that rests, and gets it back for a refit") {
  Tracer tracer;
  Soup soup = random_soup(5000, 94);
  const std::vector<Ray> rays = random_rays(2000, 95);
  for (const BvhTraversal traversal : traversals) {
    Bvh bvh = tracer.make(soup, traversal);
    CHECK(bvh.statistics().host_bytes == 0);
    for (int step = 0; step < 3; ++step) {
      for (Vertex& v : soup.vertices) v.position.y = 0.99f * v.position.y + 0.02f * v.position.z;
      bvh.update(soup.vertices, soup.triangles, false);
      CHECK(bvh.statistics().part_builds == 1);
      CHECK(bvh.statistics().host_bytes >= 2 * bvh.statistics().bytes);
      CHECK(same_hits(tracer.trace(bvh, rays), tracer.trace(tracer.make(soup, traversal), rays)));
    }
  }
}

TEST_CASE("another number of triangles is changed topology, whatever the caller says") {
  Tracer tracer;
  const Soup first = random_soup(1000, 96), fewer = random_soup(700, 97), more = random_soup(1500, 98);
  const std::vector<Ray> rays = random_rays(2000, 99);
  Bvh bvh = tracer.make(first);
  for (const Soup* soup : {&fewer, &more}) {
    bvh.update(soup->vertices, soup->triangles, false);
    CHECK(bvh.statistics().triangles == soup->triangles.size());
    CHECK(same_hits(tracer.trace(bvh, rays), tracer.trace(tracer.make(*soup), rays)));
  }
}

TEST_CASE("triangles that die in a refit are counted as ignored") {
  Tracer tracer;
  Soup soup = random_soup(1000, 101);
  Bvh bvh = tracer.make(soup);
  const float kept = soup.vertices[5].position.x;
  soup.vertices[5].position.x = std::numeric_limits<float>::quiet_NaN();
  bvh.update(soup.vertices, soup.triangles, false);
  CHECK(bvh.statistics().ignored_triangles == 1);
  CHECK(bvh.statistics().triangles == 999);
  soup.vertices[5].position.x = kept;
  bvh.update(soup.vertices, soup.triangles, false);
  CHECK(bvh.statistics().ignored_triangles == 0);
  CHECK(bvh.statistics().triangles == 1000);
  CHECK(bvh.statistics().part_builds == 1);
}
