// SPDX-License-Identifier: Apache-2.0
// Animations, skins and morph targets of glTF, each on a small file made here.
#include <doctest/doctest.h>

#include "gltf_builder.h"
#include "lucarium/base/error.h"
#include "lucarium/scene/load/load_scene.h"
#include "scene_support.h"
#include "tolerance.h"

using namespace lucarium;
using test::GltfBuilder;
using test::load;
using test::warns;
using Json = nlohmann::json;

namespace {

/// A triangle whose node has one animated property.
GltfBuilder animated(const char* path, int times, int values, const char* interpolation, GltfBuilder builder) {
  builder.json["animations"] = {
      {{"channels", {{{"sampler", 0}, {"target", {{"node", 0}, {"path", path}}}}}},
       {"samplers", {{{"input", times}, {"output", values}, {"interpolation", interpolation}}}}}};
  return builder;
}

}  // namespace

TEST_CASE("Linear, stepped and cubic translation") {
  GltfBuilder builder = GltfBuilder::triangle();
  const int times = builder.add_floats({{1}, {3}}, "SCALAR");
  const int values = builder.add_floats({{0, 0, 0}, {4, 0, 0}}, "VEC3");
  const int cubic = builder.add_floats({{0, 0, 0}, {0, 0, 0}, {0, 0, 0}, {0, 0, 0}, {4, 0, 0}, {0, 0, 0}}, "VEC3");
  const auto x_at = [&](const GltfBuilder& document, double seconds) {
    Scene scene = load(document);
    CHECK(scene.animations.at(0).duration == 3.f);
    evaluate(scene, seconds);
    return scene.instances[0].world_from_object[3].x;
  };
  const GltfBuilder linear = animated("translation", times, values, "LINEAR", builder);
  CHECK(x_at(linear, 1.5) == test::relative(1));
  CHECK(x_at(linear, 0.5) == test::within(0, 1e-6));
  CHECK(x_at(animated("translation", times, values, "STEP", builder), 2.9) == test::within(0, 1e-6));
  // Hermite with zero tangents: 3t² − 2t³ at t = 1/4.
  CHECK(x_at(animated("translation", times, cubic, "CUBICSPLINE", builder), 1.5) == test::relative(4 * 0.15625));
}

TEST_CASE("Normalized integer rotations") {
  GltfBuilder builder = GltfBuilder::triangle();
  const int times = builder.add_floats({{0}, {1}}, "SCALAR");
  const int values = builder.add(std::vector<int16_t>{0, 0, 0, 32767, 0, 0, 32767, 0}, "VEC4", true);
  Scene scene = load(animated("rotation", times, values, "LINEAR", builder));
  evaluate(scene, 0.5);
  CHECK(test::largest_difference(glm::vec3(scene.instances[0].world_from_object[0]), {0, 1, 0}) < 1e-4f);
}

TEST_CASE("Animations that make no sense") {
  GltfBuilder builder = GltfBuilder::triangle();
  const int times = builder.add_floats({{0}, {1}}, "SCALAR"), falling = builder.add_floats({{1}, {0}}, "SCALAR");
  const int values = builder.add_floats({{0, 0, 0}, {4, 0, 0}}, "VEC3"), one = builder.add_floats({{0, 0, 0}}, "VEC3");
  CHECK_THROWS_WITH_AS(load(animated("translation", falling, values, "LINEAR", builder)), doctest::Contains("ascend"),
                       Error);
  CHECK_THROWS_WITH_AS(load(animated("translation", times, one, "LINEAR", builder)),
                       doctest::Contains("3 numbers for 2 keys"), Error);
  CHECK_THROWS_WITH_AS(load(animated("rotation", times, values, "LINEAR", builder)), doctest::Contains("not 4"), Error);
  CHECK(warns(load(animated("weights", times, values, "LINEAR", builder)), "no morph targets"));
  CHECK(warns(load(animated("pointer", times, values, "LINEAR", builder)), "'pointer' is not supported"));
}

TEST_CASE("Morph targets, sparse and weighted by the node over the mesh") {
  GltfBuilder builder = GltfBuilder::triangle();
  const std::vector<uint8_t> indices = {1};
  const std::vector<float> deltas = {0, 0, 2};
  const int target = builder.add_accessor(-1, 5126, 3, "VEC3");
  builder.json["accessors"][target]["sparse"] = {
      {"count", 1},
      {"indices", {{"bufferView", builder.add_view(indices.data(), 1)}, {"componentType", 5121}}},
      {"values", {{"bufferView", builder.add_view(deltas.data(), 12)}}}};
  builder.json["meshes"][0]["primitives"][0]["targets"] = {{{"POSITION", target}}, {{"NORMAL", target}}};
  builder.json["meshes"][0]["weights"] = {0.5, 0};
  Scene scene = load(builder);
  CHECK(warns(scene, "moves NORMAL, which the mesh does not have"));
  evaluate(scene, 0);
  REQUIRE(scene.instances.at(0).pose);
  CHECK(scene.instances[0].pose->positions[1] == glm::vec3(1, 0, 1));
  builder.json["nodes"][0]["weights"] = {1, 0};
  scene = load(builder);
  evaluate(scene, 0);
  CHECK(scene.instances[0].pose->positions[1] == glm::vec3(1, 0, 2));
}

