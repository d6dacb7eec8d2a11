// SPDX-License-Identifier: Apache-2.0
// Moving instances: hits are those of a new hierarchy, and only what moved is worked on.
#include <doctest/doctest.h>

#include <cstring>
#include <glm/gtc/matrix_transform.hpp>

#include "lucarium/scene/device/scene_buffers.h"
#include "tracer.h"

using namespace lucarium;
using namespace lucarium::test;

namespace {

Mesh mesh_of(const Soup& soup) {
  Mesh mesh;
  for (const Vertex& vertex : soup.vertices) mesh.positions.push_back(vertex.position.xyz());
  mesh.normals.assign(mesh.positions.size(), {0, 0, 1});
  for (const Triangle& t : soup.triangles) mesh.triangles.push_back({t.v0, t.v1, t.v2});
  return mesh;
}

glm::mat4 random_motion(Random& random) {
  const glm::mat4 turned = glm::rotate(glm::mat4(1.f), random.uniform(0, 6.28f), random.direction());
  return glm::translate(glm::mat4(1.f), random.in_cube(20)) * turned;
}

/// Rough spheres at random places, each on a node of its own; the first `animated` nodes have an animation.
Scene make_spheres(uint32_t count, uint32_t animated, Random& random) {
  Scene scene;
  scene.source = "test";
  scene.meshes = {mesh_of(rough_sphere(12, 16, 5))};
  scene.materials.resize(1);
  for (uint32_t i = 0; i < count; ++i) {
    Node node;
    node.matrix = random_motion(random);
    scene.nodes.push_back(node);
    SceneInstance instance;
    instance.node = static_cast<int>(i);
    instance.mesh = instance.material = 0;
    scene.instances.push_back(instance);
  }
  Animation animation;
  for (uint32_t i = 0; i < animated; ++i) {
    AnimationChannel channel;
    channel.node = static_cast<int>(i);
    channel.times = {0};
    channel.values = {0, 0, 0};
    animation.channels.push_back(channel);
  }
  if (animated > 0) scene.animations.push_back(animation);
  evaluate(scene, 0, none);
  return scene;
}

/// Rays through the space in which the spheres are.
std::vector<Ray> rays_through(uint32_t count, uint32_t seed) {
  std::vector<Ray> rays;
  Random random(seed);
  for (uint32_t i = 0; i < count; ++i) {
    const glm::vec3 from = random.in_cube(25), to = random.in_cube(20);
    rays.push_back(make_ray(from, glm::normalize(to - from), i % 2 ? INFINITY : random.uniform(1, 60)));
  }
  return rays;
}

/// A scene on the device with its hierarchy, which can be moved and compared with a new one.
struct MovingScene {
  MovingScene(Tracer& t, Scene s, BvhTraversal traversal)
      : tracer(t),
        scene(std::move(s)),
        buffers(tracer.device(), scene),
        bvh(tracer.device(), scene, buffers, traversal) {}

  void move(const std::vector<int>& instances, Random& random) {
    for (const int i : instances) scene.nodes[static_cast<size_t>(i)].matrix = random_motion(random);
    const SceneChange change = evaluate(scene, 0, none);
    REQUIRE(change.moved_instances == instances);
    buffers.update(scene, change);
    bvh.update(scene, buffers, change);
  }

  void check_hits() {
    const std::vector<Ray> rays = rays_through(4000, 17);
    const Bvh fresh(tracer.device(), scene, buffers, bvh.traversal());
    const Results moved = tracer.trace(bvh, rays), expected = tracer.trace(fresh, rays);
    CHECK(std::memcmp(moved.hits.data(), expected.hits.data(), rays.size() * sizeof(Hit)) == 0);
    CHECK(moved.occluded == expected.occluded);
  }

  Tracer& tracer;
  Scene scene;
  SceneBuffers buffers;
  Bvh bvh;
};

}  // namespace

