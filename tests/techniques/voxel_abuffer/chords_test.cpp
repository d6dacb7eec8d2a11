// SPDX-License-Identifier: Apache-2.0
// The mean chord of closed convex bodies by parity: of cosine-distributed rays from points uniform over the surface,
// inwards, it is 4V/S.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "../../framework/services/layered_raster/scene.h"
#include "closed_bodies.h"
#include "compared_rig.h"
#include "lucarium/shared/sobol_points.h"
#include "test_support.h"
#include "walked_rays.h"

using namespace lucarium;
using namespace lucarium::test;
using abuffer::Search;
using abuffer::VoxelAbuffer;

namespace {

/// A closed convex body: areas up to each of its triangles, and 4V/S.
struct ConvexBody {
  HostTriangles host;
  std::vector<double> areas;
  double chord = 0;

  explicit ConvexBody(const AbufferRig& rig) : host(rig.buffers) {
    double volume = 0, area = 0;
    for (uint32_t t = 0; t < host.triangles.size(); ++t) {
      const glm::dvec3 a(host.corner(t, 0)), b(host.corner(t, 1)), c(host.corner(t, 2));
      volume += glm::dot(a, glm::cross(b, c)) / 6;
      area += glm::length(glm::cross(b - a, c - a)) / 2;
      areas.push_back(area);
    }
    chord = 4 * volume / area;
  }

  /// Inwards. Points and directions fill their four dimensions evenly; seeds are independent.
  EndedRays rays(uint32_t count, uint32_t seed) const {
    Random random(seed);
    const auto word = [&] { return random.below(0xffffffffu); };
    const uint4 scramble{word(), word(), word(), word()};
    EndedRays result;
    for (uint32_t i = 0; i < count; ++i) {
      const uint4 x = reverse_bits4(owen_scramble_reversed(sobol_reversed(i), scramble));
      const auto of = [](uint32_t bits) { return (bits + 0.5) / 4294967296.0; };
      const double up_to = of(x.x) * areas.back();
      const auto found = std::upper_bound(areas.begin(), areas.end() - 1, up_to);
      const auto t = static_cast<uint32_t>(found - areas.begin());
      // What is left of the number that chose the triangle is even in it.
      const double before = t == 0 ? 0 : areas[t - 1], v = (up_to - before) / (areas[t] - before);
      const double root = std::sqrt(of(x.y));
      const glm::dvec3 a(host.corner(t, 0)), b(host.corner(t, 1)), c(host.corner(t, 2));
      const glm::dvec3 point = (1 - root) * a + root * (1 - v) * b + root * v * c;
      const glm::dvec3 in = glm::normalize(glm::cross(c - a, b - a));
      const glm::dvec3 tangent =
          glm::normalize(glm::cross(in, std::fabs(in.x) < 0.5 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0)));
      const double sine = std::sqrt(of(x.z)), angle = 6.283185307179586 * of(x.w);
      const glm::dvec3 direction = sine * std::cos(angle) * tangent + sine * std::sin(angle) * glm::cross(in, tangent) +
                                   std::sqrt(1 - sine * sine) * in;
      result.add(make_ray(glm::vec3(point + 1e-5 * in), glm::vec3(direction)),
                 {t | LUCARIUM_RAY_END_BACK, LUCARIUM_NONE});
    }
    return result;
  }
};

}  // namespace

TEST_CASE("chords: their mean inside a convex body is 4V/S") {
  Soup ellipsoid = sphere({}, 1);
  for (Vertex& v : ellipsoid.vertices) {
    const glm::vec3 p = v.position.xyz() * glm::vec3(1, 0.5f, 0.7f);
    v.position = float4(p.x + 0.3f * p.y, p.y - 0.2f * p.z, p.z + 0.1f * p.x, 0);
  }
  struct Case {
    Soup soup;
    uint32_t quick, full;  ///< rays of a set; what a box or an ellipsoid needs for the same noise is more
  };
  for (const Case& c : {Case{sphere({}, 1), 1 << 12, 1 << 16},
                        {box({-0.9f, -0.5f, -0.7f}, {0.9f, 0.5f, 0.7f}), 1 << 15, 1 << 17},
                        {ellipsoid, 0, 1 << 17}}) {
    const uint32_t per_set = full_run() ? c.full : c.quick;
    if (per_set == 0) continue;
    AbufferRig rig(scene_of(c.soup));
    const ConvexBody body(rig);
    CAPTURE(body.chord);
    const Bvh bvh(rig.scheduler.device(), rig.scene, rig.buffers);
    const auto check = [&](const Intersector& intersector, double bound) {
      constexpr uint32_t sets = 8;
      std::array<double, sets> means{};
      uint32_t escaped = 0;
      for (uint32_t set = 0; set < sets; ++set) {
        for (const Hit& hit : trace(rig, intersector, body.rays(per_set, set + 1)).hits) {
          escaped += hit.triangle == LUCARIUM_NO_HIT;
          if (hit.triangle != LUCARIUM_NO_HIT) means[set] += static_cast<double>(hit.distance) / per_set / body.chord;
        }
      }
      double mean = 0, squares = 0;
      for (const double m : means) mean += m / sets;
      for (const double m : means) squares += (m - mean) * (m - mean);
      const double noise = std::sqrt(squares / (sets * (sets - 1))), off = mean - 1;
      MESSAGE("off by ", off, ", noise ", noise, ", ", escaped, " escaped");
      CHECK(noise < 3e-4);
      CHECK(std::fabs(off) <= bound);
      CHECK(escaped == 0);
    };
    check(bvh, 1e-3);
    for (const Search search : {Search::columns, Search::three_steps, Search::one_step}) {
      CAPTURE(static_cast<int>(search));
      const VoxelAbuffer structure = rig.make({.search = search});
      CHECK(structure.statistics().exact_triangles == 0);
      check(structure, 2e-3);
    }
  }
}
