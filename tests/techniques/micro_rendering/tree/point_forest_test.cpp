// SPDX-License-Identifier: Apache-2.0
// The forest on the device: what contains what, before and after a deformation; the work of a refit.
#include "micro_rendering/tree/point_forest.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>

#include "device_fixture.h"
#include "lucarium/scene/builtin/builder.h"
#include "packed_node.h"
#include "test_support.h"

using namespace lucarium;
using namespace lucarium::micro;
using test::PackedNode;
using test::unpack;

namespace {

float angle(const glm::vec3& a, const glm::vec3& b) { return 2 * std::atan2(glm::length(a - b), glm::length(a + b)); }

/// Children that are not inside their parents, by more than float arithmetic.
size_t violations(const PointForest& forest) {
  const std::vector<uint4> nodes = forest.nodes.download();
  size_t count = 0;
  for (const ForestTree& tree : forest.trees()) {
    for (uint32_t i = 2; i < 2 * tree.leaves(); ++i) {
      const PackedNode child = unpack(nodes[tree.record.first_node + i]),
                       parent = unpack(nodes[tree.record.first_node + i / 2]);
      count += glm::distance(child.center, parent.center) + child.radius > parent.radius * 1.00001f + 0.01f;
      count += parent.cone < 3.1415f && angle(child.normal, parent.normal) + child.cone > parent.cone + 1e-3f;
    }
  }
  return count;
}

void add_ball(Scene& scene) {
  MeshBuilder ball("ball");
  for (const auto& t : icosphere(3)) ball.triangle(t[0], t[1], t[2]);
  add_instance(scene, add_mesh(scene, ball.take()), add_lambert(scene, "grey", glm::vec3(0.5f)));
}

}  // namespace

TEST_CASE("nodes contain what is below them, also after a deformation, and the tree becomes no looser by a small one") {
  Scene scene;
  scene.source = "test:two";
  add_ball(scene);
  add_instance(scene, add_mesh(scene, MeshBuilder("floor").box({-3, -2, -3}, {3, -1, 3}).take()), 0);
  scene.instances[0].pose = std::make_shared<Mesh>(scene.meshes[0]);
  Device& device = *test::test_device();
  KernelScheduler scheduler(device.shared_from_this());
  SceneBuffers buffers(device, scene);
  PointForest forest(device, scheduler, scene, buffers, {.points_log2 = 13}, "test");
  REQUIRE(forest.trees().size() == 2);
  CHECK(violations(forest) == 0);
  CHECK_FALSE(forest.loosened());

  SceneChange change;
  change.deformed_instances = {0};
  const auto deform = [&](float amount) {
    Mesh pose = scene.meshes[0];
    for (glm::vec3& p : pose.positions)
      p = p * glm::vec3(1 + amount, 1 - 0.5f * amount, 1) + glm::vec3(amount * p.y, 0, 0);
    scene.instances[0].pose = std::make_shared<Mesh>(std::move(pose));
    buffers.update(scene, change);
    return forest.update(change);
  };
  CHECK(deform(0.3f));
  CHECK(violations(forest) == 0);
  // Back again: the same nodes as at the beginning.
  const std::vector<uint4> bent = forest.nodes.download();
  CHECK(deform(0));
  CHECK(violations(forest) == 0);
  CHECK(forest.nodes.download()[forest.trees()[1].record.first_node + 1].y !=
        bent[forest.trees()[1].record.first_node + 1].y);
}

TEST_CASE("a pose that folds neighbours apart asks for a new tree") {
  Scene scene;
  scene.source = "test:sheet";
  MeshBuilder sheet("sheet");
  for (int j = 0; j < 16; ++j)
    for (int i = 0; i < 16; ++i) sheet.quad({i, 0, j}, {i, 0, j + 1}, {i + 1, 0, j + 1}, {i + 1, 0, j});
  add_instance(scene, add_mesh(scene, sheet.take()), add_lambert(scene, "grey", glm::vec3(0.5f)));
  scene.instances[0].pose = std::make_shared<Mesh>(scene.meshes[0]);
  Device& device = *test::test_device();
  KernelScheduler scheduler(device.shared_from_this());
  SceneBuffers buffers(device, scene);
  PointForest forest(device, scheduler, scene, buffers, {.points_log2 = 12}, "test");
  // Every other square moves far away.
  Mesh pose = scene.meshes[0];
  for (size_t v = 0; v < pose.positions.size(); ++v)
    if (v / 4 % 2) pose.positions[v].y += 40;
  scene.instances[0].pose = std::make_shared<Mesh>(std::move(pose));
  SceneChange change;
  change.deformed_instances = {0};
  buffers.update(scene, change);
  CHECK_FALSE(forest.update(change));
  CHECK(forest.loosened());
  // A run that begins in this pose finds the same.
  CHECK(PointForest(device, scheduler, scene, buffers, {.points_log2 = 12}, "test").loosened());
  // One that is ordered as it stands now has small nodes and keeps them.
  PointForest posed(device, scheduler, scene, buffers, {.points_log2 = 12, .posed = true}, "test");
  CHECK_FALSE(posed.loosened());
  CHECK(posed.update(change));
  CHECK(violations(posed) == 0);
  const auto radii = [](const PointForest& f) {
    const MicroTree& tree = f.trees().front().record;
    double sum = 0;
    for (const uint4& node : f.nodes.download(tree.first_node + 256, 256))
      sum += static_cast<double>(unpack(node).radius * tree.world_step);
    return sum;
  };
  CHECK(radii(forest) > 1.5 * radii(posed));  // beyond which a tree is too loose
}

