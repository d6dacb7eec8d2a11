// SPDX-License-Identifier: Apache-2.0
#include "lucarium/scene/device/scene_buffers.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cstring>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/packing.hpp>
#include <random>

#include "device_fixture.h"
#include "lucarium/base/error.h"
#include "lucarium/compute/program/source_library.h"
#include "lucarium/scene/deform.h"
#include "lucarium/shared/light_tree.h"
#include "scene_support.h"
#include "tolerance.h"

extern const lucarium::EmbeddedSources& test_scene_kernels();

using namespace lucarium;
using test::largest_difference;

namespace {

Mesh random_mesh(unsigned seed, int triangles) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> uniform(-1, 1);
  Mesh mesh;
  mesh.name = "random " + std::to_string(seed);
  const auto vec3 = [&] { return glm::vec3(uniform(random), uniform(random), uniform(random)); };
  for (int i = 0; i < 3 * triangles; ++i) {
    mesh.positions.push_back(vec3());
    mesh.normals.push_back(glm::normalize(vec3()));
    mesh.tangents.emplace_back(glm::normalize(vec3()), i % 2 ? 1.f : -1.f);
    mesh.uv[0].emplace_back(uniform(random), uniform(random));
    mesh.uv[1].emplace_back(uniform(random), uniform(random));
    mesh.colors.emplace_back(0.25f, 0.5f, 1.f, 0.75f);
  }
  for (uint32_t i = 0; i < static_cast<uint32_t>(triangles); ++i)
    mesh.triangles.emplace_back(3 * i, 3 * i + 1, 3 * i + 2);
  return mesh;
}

/// Two meshes in five instances: shared, mirrored, stretched, flattened (rank 2), and one empty mesh between them.
Scene test_scene() {
  Scene scene;
  scene.source = "test";
  scene.meshes = {random_mesh(1, 50), random_mesh(2, 7), Mesh{}};
  scene.materials.resize(2);
  scene.materials[1].emissive_factor = glm::vec3(1);
  const glm::mat4 one(1.f);
  const glm::mat4 turned = glm::rotate(one, 0.7f, glm::normalize(glm::vec3(1, 2, 3)));
  const std::pair<int, glm::mat4> placed[] = {{0, glm::translate(one, glm::vec3(1, 2, 3)) * turned},
                                              {0, turned * glm::scale(one, glm::vec3(-1, 2, 0.5f))},
                                              {2, one},
                                              {1, glm::scale(one, glm::vec3(1, 0, 1))},
                                              {1, glm::scale(one, glm::vec3(-1, -1, -1)) * turned}};
  for (const auto& [mesh, matrix] : placed) {
    Node node;
    node.matrix = matrix;
    scene.nodes.push_back(node);
    SceneInstance instance;
    instance.node = static_cast<int>(scene.nodes.size()) - 1;
    instance.mesh = mesh, instance.material = mesh == 1 ? 1 : 0;
    scene.instances.push_back(instance);
  }
  scene.lights.emplace_back();
  scene.environment = Environment{};
  evaluate(scene, 0);
  return scene;
}

template <class T>
bool same_contents(const TypedBuffer<T>& a, const TypedBuffer<T>& b, size_t count) {
  const std::vector<T> x = a.download(0, count), y = b.download(0, count);
  return x.empty() || std::memcmp(x.data(), y.data(), count * sizeof(T)) == 0;
}

void check_same(const SceneBuffers& a, const SceneBuffers& b) {
  const size_t lights = a.info().light_count;
  CHECK(lights == b.info().light_count);
  CHECK(std::memcmp(&a.info(), &b.info(), sizeof(SceneInfo)) == 0);
  CHECK(same_contents(a.scene_info, b.scene_info, 1));
  CHECK(same_contents(a.scene_vertices, b.scene_vertices, b.scene_vertices.count()));
  CHECK(same_contents(a.scene_triangles, b.scene_triangles, b.scene_triangles.count()));
  CHECK(same_contents(a.scene_instances, b.scene_instances, b.scene_instances.count()));
  CHECK(same_contents(a.scene_materials, b.scene_materials, b.scene_materials.count()));
  CHECK(same_contents(a.scene_lights, b.scene_lights, lights));
  CHECK(same_contents(a.scene_light_table, b.scene_light_table, lights));
  CHECK(same_contents(a.scene_light_places, b.scene_light_places, lights));
  CHECK(same_contents(a.scene_light_trees, b.scene_light_trees, LUCARIUM_LIGHT_TREES_WORDS));
  // The last node of a tree is above lights alone.
  size_t node_words = 0;
  for (const uint place : a.scene_light_places.download(0, lights))
    if (place != LUCARIUM_NONE) node_words = std::max<size_t>(node_words, (place & ~7u) + LUCARIUM_LIGHT_NODE_WORDS);
  CHECK(same_contents(a.scene_light_nodes, b.scene_light_nodes, node_words));
  CHECK(same_contents(a.scene_triangle_lights, b.scene_triangle_lights, b.scene_triangle_lights.count()));
}

}  // namespace

