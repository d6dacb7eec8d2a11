// SPDX-License-Identifier: Apache-2.0
// What export_gltf writes is what load_scene reads: everything that changes an image comes back.
#include "lucarium/scene/gltf/export.h"

#include <doctest/doctest.h>

#include "gltf_builder.h"
#include "lucarium/base/files/atomic_file.h"
#include "lucarium/scene/exposure.h"
#include "lucarium/scene/load/frame_camera.h"
#include "lucarium/scene/load/load_scene.h"
#include "scene_support.h"
#include "test_support.h"

using namespace lucarium;
using namespace lucarium::test;

namespace {

constexpr float one_bit = 3e-7f;  // of values that are kept as a product of two floats

Scene exported_and_read(const Scene& scene) {
  const TemporaryFolder folder;
  export_gltf(scene, folder.path() / "a.glb");
  for (const auto& file : exported_files(scene, folder.path() / "a.glb")) CHECK(std::filesystem::is_regular_file(file));
  const Scene result = load_scene((folder.path() / "a.glb").string());
  CHECK(result.warnings == std::vector<std::string>{});
  return result;
}

void check_same_color(const glm::vec3& a, const glm::vec3& b) {
  for (int c = 0; c < 3; ++c) CHECK(std::abs(a[c] - b[c]) <= one_bit * std::abs(b[c]));
}

void check_same_use(const TextureUse& a, const TextureUse& b) {
  REQUIRE((a.texture == none) == (b.texture == none));
  if (a.texture == none) return;
  CHECK(a.uv_set == b.uv_set);
  CHECK(a.offset == b.offset);
  CHECK(a.scale == b.scale);
  CHECK(a.rotation == b.rotation);
  CHECK(a.strength == b.strength);
}

void check_same_material(const SceneMaterial& a, const SceneMaterial& b) {
  CAPTURE(a.name);
  CHECK(a.name == b.name);
  CHECK(a.base_color == b.base_color);
  CHECK(a.metallic == b.metallic);
  CHECK(a.roughness == b.roughness);
  check_same_color(a.emissive_factor * a.emissive_strength, b.emissive_factor * b.emissive_strength);
  CHECK(a.ior == b.ior);
  CHECK(a.transmission == b.transmission);
  CHECK(a.thickness == b.thickness);
  CHECK(a.attenuation_distance == b.attenuation_distance);
  CHECK(a.attenuation_color == b.attenuation_color);
  CHECK(a.alpha_mode == b.alpha_mode);
  CHECK(a.alpha_cutoff == b.alpha_cutoff);
  CHECK(a.double_sided == b.double_sided);
  CHECK(a.unlit == b.unlit);
  check_same_use(a.base_color_texture, b.base_color_texture);
  check_same_use(a.metallic_roughness_texture, b.metallic_roughness_texture);
  check_same_use(a.normal_texture, b.normal_texture);
  check_same_use(a.emissive_texture, b.emissive_texture);
  check_same_use(a.transmission_texture, b.transmission_texture);
}

void check_same_instance(const Scene& a, const SceneInstance& i, const Scene& b, const SceneInstance& k) {
  const Mesh &m = i.shape(a), &n = k.shape(b);
  CHECK(m.positions == n.positions);
  CHECK(m.triangles == n.triangles);
  CHECK(m.uv[0] == n.uv[0]);
  CHECK(m.uv[1] == n.uv[1]);
  CHECK(m.colors == n.colors);
  REQUIRE(m.normals.size() == n.normals.size());
  float difference = 0;
  for (size_t v = 0; v < m.normals.size(); ++v)
    difference = std::max(difference, largest_difference(m.normals[v], n.normals[v]));
  CHECK(difference <= one_bit);
  CHECK(i.world_from_object == k.world_from_object);
  CHECK(i.material == k.material);
}

void check_same_lights(const Scene& a, const Scene& b) {
  REQUIRE(a.lights.size() == b.lights.size());
  for (size_t i = 0; i < a.lights.size(); ++i) {
    CHECK(a.lights[i].type == b.lights[i].type);
    check_same_color(a.lights[i].intensity, b.lights[i].intensity);
    CHECK(a.lights[i].world_from_light == b.lights[i].world_from_light);
    if (a.lights[i].type != LightType::spot) continue;
    CHECK(a.lights[i].inner_angle == b.lights[i].inner_angle);
    CHECK(a.lights[i].outer_angle == b.lights[i].outer_angle);
  }
}

void check_same_scene(const Scene& a, const Scene& b) {
  REQUIRE(a.materials.size() == b.materials.size());
  for (size_t i = 0; i < a.materials.size(); ++i) check_same_material(a.materials[i], b.materials[i]);
  REQUIRE(a.instances.size() == b.instances.size());
  for (size_t i = 0; i < a.instances.size(); ++i) check_same_instance(a, a.instances[i], b, b.instances[i]);
  check_same_lights(a, b);
  REQUIRE(a.cameras.size() == b.cameras.size());
  for (size_t i = 0; i < a.cameras.size(); ++i) {
    CHECK(a.cameras[i].perspective == b.cameras[i].perspective);
    CHECK(a.cameras[i].world_from_camera == b.cameras[i].world_from_camera);
    if (a.cameras[i].perspective) CHECK(a.cameras[i].yfov == b.cameras[i].yfov);
  }
  CHECK(exposure_text(a.exposure) == exposure_text(b.exposure));  // NaN stands for auto
  CHECK(a.environment.has_value() == b.environment.has_value());
}

}  // namespace