TEST_CASE("the work of a refit is in proportion to the points") {
  // Every inner node is merged once: ranges of levels [top, bottom) follow each other from the leaves to the root, and
  // 2^top work-items merge 2^(bottom - top) - 1 nodes each.
  for (uint32_t depth = 1; depth <= 23; ++depth) {
    uint64_t merged = 0;
    uint32_t reached = depth;
    PointForest::for_level_ranges(depth, [&](uint32_t top, uint32_t bottom) {
      CHECK(bottom == reached);
      CHECK(top < bottom);
      merged += (uint64_t{1} << top) * ((uint64_t{1} << (bottom - top)) - 1);
      reached = top;
    });
    CHECK(reached == 0);
    CHECK(merged == (uint64_t{1} << depth) - 1);
  }
  // And an update is one such refit: its launches are one for the leaves and one per range. Times are only shown.
  Scene scene;
  scene.source = "test:ball";
  add_ball(scene);
  scene.instances[0].pose = std::make_shared<Mesh>(scene.meshes[0]);
  Device& device = *test::test_device();
  SceneBuffers buffers(device, scene);
  SceneChange change;
  change.deformed_instances = {0};
  for (const int points_log2 : test::full_run() ? std::vector{14, 16, 18, 20} : std::vector{12, 14}) {
    KernelScheduler scheduler(device.shared_from_this());
    PointForest forest(device, scheduler, scene, buffers, {.points_log2 = points_log2}, "test");
    const auto launches = [&](const std::string& pass) {
      uint64_t count = 0;
      for (const PassProfile& p : scheduler.profile().passes) count += p.name == pass ? p.count : 0;
      return count;
    };
    const uint64_t leaves_before = launches("update leaves"), refits_before = launches("refit");
    constexpr int updates = 5;
    double best = 1e9;
    for (int repeat = 0; repeat < updates; ++repeat) {
      CHECK(forest.update(change));
      best = std::min(best, forest.updating_seconds());
    }
    uint64_t ranges = 0;
    PointForest::for_level_ranges(static_cast<uint32_t>(points_log2), [&](uint32_t, uint32_t) { ++ranges; });
    CHECK(launches("update leaves") - leaves_before == updates);
    CHECK(launches("refit") - refits_before == updates * ranges);
    MESSAGE((1 << points_log2), " points: ", 1e3 * best, " ms, ", 1e9 * best / (1 << points_log2), " ns per point");
  }
}

TEST_CASE(
    "nodes know the border of their surface: lines lie on it, and nodes in its middle or in hollow edges have none") {
  // A rectangle of two triangles, turned; and a room from inside, whose edges are hollow.
  const glm::mat3 turn(glm::rotate(glm::mat4(1), 0.5f, glm::normalize(glm::vec3(1, 2, 3))));
  for (const bool room : {false, true}) {
    Scene scene;
    scene.source = "test:border";
    MeshBuilder builder("surface");
    if (room)
      for (int axis = 0; axis < 3; ++axis)
        for (int side = 0; side < 2; ++side) builder.box_face({0, 0, 0}, {1, 2, 3}, axis, side, true);
    else
      builder.quad(turn * glm::vec3(-1, -2, 0), turn * glm::vec3(1, -2, 0), turn * glm::vec3(1, 2, 0),
                   turn * glm::vec3(-1, 2, 0));
    add_instance(scene, add_mesh(scene, builder.take()), add_lambert(scene, "grey", glm::vec3(0.5f)));
    KernelScheduler scheduler(test::test_device());
    const SceneBuffers buffers(*test::test_device(), scene);
    const PointForest forest(*test::test_device(), scheduler, scene, buffers, {.points_log2 = 12}, "test");
    const std::vector<uint4> nodes = forest.nodes.download();
    const MicroTree& tree = forest.trees().front().record;
    size_t lines = 0, beside = 0, at_border = 0, missed = 0;
    for (uint32_t i = 1u << 8; i < 2u << 8; ++i) {  // of 16 leaves
      const PackedNode node = unpack(nodes[tree.first_node + i]);
      lines += node.line != glm::vec3(0);
      if (room) continue;
      // How far the four sides of the rectangle are from the node, and its line from the next of them [m].
      const float step = tree.origin_step.w;
      const glm::vec3 center =
          glm::transpose(turn) *
          (glm::vec3(tree.origin_step.x, tree.origin_step.y, tree.origin_step.z) + step * node.center);
      const glm::vec3 m = glm::transpose(turn) * node.line;
      const glm::vec2 to_sides(1 - std::abs(center.x), 2 - std::abs(center.y));
      const float size = std::sqrt(8.f / 256), nearest = std::min(to_sides.x, to_sides.y);
      at_border += nearest < 0.5f * size;
      missed += nearest < 0.5f * size && node.line == glm::vec3(0);
      if (node.line == glm::vec3(0)) continue;
      const bool along_x = std::abs(m.x) > std::abs(m.y);
      const float side = along_x ? to_sides.x : to_sides.y;
      beside += std::abs(step * node.reach - side) > 0.05f * size || m[along_x ? 0 : 1] * center[along_x ? 0 : 1] < 0;
    }
    MESSAGE(lines, " lines, ", at_border, " at the border, ", missed, " without, ", beside, " beside it");
    CHECK(beside == 0);
    if (room) {
      CHECK(lines == 0);
    } else {
      CHECK(at_border > 30);
      CHECK(missed * 10 < at_border);
    }
  }
}