TEST_CASE("derived vertices and triangles equal the host's, mirrored and flattened instances included") {
  const Scene scene = test_scene();
  const SceneBuffers buffers(*test::test_device(), scene);
  const std::vector<Vertex> vertices = buffers.scene_vertices.download();
  const std::vector<Triangle> triangles = buffers.scene_triangles.download();
  REQUIRE(triangles.size() == scene.triangle_count());
  size_t t = 0, wrong = 0, facing_against = 0;
  float worst = 0;
  for (size_t i = 0; i < scene.instances.size(); ++i) {
    const SceneInstance& instance = scene.instances[i];
    const Mesh& mesh = scene.meshes[instance.mesh];
    const glm::mat3 linear(instance.world_from_object);
    const float determinant = glm::determinant(linear);
    for (const glm::uvec3& corners : mesh.triangles) {
      const Triangle& triangle = triangles[t++];
      wrong += triangle.instance != i;
      // The winding is reversed where the determinant is negative.
      const uint device_corners[3] = {triangle.v0, determinant < 0 ? triangle.v2 : triangle.v1,
                                      determinant < 0 ? triangle.v1 : triangle.v2};
      for (int k = 0; k < 3; ++k) {
        const Vertex& v = vertices[device_corners[k]];
        const uint32_t c = corners[k];
        const glm::vec3 position(instance.world_from_object * glm::vec4(mesh.positions[c], 1));
        worst = std::max(worst, largest_difference(v.position.xyz(), position));
        wrong += v.position.w != mesh.uv[0][c].x || v.normal.w != mesh.uv[0][c].y || v.u1 != mesh.uv[1][c].x ||
                 v.v1 != mesh.uv[1][c].y;
        wrong += glm::unpackHalf2x16(v.color_rg) != glm::vec2(0.25f, 0.5f) ||
                 glm::unpackHalf2x16(v.color_ba) != glm::vec2(1, 0.75f);
        wrong += v.tangent.w != (determinant < 0 ? -1.f : 1.f) * mesh.tangents[c].w;
        if (determinant == 0) continue;
        const glm::vec3 normal = glm::normalize(glm::transpose(glm::inverse(linear)) * mesh.normals[c]);
        worst = std::max(worst, largest_difference(v.normal.xyz(), normal));
        worst =
            std::max(worst, largest_difference(v.tangent.xyz(), glm::normalize(linear * glm::vec3(mesh.tangents[c]))));
      }
      // Counter-clockwise seen from the front: the geometric normal is the image of the mesh's.
      if (determinant == 0) continue;
      const auto at = [&](uint index) { return vertices[index].position.xyz(); };
      const glm::vec3 world_normal = glm::cross(at(triangle.v1) - at(triangle.v0), at(triangle.v2) - at(triangle.v0));
      const glm::vec3 object_normal = glm::cross(mesh.positions[corners.y] - mesh.positions[corners.x],
                                                 mesh.positions[corners.z] - mesh.positions[corners.x]);
      const glm::vec3 image = glm::transpose(glm::inverse(linear)) * object_normal;
      facing_against += glm::dot(glm::normalize(world_normal), glm::normalize(image)) < 0.999f;
    }
  }
  CHECK(t == triangles.size());
  CHECK(wrong == 0);
  CHECK(facing_against == 0);
  CHECK(worst < 2e-6f);
}

TEST_CASE("normals of a flattened instance stay perpendicular to it") {
  const glm::mat3 flat(glm::scale(glm::mat4(1.f), glm::vec3(2, 0, 3)));
  CHECK(largest_difference(glm::normalize(normal_matrix(flat) * glm::vec3(0.1f, 1, 0.1f)), {0, 1, 0}) < 1e-6f);
}