TEST_CASE("built-in scenes come back") {
  for (const std::string name : {"cornell", "cornell-mirror", "furnace", "room"}) {
    CAPTURE(name);
    const Scene scene = load_scene("builtin:" + name);
    check_same_scene(scene, exported_and_read(scene));
  }
}

TEST_CASE("every property of a material, punctual lights and cameras come back") {
  Scene scene = load_scene("builtin:room", {.camera = "1,2,3:0,0,0:35",
                                            .lights = {"none", "point:1,2,3:40,3,0.5", "directional:1,-2,3:0.25,0.5,1",
                                                       "spot:0,2,0:0.1,-1,0.2:7,8,9:30:20"},
                                            .exposure = -1.5f});
  SceneMaterial& m = scene.materials[0];
  m.base_color = {0.1f, 0.2f, 0.3f, 0.4f};
  m.metallic = 0.7f, m.roughness = 0.35f, m.ior = 1.33f, m.transmission = 0.8f, m.thickness = 0.5f;
  m.attenuation_distance = 2.5f, m.attenuation_color = {0.9f, 0.8f, 0.7f};
  m.emissive_factor = {0.3f, 17, 5}, m.emissive_strength = 3;
  m.alpha_mode = AlphaMode::mask, m.alpha_cutoff = 0.25f, m.double_sided = true;
  scene.materials.back().unlit = true, scene.materials.back().alpha_mode = AlphaMode::blend;
  SceneCamera orthographic;
  orthographic.name = "plan", orthographic.perspective = false, orthographic.xmag = 3, orthographic.ymag = 2;
  scene.cameras.push_back(orthographic);
  const Scene result = exported_and_read(scene);
  check_same_scene(scene, result);
  CHECK(result.cameras.back().xmag == 3);
  CHECK(result.cameras.back().ymag == 2);
}

TEST_CASE("textures come back: pixels under alpha 0, samplers, uses") {
  Scene scene = one_node_scene(triangle_mesh());
  scene.meshes[0].uv[0] = scene.meshes[0].uv[1] = {{0, 0}, {1, 0}, {0, 1}};
  scene.meshes[0].colors = {{1, 0.5f, 0.25f, 1}, {0, 1, 0, 0.5f}, {0, 0, 1, 0}};
  scene.images = {{"four", 2, 2, {255, 0, 0, 0, 1, 2, 3, 4, 9, 8, 7, 255, 100, 50, 25, 128}}};
  scene.textures = {{0, Wrap::clamp, Wrap::mirror, true, true}, {0, Wrap::repeat, Wrap::repeat, false, false}};
  SceneMaterial& m = scene.materials[0];
  m.name = "textured", m.emissive_factor = glm::vec3(1);
  m.base_color_texture = m.emissive_texture = {0, 1, {0.5f, -0.25f}, {2, 3}, 0.7f};
  m.metallic_roughness_texture = {1};
  scene.cameras.push_back(frame_camera(scene.bounds(), 1));
  const Scene result = exported_and_read(scene);
  check_same_scene(scene, result);
  REQUIRE(result.images.size() == 1);
  CHECK(result.images[0].rgba == scene.images[0].rgba);
  const SceneTexture& texture = result.textures[result.materials[0].base_color_texture.texture];
  CHECK(texture.wrap_u == Wrap::clamp);
  CHECK(texture.wrap_v == Wrap::mirror);
  CHECK(texture.nearest);
  CHECK(texture.srgb);
  CHECK(!result.textures[result.materials[0].metallic_roughness_texture.texture].srgb);
}

TEST_CASE("environments come back, turned and scaled") {
  Scene scene = load_scene("builtin:furnace");
  scene.environment = Environment{"sky", 2, 1, {{1, 2, 3}, {4, 5, 600}}, glm::vec3(0.5f), glm::mat3(1)};
  const float angle = glm::radians(70.f);
  scene.environment->environment_from_world =
      glm::mat3(std::cos(angle), 0, std::sin(angle), 0, 1, 0, -std::sin(angle), 0, std::cos(angle));
  const Environment environment = exported_and_read(scene).environment.value();
  REQUIRE(environment.width == 2);
  for (size_t i = 0; i < 2; ++i) {
    check_same_color(environment.radiance[i] * environment.factor, scene.environment->radiance[i] * 0.5f);
  }
  for (int c = 0; c < 3; ++c) {
    CHECK(largest_difference(environment.environment_from_world[c], scene.environment->environment_from_world[c]) <
          1e-6f);
  }
}

TEST_CASE("a pose is exported as it stands; mirrored triangles are turned to face the same way") {
  Scene scene = one_node_scene(triangle_mesh());
  scene.materials[0].emissive_factor = glm::vec3(1);
  Mesh pose = triangle_mesh();
  pose.positions[1].x = 5;
  scene.instances[0].pose = std::make_shared<const Mesh>(pose);
  scene.instances[0].mirrored = true;
  scene.cameras.push_back(frame_camera(scene.bounds(), 1));
  const Scene result = exported_and_read(scene);
  CHECK(result.meshes[0].positions == pose.positions);
  CHECK(result.meshes[0].triangles == std::vector<glm::uvec3>{{0, 2, 1}});
}
