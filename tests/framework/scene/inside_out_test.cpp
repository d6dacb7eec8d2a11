// SPDX-License-Identifier: Apache-2.0
// A closed mesh whose triangles are wound inside out renders black: it must be found, and nothing else be taken for
// one.
#include "lucarium/scene/inside_out.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <glm/gtc/matrix_transform.hpp>

#include "lucarium/base/error.h"
#include "lucarium/scene/load/load_scene.h"
#include "scene_support.h"

using namespace lucarium;

namespace {

/// A tetrahedron of the origin and the units, wound outwards; each face with vertices of its own, as in flat shading.
Mesh tetrahedron() {
  const glm::vec3 o(0), x(1, 0, 0), y(0, 1, 0), z(0, 0, 1);
  Mesh mesh;
  mesh.name = "solid";
  mesh.positions = {o, y, x, o, z, y, o, x, z, x, y, z};
  mesh.normals.assign(12, glm::vec3(0, 0, 1));
  mesh.triangles = {{0, 1, 2}, {3, 4, 5}, {6, 7, 8}, {9, 10, 11}};
  return mesh;
}

void turn_over(Mesh& mesh) {
  for (glm::uvec3& t : mesh.triangles) std::swap(t.y, t.z);
}

/// The mesh, seen from (5, 5, 5).
Scene scene_of(Mesh mesh) {
  Scene scene = test::one_node_scene(std::move(mesh));
  scene.cameras.emplace_back();
  scene.cameras[0].world_from_camera = glm::translate(glm::mat4(1.f), glm::vec3(5));
  return scene;
}

const std::vector<std::string> nothing, solid = {"solid"};

}  // namespace

TEST_CASE("a closed mesh is inside out when it encloses a negative volume") {
  Scene scene = scene_of(tetrahedron());
  CHECK(meshes_inside_out(scene) == nothing);
  turn_over(scene.meshes[0]);
  CHECK(meshes_inside_out(scene) == solid);
  scene.instances.push_back(scene.instances[0]);
  CHECK(meshes_inside_out(scene) == solid);  // each name once
}

TEST_CASE("far from the origin, and mirrored by its matrix, it is found all the same") {
  Scene scene = scene_of(tetrahedron());
  turn_over(scene.meshes[0]);
  scene.instances[0].world_from_object = glm::translate(glm::mat4(1.f), glm::vec3(1000, 2000, -500));
  CHECK(meshes_inside_out(scene) == solid);
  // A reflection turns triangles over when they are derived: what was wrong stays wrong, what was right right.
  scene.instances[0].world_from_object = glm::scale(glm::mat4(1.f), glm::vec3(-1, 1, 1));
  CHECK(meshes_inside_out(scene) == solid);
  turn_over(scene.meshes[0]);
  CHECK(meshes_inside_out(scene) == nothing);
  for (glm::vec3& p : scene.meshes[0].positions) p += glm::vec3(1e4f, 0, 0);
  turn_over(scene.meshes[0]);
  CHECK(meshes_inside_out(scene) == solid);
}

TEST_CASE("open meshes, two-sided and transmissive ones, and rooms seen from within are as they should be") {
  Scene scene = scene_of(tetrahedron());
  turn_over(scene.meshes[0]);
  scene.materials[0].double_sided = true;
  CHECK(meshes_inside_out(scene) == nothing);
  scene.materials[0] = {};
  scene.materials[0].transmission = 0.5f;
  CHECK(meshes_inside_out(scene) == nothing);
  scene.materials[0] = {};
  scene.cameras[0].world_from_camera = glm::translate(glm::mat4(1.f), glm::vec3(0.1f));  // in the room
  CHECK(meshes_inside_out(scene) == nothing);
  scene.cameras[0].world_from_camera = glm::translate(glm::mat4(1.f), glm::vec3(0.9f));  // beside it, in its box
  CHECK(meshes_inside_out(scene) == solid);
  scene.meshes[0].triangles.pop_back();
  CHECK(meshes_inside_out(scene) == nothing);
}

TEST_CASE("no built-in scene is inside out") {
  for (const char* name : {"cornell", "furnace", "room", "lamps-1", "spheres"}) {
    CAPTURE(name);
    CHECK(meshes_inside_out(load_scene(std::string("builtin:") + name)) == nothing);
  }
}
