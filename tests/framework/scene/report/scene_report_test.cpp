// SPDX-License-Identifier: Apache-2.0
#include "lucarium/scene/report/scene_report.h"

#include <doctest/doctest.h>

#include <glm/gtc/constants.hpp>
#include <glm/gtc/matrix_transform.hpp>

#include "lucarium/base/json.h"
#include "lucarium/scene/device/degenerate_triangle.h"
#include "lucarium/scene/load/load_scene.h"
#include "scene_support.h"
#include "tolerance.h"

using namespace lucarium;

namespace {

bool warns(const Scene& scene, const std::string& text) {
  for (const std::string& warning : scene_warnings(scene)) {
    if (warning.find(text) != std::string::npos) return true;
  }
  return false;
}

}  // namespace

TEST_CASE("the report of the Cornell box gives its lamp in physical units") {
  const SceneReport report = make_scene_report(load_scene("builtin:cornell"));
  CHECK(report.emissive_triangles == 2);
  CHECK(report.emissive_area == test::relative(0.130 * 0.105, 1e-5));
  CHECK(report.emissive_flux.r == test::relative(glm::pi<double>() * 0.130 * 0.105 * 17, 1e-5));
  CHECK(report.warnings.empty());
  const nlohmann::json json = nlohmann::json::parse(report.json());
  CHECK(json["triangles"] == 2 * 4 + 8 + 2 + 2 * 12);
  CHECK(json["lights"]["emissive_triangles"]["count"] == 2);
  CHECK(json["lights"]["environment"].is_null());
  CHECK(json["cameras"][0]["name"] == "front");
  CHECK(json["device_memory_bytes"].get<size_t>() > 1000);
  const std::string text = report.text();
  CHECK(text.find("emissive triangles: 0.01365 m2") != std::string::npos);
}

TEST_CASE("the report of the room gives its lamp's flux") {
  const SceneReport report = make_scene_report(load_scene("builtin:room"));
  REQUIRE(report.lamps.size() == 1);
  CHECK(report.lamps[0].flux.g == test::relative(4 * glm::pi<double>()));
  const nlohmann::json json = nlohmann::json::parse(report.json());
  CHECK(json["lights"]["punctual"][0]["intensity_cd"][0] == 1);
}

TEST_CASE("the report of the furnace gives its environment") {
  const SceneReport report = make_scene_report(load_scene("builtin:furnace"));
  CHECK(report.has_environment);
  CHECK(report.environment_radiance.r == test::relative(1));
}

TEST_CASE("warnings name what looks wrong") {
  Scene scene = test::one_node_scene(test::triangle_mesh());
  scene.materials[0].name = "paint";
  CHECK(warns(scene, "no light"));
  CHECK(warns(scene, "base colour 1 (a perfect reflector) in 'paint'"));
  scene.materials[0].base_color = glm::vec4(0.5f, 0.96f, 0.5f, 1);
  CHECK(warns(scene, "base colour above 0.95 in 'paint'"));
  scene.materials[0].base_color = glm::vec4(0.8f);
  CHECK_FALSE(warns(scene, "base colour"));
  scene.materials[0].emissive_factor = glm::vec3(1);
  CHECK_FALSE(warns(scene, "no light"));
  CHECK_FALSE(warns(scene, "emissive factor"));
  scene.materials[0].emissive_factor = glm::vec3(20);
  CHECK(warns(scene, "emissive factor outside 0 to 1 in 'paint'"));
  CHECK_FALSE(warns(scene, "wrong unit"));
  scene.instances[0].world_from_object = glm::scale(glm::mat4(1.f), glm::vec3(20000));
  CHECK(warns(scene, "wrong unit"));
  scene.instances[0].world_from_object = glm::scale(glm::mat4(1.f), glm::vec3(0.005f));
  CHECK(warns(scene, "wrong unit"));
  CHECK_FALSE(warns(scene, "no area"));
  scene.meshes[0].triangles.push_back({0, 0, 1});
  CHECK(warns(scene, "without area, never hit: 1 triangle"));
}

TEST_CASE("triangles of no area are counted where they stand, once for each instance, as rays see them") {
  Scene scene = test::one_node_scene(test::triangle_mesh());
  scene.meshes[0].triangles.push_back({0, 1, 1});
  scene.instances.push_back(scene.instances[0]);
  CHECK(degenerate_triangle_count(scene) == 2);
  scene.instances[1].world_from_object = glm::scale(glm::mat4(1.f), glm::vec3(1, 0, 1));  // flat: both have none
  CHECK(degenerate_triangle_count(scene) == 3);
  const SceneReport report = make_scene_report(scene);
  CHECK(report.degenerate_triangles == 3);
  CHECK(nlohmann::json::parse(report.json())["degenerate_triangles"] == 3);
  CHECK(report.text().find("3 without area") != std::string::npos);
  CHECK(warns(scene, "without area, never hit: 3 triangles"));
  // Thin, but with an area: single-precision products of its edges would underflow.
  CHECK_FALSE(is_degenerate(glm::vec3(0), glm::vec3(1e-30f, 0, 0), glm::vec3(0, 1e-30f, 0)));
  CHECK(is_degenerate(glm::vec3(1), glm::vec3(2), glm::vec3(3)));
}

TEST_CASE("names with control characters and line breaks stay on their line of the report") {
  Scene scene = test::one_node_scene(test::triangle_mesh());
  scene.materials[0].name = "two\nlines\x1b[2J";
  const std::string text = make_scene_report(scene).text();
  CHECK(text.find("two\\u000alines\\u001b[2J: base") != std::string::npos);
  CHECK(text.find('\x1b') == std::string::npos);
}

TEST_CASE("a texture's mean decides about the albedo") {
  Scene scene = test::one_node_scene(test::triangle_mesh());
  Image image;
  image.width = image.height = 2;
  image.rgba.assign(16, 128);
  scene.images = {image};
  scene.textures = {{0, Wrap::repeat, Wrap::repeat, false, true}};
  scene.materials[0].base_color_texture.texture = 0;
  CHECK_FALSE(warns(scene, "base colour"));
  scene.images[0].rgba.assign(16, 255);
  CHECK(warns(scene, "base colour 1"));
}