TEST_CASE("after a rigid motion the buffers equal new ones, and nothing was replaced") {
  Scene scene = test_scene();
  SceneBuffers buffers(*test::test_device(), scene);
  const uint64_t generation = buffers.generation();
  const std::vector<Vertex> before = buffers.scene_vertices.download();
  scene.nodes[1].matrix = glm::translate(glm::mat4(1.f), glm::vec3(0, -3, 0)) * *scene.nodes[1].matrix;
  scene.nodes[4].matrix = glm::scale(glm::mat4(1.f), glm::vec3(1, 1, 2));  // emissive, no longer mirrored
  const SceneChange change = evaluate(scene, 1);
  REQUIRE(change.moved_instances == std::vector<int>{1, 4});
  buffers.update(scene, change);
  CHECK(buffers.generation() == generation);
  check_same(buffers, SceneBuffers(*test::test_device(), scene));
  // Instances 0, 2 and 3 kept their bits.
  const std::vector<Vertex> after = buffers.scene_vertices.download();
  size_t first_changed = after.size(), last_changed = 0;
  for (size_t i = 0; i < after.size(); ++i) {
    if (std::memcmp(&before[i], &after[i], sizeof(Vertex)) == 0) continue;
    first_changed = std::min(first_changed, i), last_changed = i;
  }
  CHECK(first_changed == 150);  // instance 1 begins behind the 150 vertices of instance 0
  CHECK(last_changed == after.size() - 1);
  for (size_t i = 300; i < 321; ++i) CHECK(std::memcmp(&before[i], &after[i], sizeof(Vertex)) == 0);
}

TEST_CASE("lights, materials, environment and topology are updated in place") {
  Scene scene = test_scene();
  SceneBuffers buffers(*test::test_device(), scene);
  SceneChange change;
  SUBCASE("lights") {
    scene.lights[0].intensity = glm::vec3(5);
    change.lights = true;
  }
  SUBCASE("lights, of which so many begin to shine, or cease to, that a tree chooses, or the table") {
    scene.environment.reset();
    scene.materials[1].emissive_factor = glm::vec3(0);
    scene.lights.resize(8, scene.lights.at(0));
    const auto kinds = [&] { return buffers.scene_light_trees.download().at(LUCARIUM_LIGHT_TREES_KINDS); };
    const auto shine = [&scene](size_t count) {
      for (size_t i = 0; i < 8; ++i) scene.lights[i].intensity = glm::vec3(i < count ? static_cast<float>(i + 1) : 0.f);
    };
    shine(2);
    buffers = SceneBuffers(*test::test_device(), scene);
    REQUIRE(kinds() == 0);
    change.lights = true;
    shine(8);
    buffers.update(scene, change);
    CHECK(kinds() != 0);
    check_same(buffers, SceneBuffers(*test::test_device(), scene));
    shine(3);
  }
  SUBCASE("materials, one of which begins to emit") {
    scene.materials[0].emissive_factor = glm::vec3(0.5f);
    scene.materials[0].alpha_mode = AlphaMode::mask;
    change.materials = {0};
  }
  SUBCASE("environment") {
    scene.environment->width = 4, scene.environment->height = 2;
    scene.environment->radiance.assign(8, glm::vec3(2));
    change.environment = true;
  }
  SUBCASE("topology") {
    scene.instances.erase(scene.instances.begin() + 1);
    change.topology = true;
  }
  buffers.update(scene, change);
  check_same(buffers, SceneBuffers(*test::test_device(), scene));
}

TEST_CASE("deformed instances have their own object-space vertices") {
  Scene scene = test_scene();
  MorphTarget target;
  target.positions.assign(scene.meshes[0].positions.size(), glm::vec3(0, 10, 0));
  scene.meshes[0].morph_targets = {target};
  scene.nodes[0].morph_weights = {0};
  scene.nodes[1].morph_weights = {1};
  evaluate(scene, 0);
  SceneBuffers buffers(*test::test_device(), scene);
  CHECK(buffers.scene_mesh_vertices.count() == 150 + 150 + 21);
  CHECK(buffers.scene_mesh_triangles.count() == 57);
  scene.nodes[0].morph_weights = {0.5f};
  const SceneChange change = evaluate(scene, 1);
  CHECK(change.deformed_instances == std::vector<int>{0});
  CHECK(change.moved_instances.empty());
  buffers.update(scene, change);
  check_same(buffers, SceneBuffers(*test::test_device(), scene));
  const glm::vec3 expected(scene.instances[0].world_from_object *
                           glm::vec4(scene.meshes[0].positions[0] + glm::vec3(0, 5, 0), 1));
  CHECK(largest_difference(buffers.scene_vertices.download(0, 1)[0].position.xyz(), expected) < 2e-6f);
}

