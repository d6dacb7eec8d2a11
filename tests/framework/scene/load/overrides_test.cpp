// SPDX-License-Identifier: Apache-2.0
#include <doctest/doctest.h>

#include <fstream>

#include "lucarium/base/error.h"
#include "lucarium/scene/builtin/scenes.h"
#include "lucarium/scene/exposure.h"
#include "lucarium/scene/load/frame_camera.h"
#include "lucarium/scene/load/load_scene.h"
#include "lucarium/scene/load/scene_overrides.h"
#include "scene_support.h"
#include "test_support.h"
#include "tolerance.h"

using namespace lucarium;
using test::largest_difference;

namespace {

glm::vec3 column(const glm::mat4& m, int i) { return glm::vec3(m[i]); }

/// Writes a sidecar and returns what reading it throws ("" if nothing).
std::string sidecar_error(const std::string& text) {
  const test::TemporaryFolder folder;
  const std::filesystem::path file = folder.path() / "x.glb.lucarium.json";
  std::ofstream(file) << text;
  try {
    read_sidecar(file);
  } catch (const Error& error) {
    CHECK(error.error_class() == ErrorClass::input);
    const std::string prefix = file.string();
    const std::string what = error.what();
    REQUIRE(what.starts_with(prefix));
    return what.substr(prefix.size());
  }
  return "";
}

}  // namespace

TEST_CASE("lights in text") {
  const SceneLight point = *parse_light("point:1,2,3:4,5,6");
  CHECK(point.type == LightType::point);
  CHECK(column(point.world_from_light, 3) == glm::vec3(1, 2, 3));
  CHECK(point.intensity == glm::vec3(4, 5, 6));
  const SceneLight sun = *parse_light("directional:0,-2,0:100");
  CHECK(sun.type == LightType::directional);
  CHECK(sun.intensity == glm::vec3(100));
  CHECK(largest_difference(-column(sun.world_from_light, 2), {0, -1, 0}) < 1e-6f);
  const SceneLight spot = *parse_light("spot:0,1,0:1,0,0:7:30:20");
  CHECK(spot.outer_angle == test::relative(glm::radians(30.f)));
  CHECK(spot.inner_angle == test::relative(glm::radians(20.f)));
  CHECK(largest_difference(-column(spot.world_from_light, 2), {1, 0, 0}) < 1e-6f);
  CHECK_FALSE(parse_light("none"));
  for (const char* bad :
       {"", "point", "point:1,2:1", "point:1,2,3:-1", "point:1,2,3:nan", "point:1,2,3:1,2", "lamp:1,2,3:1",
        "directional:0,0,0:1", "spot:0,0,0:1,0,0:1:20:30", "spot:0,0,0:1,0,0:1:120", "point:1,2,3:1:2"}) {
    CAPTURE(bad);
    CHECK_THROWS_WITH_AS(parse_light(bad), doctest::Contains("expected point:"), Error);
  }
}

TEST_CASE("cameras in text") {
  const SceneCamera camera = *parse_look_at("0,0,5:0,0,0:50");
  CHECK(column(camera.world_from_camera, 3) == glm::vec3(0, 0, 5));
  CHECK(camera.yfov == test::relative(glm::radians(50.f)));
  // Straight down there is no "up"; the frame is still orthonormal and right-handed.
  const glm::mat4 down = parse_look_at("0,5,0:0,0,0")->world_from_camera;
  CHECK(glm::determinant(glm::mat3(down)) == test::relative(1));
  CHECK(largest_difference(-column(down, 2), {0, -1, 0}) < 1e-6f);
  CHECK_FALSE(parse_look_at("Camera"));
  CHECK_FALSE(parse_look_at("a:b"));
  CHECK_THROWS_AS(parse_look_at("0,0,0:0,0,0"), Error);
  CHECK_THROWS_AS(parse_look_at("0,0,1:0,0,0:180"), Error);
}

