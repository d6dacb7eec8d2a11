// SPDX-License-Identifier: Apache-2.0
// Points where nothing sees them: inside solids that overlap, under what stands on a floor. What their discs would
// darken.
#include <doctest/doctest.h>

#include <array>

#include "lucarium/services/bvh/bvh.h"
#include "micro_fixture.h"
#include "micro_rendering/tree/point_forest.h"
#include "technique_fixture.h"
#include "test_support.h"
#include "tolerance.h"

using namespace lucarium;
using namespace lucarium::micro;
using namespace lucarium::test;

namespace {

struct Box {
  glm::vec3 low, high;
  bool holds(const glm::vec3& p) const {
    return glm::all(glm::greaterThan(p, low)) && glm::all(glm::lessThan(p, high));
  }
};

/// A room of slabs that overlap at its edges, its floor on a foundation; a plinth sunk into the floor, a column through
/// plinth and ceiling, a beam in the walls.
const std::array<Box, 10> boxes = {{{{-1.4f, -0.3f, -1.4f}, {1.4f, 0, 1.4f}},
                                    {{-1.6f, -0.6f, -1.6f}, {1.6f, -0.3f, 1.6f}},
                                    {{-1.4f, 2, -1.4f}, {1.4f, 2.2f, 1.4f}},
                                    {{-1.3f, -0.2f, -1.3f}, {-1, 2.1f, 1.3f}},
                                    {{1, -0.2f, -1.3f}, {1.3f, 2.1f, 1.3f}},
                                    {{-1.3f, -0.1f, -1.3f}, {1.3f, 2.1f, -1}},
                                    {{-1.3f, -0.1f, 1}, {1.3f, 2.1f, 1.3f}},
                                    {{-0.5f, -0.1f, -0.5f}, {0.1f, 0.3f, 0.1f}},
                                    {{-0.3f, 0.1f, -0.3f}, {-0.1f, 2.1f, -0.1f}},
                                    {{-1.2f, 1.5f, -0.7f}, {1.2f, 1.7f, -0.5f}}}};

Scene make_overlapping_room() {
  Scene scene;
  scene.source = "test:overlapping room";
  const int grey = add_lambert(scene, "grey", glm::vec3(0.6f));
  for (const Box& box : boxes)
    add_instance(scene, add_mesh(scene, MeshBuilder("box").box(box.low, box.high).take()), grey);
  return scene;
}

glm::vec3 position_of(const MicroLeaf& leaf, const std::vector<Triangle>& triangles,
                      const std::vector<Vertex>& vertices, glm::vec3& normal) {
  const Triangle& t = triangles[leaf.triangle & MICRO_LEAF_TRIANGLE];
  const glm::vec3 a = vertices[t.v0].position.xyz(), e1 = vertices[t.v1].position.xyz() - a,
                  e2 = vertices[t.v2].position.xyz() - a;
  normal = glm::normalize(glm::cross(e1, e2));
  return a + e1 * (static_cast<float>(leaf.weights & 0xffffu) / 65535) +
         e2 * (static_cast<float>(leaf.weights >> 16) / 65535);
}

/// Leaves of a forest: how many there are, lie inside a solid, are solid, or lie on the floor under the plinth.
struct Census {
  double all = 0, buried = 0, solid = 0, sheet = 0, solid_sheet = 0, below_plinth = 0, area = 0;
};

Census count(const Scene& scene, bool measured, int points_log2, int sheet = none) {
  Device& device = *test::test_device();
  KernelScheduler scheduler(device.shared_from_this());
  const SceneBuffers buffers(device, scene);
  const Bvh bvh(device, scene, buffers);
  const PointForest forest(device, scheduler, scene, buffers,
                           {.points_log2 = points_log2, .skip_hidden = measured, .intersector = &bvh}, "test");
  const std::vector<Triangle> triangles = buffers.scene_triangles.download();
  const std::vector<Vertex> vertices = buffers.scene_vertices.download();
  Census census;
  for (const MicroLeaf& leaf : forest.leaves.download()) {
    glm::vec3 normal;
    const glm::vec3 p = position_of(leaf, triangles, vertices, normal), off = p + 1e-3f * normal;
    const bool on_sheet = static_cast<int>(triangles[leaf.triangle & MICRO_LEAF_TRIANGLE].instance) == sheet;
    ++census.all;
    census.buried += std::any_of(boxes.begin(), boxes.end(), [&](const Box& box) { return box.holds(off); });
    census.solid += (leaf.triangle & MICRO_LEAF_SOLID) != 0;
    census.sheet += on_sheet;
    census.solid_sheet += on_sheet && leaf.triangle & MICRO_LEAF_SOLID;
    census.below_plinth += std::abs(p.y) < 1e-4f && p.x > -0.5f && p.x < 0.1f && p.z > -0.5f && p.z < 0.1f;
  }
  for (const ForestTree& tree : forest.trees()) census.area += tree.world_area;
  return census;
}

}  // namespace

