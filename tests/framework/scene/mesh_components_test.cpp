// SPDX-License-Identifier: Apache-2.0
#include "lucarium/scene/mesh_components.h"

#include <doctest/doctest.h>

#include "lucarium/scene/builtin/builder.h"
#include "tolerance.h"

using namespace lucarium;

TEST_CASE("components hang together by edges; each knows whether it is closed and its volume") {
  // Two boxes that share a corner, a turned-over box away from them, and two triangles of a sheet.
  Mesh mesh = MeshBuilder("boxes").box({0, 0, 0}, {1, 2, 3}).box({1, 2, 3}, {2, 3, 4}).box({7, 0, 0}, {9, 2, 2}).take();
  const size_t box = mesh.triangles.size() / 3;
  for (size_t t = 2 * box; t < 3 * box; ++t) std::swap(mesh.triangles[t].y, mesh.triangles[t].z);
  const auto first = static_cast<uint32_t>(mesh.positions.size());
  for (const glm::vec3& p : {glm::vec3(0, 9, 0), glm::vec3(1, 9, 0), glm::vec3(1, 9, 1), glm::vec3(0, 9, 1)})
    mesh.positions.push_back(p);
  mesh.triangles.insert(mesh.triangles.begin() + 1, {first, first + 1, first + 2});  // amid the first box
  mesh.triangles.emplace_back(first, first + 2, first + 3);
  mesh.triangles.emplace_back(first, first, first);  // no edge: a component of its own
  const MeshComponents found = mesh_components(mesh.positions, mesh.triangles);
  REQUIRE(found.component_of.size() == mesh.triangles.size());
  REQUIRE(found.components.size() == 5);
  const auto check = [&](size_t component, size_t triangles, bool closed) {
    CAPTURE(component);
    CHECK(found.components[component].triangles == triangles);
    CHECK(found.components[component].closed == closed);
  };
  check(0, box, true);
  check(1, 2, false);
  check(2, box, true);
  check(3, box, true);
  check(4, 1, true);
  CHECK(found.components[0].volume == test::relative(6, 1e-12));
  CHECK(found.components[2].volume == test::relative(1, 1e-12));
  CHECK(found.components[3].volume == test::relative(-8, 1e-12));
  CHECK(found.components[4].volume == 0);
  CHECK(found.component_of[0] == 0);
  CHECK(found.component_of[1] == 1);
  CHECK(found.component_of[2] == 0);
  CHECK(found.component_of[mesh.triangles.size() - 2] == 1);
  CHECK(signed_volume(mesh.positions, std::span(mesh.triangles).subspan(2 * box + 1, box)) ==
        test::relative(-8, 1e-12));
  CHECK(mesh_components({}, {}).components.empty());
  CHECK(signed_volume({}, {}) == 0);
}

TEST_CASE("a hole, or a fin, opens its component only") {
  Mesh mesh = MeshBuilder("boxes").box({0, 0, 0}, {1, 1, 1}).box({2, 0, 0}, {3, 1, 1}).box({4, 0, 0}, {5, 1, 1}).take();
  const size_t box = mesh.triangles.size() / 3;
  mesh.triangles.erase(mesh.triangles.begin());  // a hole in the first
  mesh.positions.emplace_back(4.5f, 3.f, 0.5f);
  const glm::uvec3 last = mesh.triangles.back();
  mesh.triangles.emplace_back(last.x, last.y, static_cast<uint32_t>(mesh.positions.size() - 1));  // a fin on the third
  const MeshComponents found = mesh_components(mesh.positions, mesh.triangles);
  REQUIRE(found.components.size() == 3);
  CHECK_FALSE(found.components[0].closed);
  CHECK(found.components[1].closed);
  CHECK_FALSE(found.components[2].closed);
  CHECK(found.components[2].triangles == box + 1);
}
