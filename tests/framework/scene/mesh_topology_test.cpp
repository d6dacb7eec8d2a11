// SPDX-License-Identifier: Apache-2.0
#include "lucarium/scene/mesh_topology.h"

#include <doctest/doctest.h>

#include <cmath>
#include <limits>

#include "lucarium/scene/builtin/builder.h"
#include "tolerance.h"

using namespace lucarium;

TEST_CASE("equal positions are welded to the first, -0 is 0, NaN equals nothing") {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const std::vector<glm::vec3> positions = {{0, 1, 2}, {3, 4, 5}, {-0.f, 1, 2}, {3, 4, 5}, {nan, 0, 0}, {nan, 0, 0}};
  CHECK(weld_positions(positions) == std::vector<uint32_t>{0, 1, 0, 1, 4, 5});
}

TEST_CASE("half-edges of one edge stand together, edges without length are left out") {
  //  1---2
  //  | \ |   and a triangle of no area over 0, 1
  //  0---3
  const std::vector<glm::uvec3> triangles = {{0, 3, 1}, {3, 2, 1}, {0, 1, 1}};
  const std::vector<HalfEdge> edges = sorted_half_edges(triangles);
  CHECK(edges.size() == 3 + 3 + 2);
  std::vector<size_t> counts;
  visit_edges(edges, [&](const HalfEdge* first, const HalfEdge* last) {
    counts.push_back(static_cast<size_t>(last - first));
    for (const HalfEdge* e = first; e != last; ++e) CHECK((e->low == first->low && e->high == first->high));
    if (first->low == 1 && first->high == 3) {
      REQUIRE(last - first == 2);
      CHECK((first[0].triangle == 0 && first[0].edge == 1 && first[1].triangle == 1 && first[1].edge == 2));
      CHECK(run_opposite(triangles, first[0], first[1]));
    }
  });
  CHECK(counts == std::vector<size_t>{3, 1, 1, 2, 1});  // 0-1, 0-3, 1-2, 1-3, 2-3
}

TEST_CASE("a box is closed, one without a face, or with one turned over, is not") {
  Mesh box = MeshBuilder("box").box({0, 0, 0}, {1, 2, 3}).take();
  CHECK(is_closed(box.positions, box.triangles));
  const glm::uvec3 last = box.triangles.back();
  box.triangles.back() = {last.x, last.z, last.y};
  CHECK_FALSE(is_closed(box.positions, box.triangles));
  box.triangles.pop_back();
  CHECK_FALSE(is_closed(box.positions, box.triangles));
  CHECK(is_closed({}, {}));
}

TEST_CASE("the bend across an edge is the angle between the triangles") {
  const glm::vec3 a(0, 0, 0), b(0, 2, 0), up(0, 0, 5);
  for (const double angle : {-2.5, -1.0, 0.0, 0.3, 1.5707, 3.0}) {  // the triangle with that normal lies at x < 0
    const glm::vec3 opposite(3 * std::cos(angle), 0.7, -3 * std::sin(angle));
    CHECK(dihedral_bend(a, b, up, opposite) == test::within(angle, 1e-5));
  }
  CHECK(std::isnan(dihedral_bend(a, a, up, b)));
  CHECK(std::isnan(dihedral_bend(a, b, glm::vec3(0), up)));
  CHECK(std::isnan(dihedral_bend(a, b, up, {0, 1, 0})));
}