TEST_CASE("environments in text") {
  const EnvironmentChoice constant = parse_environment("1,0.5,0*2@90");
  CHECK(constant.file.empty());
  CHECK(constant.radiance == glm::vec3(1, 0.5f, 0));
  CHECK(constant.factor == 2);
  CHECK(constant.rotation_degrees == 90);
  const EnvironmentChoice file = parse_environment("a@b/sky*x.hdr*0.5");
  CHECK(file.file == "a@b/sky*x.hdr");
  CHECK(file.factor == 0.5f);
  CHECK(parse_environment("none").none);
  CHECK_THROWS_AS(parse_environment(""), Error);
  CHECK_THROWS_AS(parse_environment("1*-2"), Error);
}

TEST_CASE("material tweaks in text") {
  const MaterialEdit edit = parse_material("a:b:base_color=0.1,0.2,0.3,roughness=0.5");
  CHECK(edit.pattern == "a:b");
  REQUIRE(edit.values.size() == 2);
  CHECK(edit.values[0] == std::pair<std::string, std::string>("base_color", "0.1,0.2,0.3"));
  CHECK_THROWS_WITH_AS(parse_material("a:rouhgness=1"), doctest::Contains("did you mean 'roughness'?"), Error);
  CHECK_THROWS_WITH_AS(parse_material("a:roughness=2"), doctest::Contains("a number from 0 to 1"), Error);
  CHECK_THROWS_AS(parse_material("roughness=1"), Error);
  CHECK_THROWS_AS(parse_material("a:"), Error);
  CHECK_THROWS_AS(parse_material("a:b,roughness=1"), Error);
  CHECK(matches_pattern("red wall", "*wall"));
  CHECK(matches_pattern("red wall", "r*d*l"));
  CHECK(matches_pattern("", "*"));
  CHECK_FALSE(matches_pattern("red wall", "wall"));
  CHECK_FALSE(matches_pattern("red", "red*x"));
}

TEST_CASE("overrides change a built-in scene") {
  SceneOverrides overrides;
  overrides.lights = {"point:0,1,0:1", "none", "point:0,0.5,0:3"};
  overrides.camera = "0,0.2,1:0,0.2,0";
  overrides.environment = "0.5@90";
  overrides.materials = {"*:roughness=0.25", "red:base_color=0.5"};
  overrides.exposure = 2.f;
  const Scene scene = load_scene("builtin:cornell", overrides);
  REQUIRE(scene.lights.size() == 1);
  CHECK(scene.lights[0].intensity == glm::vec3(3));
  REQUIRE(scene.cameras.size() == 2);
  CHECK(scene.cameras[0].name == "look-at");
  CHECK(scene.environment->factor == glm::vec3(0.5f));
  CHECK(scene.exposure == 2.f);
  for (const SceneMaterial& material : scene.materials) {
    CHECK(material.roughness == 0.25f);
    if (material.name == "red") CHECK(material.base_color == glm::vec4(0.5f, 0.5f, 0.5f, 1));
  }
}

TEST_CASE("an environment turned by 90 degrees shows what lay along +X at -Z") {
  SceneOverrides overrides;
  overrides.environment = "1@90";
  const Scene scene = load_scene("builtin:cornell", overrides);
  // A counter-clockwise turn about +Y seen from above takes +X to -Z.
  CHECK(largest_difference(scene.environment->environment_from_world * glm::vec3(0, 0, -1), {1, 0, 0}) < 1e-6f);
}

TEST_CASE("names that do not exist are usage errors with the nearest name") {
  const auto message = [](SceneOverrides overrides) -> std::string {
    try {
      load_scene("builtin:cornell", overrides);
    } catch (const Error& error) {
      CHECK(error.error_class() == ErrorClass::usage);
      return error.what();
    }
    return "";
  };
  CHECK(message({.camera = "fron"}).find("did you mean 'front'") != std::string::npos);
  CHECK(message({.camera = "7"}) != "");
  CHECK(message({.animation = "walk"}) != "");
  CHECK(message({.materials = {"gren:roughness=1"}}).find("did you mean 'green'") != std::string::npos);
  CHECK_THROWS_WITH_AS(load_scene("no/such/file.glb"), doctest::Contains("no such file"), Error);
}

TEST_CASE("a scene without light names the options") {
  SceneOverrides overrides;
  overrides.lights = {"none"};
  const Scene scene = load_scene("builtin:room", overrides);
  CHECK_FALSE(scene.has_light());
  CHECK_THROWS_WITH_AS(require_light(scene), doctest::Contains("--environment"), Error);
  CHECK_THROWS_WITH_AS(require_light(scene), doctest::Contains("--light"), Error);
}