TEST_CASE("points are placed on what something sees, and stand for its area") {
  const Scene scene = make_overlapping_room();
  const Census everything = count(scene, false, 14), seen = count(scene, true, 14);
  const double hidden = everything.buried / everything.all;
  MESSAGE("inside solids: ", hidden, " of all, ", seen.buried / seen.all, " of those that are seen; areas ",
          everything.area, ", ", seen.area);
  CHECK(hidden > 0.2);
  CHECK(seen.all == everything.all);
  CHECK(seen.buried < 0.01 * seen.all);
  CHECK(seen.area == test::relative(everything.area * (1 - hidden), 0.02));
  // Closed solids' backs are seen by nothing, but fronts of others that reach into them.
  CHECK(everything.solid == 0);
  CHECK(seen.solid > 0.98 * seen.all);
}

TEST_CASE("the back of a sheet is seen, and what a moving thing stands on too") {
  Scene scene = make_overlapping_room();
  add_instance(scene,
               add_mesh(scene, MeshBuilder("sheet")
                                   .quad({0.3f, 0.2f, 0.5f}, {0.9f, 0.2f, 0.5f}, {0.9f, 1.2f, 0.5f}, {0.3f, 1.2f, 0.5f})
                                   .take()),
               0);
  const Census census = count(scene, true, 14, static_cast<int>(scene.instances.size()) - 1);
  CHECK(census.sheet > 100);
  CHECK(census.solid_sheet < 0.02 * census.sheet);
  CHECK(census.solid > 0.98 * (census.all - census.sheet));
  // The plinth as an instance of its own that an animation moves.
  const double below = count(scene, false, 14).below_plinth;
  CHECK(below > 40);
  CHECK(census.below_plinth < 0.1 * below);
  scene = make_overlapping_room();
  std::swap(scene.instances[7], scene.instances.back());
  animate_last_instance(scene, AnimationPath::translation, {0, 0, 0, 0.5f, 0, 0.5f});
  CHECK(count(scene, true, 14).below_plinth > 40);
}

TEST_CASE("what is hidden does not depend on where things have moved") {
  Scene scene = make_overlapping_room();
  add_instance(scene, add_mesh(scene, MeshBuilder("mover").box({0.3f, 0.1f, 0.2f}, {0.6f, 0.5f, 0.6f}).take()), 0);
  scene.cameras.push_back(look_at_camera("corner", {0.9f, 1.6f, 0.9f}, {-0.3f, 0.5f, -0.3f}, 70));
  SceneLight light;
  light.world_from_light[3] = {-0.7f, 1.2f, 0.5f, 1};
  light.intensity = glm::vec3(10);
  scene.lights.push_back(light);
  animate_last_instance(scene, AnimationPath::scale, {1, 1, 1, 1.5f, 1, 1});  // stretched: its area changes too
  const RenderSettings settings = settings_for(scene, 16, 1);
  const auto picture = [](RenderSession& session) {
    session.run({.iterations = 2});
    return session.resolve().find("indirect")->pixels;
  };
  RenderSession session(Device::open(), scene, registry().find("micro_rendering"), settings, small);
  picture(session);
  session.set_time(0.8);
  evaluate(scene, 0.8, scene.animation);
  RenderSession fresh(Device::open(), scene, registry().find("micro_rendering"), settings, small);
  const std::vector<float> expected = picture(fresh);
  CHECK(mean(expected) > 0);
  CHECK(session.technique().counters().at("share of hidden surface") > 0.2);
  CHECK(picture(session) == expected);
}

TEST_CASE("solids that overlap are no darker than the path tracer says") {
  Scene scene = make_overlapping_room();
  const int lamp = add_lambert(scene, "lamp", glm::vec3(0));
  scene.materials[static_cast<size_t>(lamp)].emissive_factor = glm::vec3(8);
  add_instance(
      scene,
      add_mesh(scene, MeshBuilder("lamp")
                          .quad({0.2f, 1.99f, 0.2f}, {0.6f, 1.99f, 0.2f}, {0.6f, 1.99f, 0.6f}, {0.2f, 1.99f, 0.6f})
                          .take()),
      lamp);
  scene.cameras.push_back(look_at_camera("corner", {0.9f, 1.6f, 0.9f}, {-0.3f, 0.5f, -0.3f}, 70));
  for (const int bounces : {1, 3}) {
    CAPTURE(bounces);
    const double expected = mean(indirect_light(scene, "path_tracing", 24, bounces, 32, reference));
    const auto mine = [&](const char* skip) {
      return mean(indirect_light(scene, "micro_rendering", 24, bounces, 8,
                                 with(small, {{"points_log2", "14"}, {"jacobi_level", "12"}, {"skip_hidden", skip}})));
    };
    const double skipped = mine("on"), kept = mine("off");
    MESSAGE("deviation: ", skipped / expected - 1, ", with hidden points ", kept / expected - 1);
    CHECK(skipped == test::relative(expected, 0.02));
    CHECK(kept < 0.97 * expected);
  }
}
