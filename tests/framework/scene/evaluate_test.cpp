// SPDX-License-Identifier: Apache-2.0
#include <doctest/doctest.h>

#include <glm/gtc/matrix_transform.hpp>

#include "lucarium/base/error.h"
#include "lucarium/scene/animation.h"
#include "scene_support.h"
#include "tolerance.h"

using namespace lucarium;
using test::largest_difference;

namespace {

glm::vec3 world_position(const Scene& scene, int instance, int vertex) {
  const SceneInstance& i = scene.instances[instance];
  return glm::vec3(i.world_from_object * glm::vec4(i.shape(scene).positions[vertex], 1.f));
}

AnimationChannel translation_channel(int node, std::vector<float> times, std::vector<float> values,
                                     Interpolation interpolation = Interpolation::linear) {
  return {node, AnimationPath::translation, interpolation, std::move(times), std::move(values)};
}

Scene animated(AnimationChannel channel, float duration, Mesh mesh = test::triangle_mesh()) {
  Scene scene = test::one_node_scene(std::move(mesh));
  scene.animations.push_back({"move", {std::move(channel)}, duration});
  return scene;
}

}  // namespace

TEST_CASE("node transforms compose translation, rotation and scale, parents first") {
  Scene scene = test::one_node_scene(test::triangle_mesh());
  // The child is scaled by (2, 3, 4), then turned by 90 degrees about Z, then moved by (1, 0, 0); the parent moves by
  // (0, 0, 5) and doubles. Vertex 1 = (1, 0, 0) -> (2, 0, 0) -> (0, 2, 0) -> (1, 2, 0) -> (2, 4, 0) -> (2, 4, 5).
  Node parent;
  parent.translation = {0, 0, 5};
  parent.scale = glm::vec3(2);
  parent.children = {0};
  scene.nodes[0].parent = 1;
  scene.nodes[0].translation = {1, 0, 0};
  scene.nodes[0].rotation = glm::angleAxis(glm::radians(90.f), glm::vec3(0, 0, 1));
  scene.nodes[0].scale = {2, 3, 4};
  scene.nodes.push_back(parent);
  evaluate(scene, 0);
  CHECK(largest_difference(world_position(scene, 0, 1), {2, 4, 5}) < 1e-6f);
  // Vertex 2 = (0, 1, 0) -> (0, 3, 0) -> (-3, 0, 0) -> (-2, 0, 0) -> (-4, 0, 5).
  CHECK(largest_difference(world_position(scene, 0, 2), {-4, 0, 5}) < 1e-6f);
}

TEST_CASE("a matrix node keeps its matrix") {
  Scene scene = test::one_node_scene(test::triangle_mesh());
  scene.nodes[0].matrix = glm::translate(glm::mat4(1.f), glm::vec3(0, 7, 0));
  evaluate(scene, 0);
  CHECK(world_position(scene, 0, 0) == glm::vec3(0, 7, 0));
}

TEST_CASE("linear and step interpolation, clamped at the ends and looped over the duration") {
  Scene scene = animated(translation_channel(0, {1, 2}, {0, 0, 0, 4, 0, 0}), 4);
  const float expected[][2] = {{0, 0}, {1.25f, 1}, {1.5f, 2}, {3, 4}, {5.25f, 1}, {-2.5f, 2}};
  for (const auto& [time, x] : expected) {
    CAPTURE(time);
    evaluate(scene, time);
    CHECK(world_position(scene, 0, 0).x == test::relative(x));
  }
  scene.animations[0].channels[0].interpolation = Interpolation::step;
  evaluate(scene, 1.99);
  CHECK(world_position(scene, 0, 0).x == 0);
  evaluate(scene, 2);
  CHECK(world_position(scene, 0, 0).x == 4);
}

TEST_CASE("cubic splines follow the Hermite form of glTF's appendix C") {
  // Keys at 0 and 2 s: v0 = 1 with out-tangent 3, v1 = 5 with in-tangent -1. At 0.5 s, s = 1/4:
  // (2/64 - 3/16 + 1) 1 + 2 (1/64 - 2/16 + 1/4) 3 + (3/16 - 2/64) 5 + 2 (1/64 - 1/16) (-1)
  //   = 0.84375 + 0.84375 + 0.78125 + 0.09375 = 2.5625.
  AnimationChannel channel{0, AnimationPath::translation, Interpolation::cubic_spline, {0, 2}, {}};
  channel.values = {0, 0, 0, 1, 0, 0, 3, 0, 0, -1, 0, 0, 5, 0, 0, 0, 0, 0};
  CHECK(sample_channel(channel, 0.5)[0] == test::relative(2.5625));
  CHECK(sample_channel(channel, -1)[0] == 1);
  CHECK(sample_channel(channel, 3)[0] == 5);
}