TEST_CASE("a material whose emissive texture is black is no light") {
  Scene scene = make_builtin_scene("room");
  scene.lights.clear();
  Image image;
  image.width = image.height = 2;
  image.rgba.assign(16, 0);
  for (size_t alpha = 3; alpha < 16; alpha += 4) image.rgba[alpha] = 255;
  scene.images = {image};
  scene.textures = {{0, Wrap::repeat, Wrap::repeat, false, true}};
  scene.materials[0].emissive_factor = glm::vec3(1);
  scene.materials[0].emissive_texture.texture = 0;
  CHECK_FALSE(scene.has_light());
  scene.images[0].rgba[5] = 1;
  CHECK(scene.has_light());
}

TEST_CASE("the sidecar says the same as the command line") {
  const test::TemporaryFolder folder;
  const std::filesystem::path file = folder.path() / "x.glb.lucarium.json";
  std::ofstream(file) << R"({
    // comments are allowed
    "camera": {"eye": [0, 1, 2], "target": [0, 0.5, 0], "vfov_degrees": 35},
    "environment": {"file": "sky.hdr", "factor": 2, "rotation_degrees": -30},
    "lights": ["none", {"type": "spot", "position": [0, 2, 0], "direction": [0, -1, 0], 
                         "intensity": [9, 8, 7], "inner_degrees": 10}],
    "exposure": -1.5, "at_seconds": 0.25, "animation": 1,
    "materials": {"glass*": {"ior": 1.33, "double_sided": true, "base_color": [0.5, 0.5, 0.25]}}
  })";
  const SceneOverrides o = read_sidecar(file);
  CHECK(*o.camera == "0,1,2:0,0.5,0:35");
  CHECK(*o.environment == (folder.path() / "sky.hdr").string() + "*2@-30");
  CHECK(o.lights == std::vector<std::string>{"none", "spot:0,2,0:0,-1,0:9,8,7:45:10"});
  CHECK(*o.exposure == -1.5f);
  CHECK(*o.at_seconds == 0.25);
  CHECK(*o.animation == "1");
  CHECK(o.materials == std::vector<std::string>{"glass*:base_color=0.5,0.5,0.25,double_sided=true,ior=1.33"});

  SceneOverrides command_line;
  command_line.exposure = 3.f;
  command_line.lights = {"point:0,0,0:1"};
  const SceneOverrides merged = merge_overrides(o, command_line);
  CHECK(*merged.exposure == 3.f);
  CHECK(*merged.camera == *o.camera);
  CHECK(merged.lights.size() == 3);
}

TEST_CASE("an exposure is a finite number of stops, or auto, which is what holds where none is stated") {
  CHECK(parse_exposure("-1.5") == -1.5f);
  CHECK(parse_exposure("+2") == 2);
  CHECK(is_automatic(parse_exposure("auto")));
  CHECK(exposure_text(exposure_automatic) == "auto");
  CHECK(exposure_text(-1.5f) == "-1.5");
  for (const char* wrong : {"nan", "inf", "-inf", "", "1e99", "bright", "1 2"}) {
    CAPTURE(wrong);
    CHECK_THROWS_WITH_AS(parse_exposure(wrong), doctest::Contains("a finite number of stops, or auto"), Error);
  }
  CHECK(is_automatic(load_scene("builtin:cornell").exposure));
  CHECK(load_scene("builtin:cornell", {.exposure = 0.f}).exposure == 0);
  const test::TemporaryFolder folder;
  const std::filesystem::path file = folder.path() / "x.lucarium.json";
  std::ofstream(file) << R"({"exposure": "auto"})";
  CHECK(is_automatic(*read_sidecar(file).exposure));
}

TEST_CASE("text that looks like a camera's place is not taken for a name") {
  const auto message = [](const char* camera) {
    try {
      load_scene("builtin:cornell", {.camera = camera});
    } catch (const Error& error) {
      CHECK(error.error_class() == ErrorClass::usage);
      return std::string(error.what());
    }
    return std::string();
  };
  for (const char* wrong : {"nan,0,0:0,0,0", "0,0:1,1", "0,0,1:0,0,inf", "0,0,1:0,0,0:40:2"}) {
    CAPTURE(wrong);
    CHECK(message(wrong).find("it is not EYE:TARGET or EYE:TARGET:VFOV") != std::string::npos);
  }
  CHECK(message("0,0,1:0,0,0:x").find("the vertical field of view must be between") != std::string::npos);
}