TEST_CASE("Animated morph weights") {
  GltfBuilder builder = GltfBuilder::triangle();
  const int target = builder.add_floats({{0, 0, 0}, {0, 0, 2}, {0, 0, 0}}, "VEC3");
  builder.json["meshes"][0]["primitives"][0]["targets"] = {{{"POSITION", target}}};
  const int times = builder.add_floats({{0}, {1}}, "SCALAR"), values = builder.add_floats({{0}, {1}}, "SCALAR");
  Scene scene = load(animated("weights", times, values, "LINEAR", builder));
  evaluate(scene, 0.25);
  CHECK(scene.instances.at(0).pose->positions[1].z == test::relative(0.5));
}

namespace {

/// A triangle whose three vertices hang on joints given as (joints, weights) of two sets; two joints, of which the
/// second is moved by (0, 0, 1).
GltfBuilder skinned(const std::vector<uint8_t>& joints0, const std::vector<std::vector<float>>& weights0) {
  GltfBuilder builder = GltfBuilder::triangle();
  auto& attributes = builder.json["meshes"][0]["primitives"][0]["attributes"];
  attributes["JOINTS_0"] = builder.add(joints0, "VEC4");
  attributes["WEIGHTS_0"] = builder.add_floats(weights0, "VEC4");
  builder.json["nodes"][0]["skin"] = 0;
  builder.append("nodes", Json::object());
  builder.append("nodes", {{"translation", {0, 0, 1}}});
  builder.json["scenes"][0]["nodes"] = {0, 1, 2};
  builder.json["skins"] = {{{"joints", {1, 2}}}};
  return builder;
}

const std::vector<uint8_t> joints_012 = {0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0};

}  // namespace

TEST_CASE("Skins: weights are normalized, the node's own transform is ignored") {
  GltfBuilder builder = skinned(joints_012, {{1, 0, 0, 0}, {2, 0, 0, 0}, {0.5, 0.5, 0, 0}});
  builder.json["nodes"][0]["translation"] = {9, 9, 9};
  Scene scene = load(builder);
  CHECK(warns(scene, "joint weights"));
  evaluate(scene, 0);
  const Mesh& pose = *scene.instances.at(0).pose;
  CHECK(pose.positions[0] == glm::vec3(0, 0, 0));
  CHECK(pose.positions[1] == glm::vec3(1, 0, 1));
  CHECK(pose.positions[2] == glm::vec3(0, 1, 0.5f));
}

TEST_CASE("The strongest four of eight joints are kept") {
  GltfBuilder builder =
      skinned({0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}, {{0.1f, 0.1f, 0.05f, 0.05f}, {1, 0, 0, 0}, {1, 0, 0, 0}});
  auto& attributes = builder.json["meshes"][0]["primitives"][0]["attributes"];
  attributes["JOINTS_1"] = builder.add(std::vector<uint8_t>{1, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}, "VEC4");
  attributes["WEIGHTS_1"] = builder.add_floats({{0.4f, 0.3f, 0, 0}, {0, 0, 0, 0}, {0, 0, 0, 0}}, "VEC4");
  Scene scene = load(builder);
  CHECK(warns(scene, "strongest 4"));
  const Mesh& mesh = scene.meshes.at(0);
  CHECK(mesh.joints[0] == std::array<uint16_t, 4>{1, 1, 0, 0});
  CHECK(mesh.weights[0].x == test::relative(0.4 / 0.9));
  CHECK(mesh.weights[0].w == test::relative(0.1 / 0.9));
}

TEST_CASE("Skins that do not fit their mesh") {
  const std::vector<std::vector<float>> ones = {{1, 0, 0, 0}, {1, 0, 0, 0}, {1, 0, 0, 0}};
  CHECK_THROWS_WITH_AS(load(skinned({0, 0, 0, 0, 2, 0, 0, 0, 0, 0, 0, 0}, ones)),
                       doctest::Contains("refers to joint 2"), Error);
  // Joints without weight do not count.
  CHECK(load(skinned({0, 9, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0}, ones)).skins.size() == 1);
  GltfBuilder builder = skinned(joints_012, ones);
  builder.json["meshes"][0]["primitives"][0]["attributes"].erase("WEIGHTS_0");
  CHECK_THROWS_WITH_AS(load(builder), doctest::Contains("must come together"), Error);
  builder = skinned(joints_012, ones);
  builder.json["skins"][0]["inverseBindMatrices"] = builder.add(std::vector<float>(16, 0.f), "MAT4");
  CHECK_THROWS_WITH_AS(load(builder), doctest::Contains("1 inverse bind matrices do not suffice for 2 joints"), Error);
}