TEST_CASE("textures share images; texels, flags and transforms arrive") {
  Scene scene = test_scene();
  Image image;
  image.width = 2, image.height = 1;
  image.rgba = {1, 2, 3, 4, 5, 6, 7, 8};
  scene.images = {image, image};
  scene.textures = {{1, Wrap::mirror, Wrap::clamp, true, true}, {1, Wrap::repeat, Wrap::repeat, false, false}};
  scene.materials[0].normal_texture = {1, 1, {0.5f, 0}, {2, 3}, 0, 0.7f};
  const SceneBuffers buffers(*test::test_device(), scene);
  CHECK(buffers.scene_texels.download() == std::vector<uint>{0x04030201u, 0x08070605u});  // image 0 is not used
  const std::vector<Texture> textures = buffers.scene_textures.download();
  REQUIRE(textures.size() == 2);
  CHECK(textures[0].first_texel == textures[1].first_texel);
  CHECK(LUCARIUM_TEXTURE_WRAP_U(textures[0].flags) == LUCARIUM_WRAP_MIRROR);
  CHECK(LUCARIUM_TEXTURE_WRAP_V(textures[0].flags) == LUCARIUM_WRAP_CLAMP);
  CHECK((textures[0].flags & LUCARIUM_TEXTURE_NEAREST) != 0);
  CHECK((textures[0].flags & LUCARIUM_TEXTURE_SRGB) != 0);
  CHECK(textures[1].flags == 0);
  const TextureSlot slot = buffers.scene_materials.download()[0].normal_texture;
  CHECK(slot.texture == 1);
  CHECK(slot.uv_set == 1);
  CHECK(slot.scale == 0.7f);
  CHECK(slot.row_u.x == 2);
  CHECK(slot.row_u.z == 0.5f);
  CHECK(slot.row_v.y == 3);
}

TEST_CASE("a scene that does not fit is refused with numbers and the remedy, before anything is allocated") {
  Scene scene = test_scene();
  Image image;
  image.width = 1024, image.height = 1024;
  image.rgba.assign(4 * 1024 * 1024, 0);
  scene.images = {image};
  scene.textures = {{0}};
  DeviceOptions total, single;
  total.memory_limit_bytes = 3 << 20;
  single.allocation_limit_bytes = 2 << 20;
  for (const DeviceOptions& options : {total, single}) {
    const auto small = Device::open(options);
    CHECK_THROWS_WITH_AS(SceneBuffers(*small, scene), doctest::Contains("4.00 MiB"), Error);
    CHECK_THROWS_WITH_AS(SceneBuffers(*small, scene), doctest::Contains("--texture-size"), Error);
    CHECK(small->memory().used_bytes() == 0);
  }
  const SceneBuffers buffers(*test::test_device(), scene);
  CHECK(static_cast<double>(SceneBuffers::estimate_bytes(scene)) ==
        test::relative(static_cast<double>(buffers.bytes()), 0.01));
}

TEST_CASE("scene buffers are bound by the names of a kernel's parameters") {
  const Scene scene = test_scene();
  const SceneBuffers buffers(*test::test_device(), scene);
  SourceLibrary library;
  library.add(test_scene_kernels());
  const Program program(*test::test_device(), library, {"test/probe", {"test_scene/device/scene_probe.cl"}, {}});
  KernelScheduler scheduler(test::test_device());
  ScheduleRecorder recorder = scheduler.record("probe", "test");
  TypedBuffer<uint> result(*test::test_device(), "test", "result", 4);
  PassBuilder pass = recorder.pass("probe", program, "probe").global(1).local(1).arg("result", result);
  buffers.bind(pass);
  Schedule schedule = recorder.compile();
  scheduler.run(schedule);
  scheduler.finish();
  // The lights are the point light, 2 x 7 triangles and, last, the environment.
  CHECK(result.download() == std::vector<uint>{114, 5, 1 + 14 + 1, LUCARIUM_LIGHT_ENVIRONMENT});
}

TEST_CASE("camera rays: perspective and orthographic, whatever scale the node has") {
  SceneCamera camera;
  camera.yfov = glm::radians(90.f);
  camera.world_from_camera = glm::translate(glm::mat4(1.f), glm::vec3(1, 2, 3)) *
                             glm::rotate(glm::mat4(1.f), glm::radians(90.f), glm::vec3(0, 1, 0)) *
                             glm::scale(glm::mat4(1.f), glm::vec3(5));
  // Turned by 90 degrees about Y, -Z becomes -X and +X becomes -Z.
  const Camera c = make_camera(camera, 2.f);
  CHECK(c.origin.xyz() == glm::vec3(1, 2, 3));
  CHECK(largest_difference(c.direction.xyz(), {-1, 0, 0}) < 1e-6f);
  CHECK(largest_difference(c.direction_dx.xyz(), {0, 0, -2}) < 1e-6f);
  CHECK(largest_difference(c.direction_dy.xyz(), {0, 1, 0}) < 1e-6f);
  CHECK(c.origin_dx.xyz() == glm::vec3(0));
  camera.perspective = false;
  camera.ymag = 3;
  const Camera o = make_camera(camera, 2.f);
  CHECK(o.direction_dx.xyz() == glm::vec3(0));
  CHECK(largest_difference(o.origin_dx.xyz(), {0, 0, -6}) < 1e-6f);
  CHECK(largest_difference(o.origin_dy.xyz(), {0, 3, 0}) < 1e-6f);
}