TEST_CASE("sidecar errors name file, line and key") {
  CHECK(sidecar_error("{\"exposure\": 1}").empty());
  CHECK(sidecar_error("{\n \"exposure\": 1,\n \"expsure\": 2\n}")
            .starts_with(":3: expsure: unknown key; did you mean 'exposure'?"));
  CHECK(sidecar_error("{\n \"exposure\":\n \"much\"}")
            .starts_with(":2: exposure: must be a number of stops or \"auto\""));
  CHECK(sidecar_error("{\"lights\": [\n \"none\",\n {\"type\": \"lamp\"}]}").starts_with(":3: lights/1/type: must be"));
  CHECK(
      sidecar_error("{\"lights\": [\n\n {\"type\": \"point\",\n\"intensity\": 1}]}").find("\"position\" is missing") !=
      std::string::npos);
  CHECK(sidecar_error("{\"materials\": {\"a\": {\n\"roughness\": 3}}}")
            .starts_with(":2: materials/a/roughness: material value"));
  CHECK(sidecar_error("{\n\n \"camera\": }").starts_with(":3: this is not valid JSON"));
  CHECK(sidecar_error("\n" + std::string(1000000, '[')) == ":2: it is nested too deeply");
  CHECK(sidecar_error("[1]").starts_with(":1: the file: must be an object"));
  CHECK(sidecar_error("").starts_with(":1: this is not valid JSON"));
  CHECK(sidecar_error("{\"environment\": {\"factor\": 1}}").find("either \"file\" or \"radiance\"") !=
        std::string::npos);
}

TEST_CASE("a framed camera sees the whole box and little more") {
  Bounds bounds;
  bounds.add({-1, 0, 2}), bounds.add({5, 3, 4});
  for (const float aspect : {0.5f, 1.f, 2.f}) {
    const SceneCamera camera = frame_camera(bounds, aspect);
    const glm::mat4 view = glm::inverse(camera.world_from_camera);
    const float tan_y = std::tan(0.5f * camera.yfov);
    float reach = 0;
    for (int i = 0; i < 8; ++i) {
      const glm::vec3 corner(i & 1 ? 5 : -1, i & 2 ? 3 : 0, i & 4 ? 4 : 2);
      const glm::vec3 p(view * glm::vec4(corner, 1));
      REQUIRE(p.z < 0);
      reach = std::max({reach, std::abs(p.x / p.z) / (tan_y * aspect), std::abs(p.y / p.z) / tan_y});
    }
    CHECK(reach <= 1);
    CHECK(reach > 0.8f);
  }
}

TEST_CASE("the hash follows what changes radiance, and nothing else") {
  const Scene scene = make_builtin_scene("room");
  const auto changed = [&](auto&& edit) {
    Scene copy = scene;
    edit(copy);
    return !(copy.hash() == scene.hash());
  };
  CHECK_FALSE(changed([](Scene&) {}));
  CHECK_FALSE(changed([](Scene& s) { s.cameras[0].yfov = 1; }));
  CHECK_FALSE(changed([](Scene& s) { s.exposure = 1; }));
  CHECK_FALSE(changed([](Scene& s) { s.source = "elsewhere"; }));
  CHECK(changed([](Scene& s) { s.materials[0].roughness = 0.99f; }));
  CHECK(changed([](Scene& s) { s.meshes[0].positions[0].x += 1e-6f; }));
  CHECK(changed([](Scene& s) { s.instances[2].world_from_object[3].y = 1e-3f; }));
  CHECK(changed([](Scene& s) { s.lights[0].intensity.r = 2; }));
  CHECK(changed([](Scene& s) { s.environment = Environment{}; }));
  CHECK(changed([](Scene& s) { s.instances.pop_back(); }));
  CHECK(changed([](Scene& s) { s.materials[0].emissive_texture.texture = 0; }));
}