TEST_CASE("animated instances move without building anything, however far") {
  Tracer tracer;
  Random random(3);
  for (const BvhTraversal traversal : traversals) {
    MovingScene moving(tracer, make_spheres(8, 3, random), traversal);
    CHECK(moving.bvh.statistics().parts == 4);  // what rests, and three
    CHECK(moving.bvh.statistics().triangles == 8 * 2 * 16 * 11);
    moving.check_hits();
    const uint64_t builds = moving.bvh.statistics().part_builds, generation = moving.bvh.generation();
    for (const std::vector<int>& instances : {std::vector<int>{0}, {1, 2}, {0, 1, 2}}) {
      moving.move(instances, random);
      moving.check_hits();
    }
    CHECK(moving.bvh.statistics().part_builds == builds);
    CHECK(moving.bvh.statistics().part_refits == 6);
    CHECK(moving.bvh.generation() == generation);
  }
}

TEST_CASE("instances that nobody announced cost one build when they move far, and none after that") {
  Tracer tracer;
  Random random(4);
  Scene scene = make_spheres(60, 0, random);
  for (Node& node : scene.nodes) node.matrix = glm::scale(*node.matrix, glm::vec3(0.2f));  // small: clusters matter
  evaluate(scene, 0, none);
  MovingScene moving(tracer, scene, BvhTraversal::wide);
  CHECK(moving.bvh.statistics().parts == 1);
  CHECK(moving.bvh.statistics().part_builds == 1);
  const std::vector<int> movers = {3, 8, 14, 15, 27, 31, 40, 42, 55, 58};
  moving.move(movers, random);
  CHECK(moving.bvh.statistics().parts == 11);
  CHECK(moving.bvh.statistics().part_builds == 1 + 11);
  moving.check_hits();
  for (int step = 0; step < 3; ++step) moving.move(movers, random);
  CHECK(moving.bvh.statistics().part_builds == 1 + 11);
  moving.check_hits();
}

TEST_CASE("a deformed instance is refitted, and rebuilt alone when it has changed too much") {
  Tracer tracer;
  Random random(5);
  Scene scene = make_spheres(4, 0, random);
  scene.instances[1].pose = std::make_shared<Mesh>(scene.meshes[0]);
  MovingScene moving(tracer, std::move(scene), BvhTraversal::wide);
  CHECK(moving.bvh.statistics().parts == 2);
  const uint64_t builds = moving.bvh.statistics().part_builds;
  const auto deform = [&](float strength) {
    Mesh pose = moving.scene.meshes[0];
    for (glm::vec3& p : pose.positions) p += random.in_cube(strength);
    moving.scene.instances[1].pose = std::make_shared<Mesh>(pose);
    SceneChange change;
    change.deformed_instances = {1};
    moving.buffers.update(moving.scene, change);
    moving.bvh.update(moving.scene, moving.buffers, change);
    moving.check_hits();
  };
  deform(0.02f);
  CHECK(moving.bvh.statistics().part_builds == builds);
  deform(5);
  CHECK(moving.bvh.statistics().part_builds == builds + 1);
}

TEST_CASE("parts without triangles, or with none that can be hit, are no trouble") {
  Tracer tracer;
  Random random(6);
  Scene scene = make_spheres(3, 3, random);  // nothing rests
  MovingScene all_move(tracer, scene, BvhTraversal::wide);
  all_move.move({0, 1, 2}, random);
  all_move.check_hits();
  Mesh flat = scene.meshes[0];
  for (glm::vec3& p : flat.positions) p = glm::vec3(1);
  scene.meshes.push_back(flat);
  scene.instances[2].mesh = 1;
  MovingScene with_flat(tracer, scene, BvhTraversal::wide);
  CHECK(with_flat.bvh.statistics().ignored_triangles == flat.triangles.size());
  with_flat.move({0, 2}, random);
  with_flat.check_hits();
}