TEST_CASE("rotations are interpolated spherically over the shorter arc") {
  // From 0 to 120 degrees about Y, the second quaternion with flipped sign: the middle is 60 degrees.
  const glm::quat end = -glm::angleAxis(glm::radians(120.f), glm::vec3(0, 1, 0));
  const AnimationChannel channel{
      0, AnimationPath::rotation, Interpolation::linear, {0, 1}, {0, 0, 0, 1, end.x, end.y, end.z, end.w}};
  const std::vector<float> q = sample_channel(channel, 0.5);
  CHECK(std::abs(q[1]) == test::relative(0.5));
  CHECK(std::abs(q[3]) == test::relative(std::sqrt(0.75)));
  CHECK(q[1] * q[3] > 0);
}

TEST_CASE("morph targets are added by weight; animated weights win over the node's") {
  Mesh mesh = test::triangle_mesh();
  mesh.flat_normals = true;
  MorphTarget up, shift;
  up.positions = {{0, 0, 0}, {0, 0, 0}, {0, -1, 1}};
  shift.positions.assign(3, glm::vec3(1, 0, 0));
  mesh.morph_targets = {up, shift};
  Scene scene = animated({0, AnimationPath::weights, Interpolation::linear, {0, 1}, {0, 0, 1, 0.5f}}, 2, mesh);
  scene.nodes[0].morph_weights = {0, 4};
  SUBCASE("rest") {
    evaluate(scene, 0, none);
    CHECK(world_position(scene, 0, 0) == glm::vec3(4, 0, 0));
  }
  SUBCASE("animated") {
    evaluate(scene, 1);
    CHECK(largest_difference(world_position(scene, 0, 2), {0.5f, 0, 1}) < 1e-6f);
    // The triangle (0,0,0) (1,0,0) (0,0,1) faces -Y.
    CHECK(largest_difference(scene.instances[0].pose->normals[0], {0, -1, 0}) < 1e-6f);
  }
}

TEST_CASE("skinning blends the joints' matrices") {
  Mesh mesh = test::triangle_mesh();
  mesh.joints = {{0, 1, 0, 0}, {0, 1, 0, 0}, {0, 1, 0, 0}};
  mesh.weights = {{1, 0, 0, 0}, {0.25f, 0.75f, 0, 0}, {0, 2, 0, 0}};
  Scene scene = test::one_node_scene(mesh);
  scene.nodes[0].skin = 0;
  scene.nodes[0].translation = {100, 0, 0};  // ignored for skinned meshes
  Node still, moved;
  moved.translation = {0, 8, 0};
  scene.nodes.push_back(still);
  scene.nodes.push_back(moved);
  // Joint 1's bind position is (0, 2, 0): its inverse bind matrix takes 2 away.
  scene.skins.push_back({"", {1, 2}, {glm::mat4(1.f), glm::translate(glm::mat4(1.f), glm::vec3(0, -2, 0))}});
  evaluate(scene, 0);
  CHECK(scene.instances[0].world_from_object == glm::mat4(1.f));
  CHECK(largest_difference(world_position(scene, 0, 0), {0, 0, 0}) < 1e-6f);
  CHECK(largest_difference(world_position(scene, 0, 1), {1, 4.5f, 0}) < 1e-6f);  // 0.75 x 6
  CHECK(largest_difference(world_position(scene, 0, 2), {0, 7, 0}) < 1e-6f);     // weights are normalized
  CHECK_FALSE(scene.instances[0].mirrored);

  scene.nodes[1].scale = scene.nodes[2].scale = {-1, 1, 1};
  evaluate(scene, 0);
  CHECK(scene.instances[0].mirrored);
}

TEST_CASE("SceneChange names exactly what changed") {
  Scene scene = animated(translation_channel(0, {0, 1}, {0, 0, 0, 2, 0, 0}), 2);
  Node still;
  still.translation = {0, 1, 0};
  scene.nodes.push_back(still);
  SceneInstance second = scene.instances[0];
  second.node = 1;
  scene.instances.push_back(second);
  SceneLight light;
  light.node = 1;
  scene.lights.push_back(light);
  SceneCamera camera;
  camera.node = 0;
  scene.cameras.push_back(camera);

  SceneChange change = evaluate(scene, 0.25);
  CHECK(change.moved_instances == std::vector<int>{0, 1});  // the first evaluation places everything
  CHECK(change.lights);
  change = evaluate(scene, 0.5);
  REQUIRE(change.moved_instances == std::vector<int>{0});
  CHECK(change.previous_world_from_object[0][3] == glm::vec4(0.5f, 0, 0, 1));
  CHECK(scene.instances[0].world_from_object[3] == glm::vec4(1, 0, 0, 1));
  CHECK(change.camera);
  CHECK_FALSE(change.lights);
  CHECK(change.deformed_instances.empty());
  CHECK_FALSE(change.topology);
  CHECK(change.time == 0.5);
  CHECK_FALSE(evaluate(scene, 0.5).any());
}

TEST_CASE("an animation that does not exist is refused") {
  Scene scene = animated(translation_channel(0, {0}, {0, 0, 0}), 1);
  CHECK_THROWS_AS(evaluate(scene, 0, 1), Error);
}
