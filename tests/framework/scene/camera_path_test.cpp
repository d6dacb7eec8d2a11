// SPDX-License-Identifier: Apache-2.0
#include "lucarium/scene/camera_path.h"

#include <doctest/doctest.h>

#include <cmath>

#include "lucarium/base/error.h"
#include "lucarium/scene/load/camera_path_text.h"
#include "lucarium/scene/load/load_scene.h"
#include "lucarium/scene/load/scene_overrides.h"
#include "scene_support.h"
#include "test_support.h"
#include "tolerance.h"

using namespace lucarium;

namespace {

using Between = CameraPath::Interpolation;

CameraPath path_of(Between interpolation, const std::vector<CameraKey>& keys) {
  return {.name = "", .interpolation = interpolation, .keys = keys};
}

void check_point(const glm::vec3& value, const glm::dvec3& expected) {
  for (int i = 0; i < 3; ++i) CHECK(value[i] == test::within(expected[i], 2e-6));
}

}  // namespace

TEST_CASE("a linear path: eye and target move evenly between keys, and stand still before and after them") {
  const CameraPath path = path_of(
      Between::linear, {{1, {0, 0, 0}, {0, 0, -1}, 40}, {3, {4, 2, 0}, {4, 2, -3}, 60}, {4, {4, 2, 1}, {0, 0, 0}}});
  check_point(sample_camera_path(path, 1.5).eye, {1, 0.5, 0});
  check_point(sample_camera_path(path, 1.5).target, {1, 0.5, -1.5});
  CHECK(sample_camera_path(path, 1.5).vfov_degrees == test::relative(45.0, 1e-6));
  CHECK(sample_camera_path(path, -7).eye == path.keys.front().eye);
  CHECK(sample_camera_path(path, 1e9).target == path.keys.back().target);
}

TEST_CASE("keys are met to the bit, by both interpolations") {
  for (const Between interpolation : {Between::linear, Between::spline}) {
    const CameraPath path = path_of(interpolation, {{0.1, {0.1f, 0.7f, 3}, {0, 0.3f, 0}, 33.3f},
                                                    {0.7, {1.1f, 0.2f, 2}, {0, 0.1f, 0}, 51.7f},
                                                    {2.3, {0.3f, 0.9f, 1}, {0.2f, 0, 0}, 47.1f}});
    for (const CameraKey& key : path.keys) {
      const CameraKey at = sample_camera_path(path, key.seconds);
      CHECK(at.eye == key.eye);
      CHECK(at.target == key.target);
      CHECK(at.vfov_degrees == key.vfov_degrees);
    }
  }
}

// Hermite pieces with the slopes of parabolas through three neighbours meet every path of degree two exactly:
// eye(t) = (t², 1 - t + t²/2, 3t), whatever the times of the keys are.
TEST_CASE("a spline meets a path of degree two, by keys at uneven times") {
  const auto eye = [](double t) { return glm::dvec3(t * t, 1 - t + 0.5 * t * t, 3 * t); };
  const auto target = [](double t) { return glm::dvec3(-t, 0.25 * t * t, -4); };
  CameraPath path = path_of(Between::spline, {});
  for (const double t : {0.0, 0.25, 1.0, 1.125, 2.5})
    path.keys.push_back({t, glm::vec3(eye(t)), glm::vec3(target(t)), 40});
  for (int i = 0; i <= 50; ++i) {
    const double t = 0.05 * i;
    CAPTURE(t);
    check_point(sample_camera_path(path, t).eye, eye(t));
    check_point(sample_camera_path(path, t).target, target(t));
  }
}

TEST_CASE("a spline through two keys is a straight line, and has no kink at an inner one") {
  const CameraPath straight = path_of(Between::spline, {{0, {0, 0, 0}, {0, 0, -1}}, {2, {2, 4, 6}, {0, 0, -2}}});
  check_point(sample_camera_path(straight, 0.5).eye, {0.5, 1, 1.5});
  const CameraPath bent = path_of(Between::spline, {{0, {0, 0, 0}, {0, 0, -9}, 40},
                                                    {1, {1, 2, 0}, {0, 0, -9}, 70},
                                                    {1.5, {3, 0, 0}, {0, 0, -9}, 70},
                                                    {3, {0, 0, 1}, {0, 0, -9}, 20}});
  constexpr double h = 1e-4;
  for (const double t : {1.0, 1.5}) {
    const auto eye = [&](double at) { return glm::dvec3(sample_camera_path(bent, at).eye); };
    const glm::dvec3 before = (eye(t) - eye(t - h)) / h, after = (eye(t + h) - eye(t)) / h;
    CHECK(glm::length(after - before) < 0.02 * glm::length(after));
  }
  // Fields of view do not overshoot.
  for (int i = 0; i <= 300; ++i) {
    const float vfov = sample_camera_path(bent, 0.01 * i).vfov_degrees;
    CHECK(vfov >= 20);
    CHECK(vfov <= 70);
  }
}

TEST_CASE("the camera on a path is the one that its text states, to the bit") {
  const CameraPath path = path_of(Between::spline, {{0, {0, 1, 5}, {0, 1, 0}, 40},
                                                    {1, {1.3f, 1.2f, 4}, {0.1f, 1, 0}, 55},
                                                    {2.7, {2, 1.9f, 1}, {0, 0.5f, -0.3f}, 50}});
  for (int i = 0; i <= 27; ++i) {
    const double t = 0.1 * i;
    const SceneCamera camera = camera_on_path(path, t);
    const SceneCamera stated = *parse_look_at(camera_text(sample_camera_path(path, t)));
    CHECK(camera.world_from_camera == stated.world_from_camera);
    CHECK(camera.yfov == stated.yfov);
  }
}

TEST_CASE("where eye and target meet between keys there is nothing to look at") {
  const CameraPath path = path_of(Between::linear, {{0, {0, 0, 1}, {0, 0, -1}}, {1, {0, 0, -1}, {0, 0, 1}}});
  CHECK(camera_on_path(path, 0.25).perspective);
  CHECK_THROWS_WITH_AS(camera_on_path(path, 0.5), doctest::Contains("eye and target meet at 0.5 s"), Error);
}

TEST_CASE("a path in text and back") {
  const std::string text = "spline:0@0,1,5:0,1,0:40;2.5@1,1.5,4:0,0.1,0:55.5;7@1,1,-3:0,1,0:40";
  const std::optional<CameraPath> path = parse_camera_path(text);
  REQUIRE(path);
  CHECK(path->interpolation == Between::spline);
  REQUIRE(path->keys.size() == 3);
  CHECK(path->keys[1].seconds == 2.5);
  CHECK(path->keys[1].eye == glm::vec3(1, 1.5f, 4));
  CHECK(path->keys[1].vfov_degrees == 55.5f);
  CHECK(camera_path_text(*path) == text);
  CHECK(parse_camera_path("linear:-1@0,1,5:0,1,0;1e0@0,1,4:0,1,0")->keys[1].vfov_degrees == 40);
  CHECK_FALSE(parse_camera_path("walk"));
  CHECK_FALSE(parse_camera_path("folder/path.json"));
}

TEST_CASE("a path in text that is wrong says which key") {
  const auto mistake = [](const std::string& text) {
    try {
      parse_camera_path(text);
    } catch (const Error& error) {
      CHECK(error.error_class() == ErrorClass::usage);
      return std::string(error.what());
    }
    return std::string();
  };
  const std::string first = "linear:0@0,1,5:0,1,0;";
  CHECK(mistake("linear:") == "camera path: '' is not SECONDS@EX,EY,EZ:TX,TY,TZ[:VFOV] with finite numbers");
  CHECK(mistake("linear:0@0,1,5:0,1,0") == "camera path: a path has at least two keys, this one has one");
  CHECK(mistake(first + "0@0,1,4:0,1,0") == "camera path: key 1 is at 0 s, the one before at 0 s; times must ascend");
  CHECK(mistake(first + "2@0,1,4:0,1,0;1@0,1,3:0,1,0") ==
        "camera path: key 2 is at 1 s, the one before at 2 s; times must ascend");
  CHECK(mistake(first + "1@0,1,4:0,1,4") == "camera path: key 1: eye and target are the same point");
  CHECK(mistake(first + "1@0,1,4:0,1,0:180").find("key 1: the vertical field of view") != std::string::npos);
  for (const char* key : {"nan@0,1,4:0,1,0", "inf@0,1,4:0,1,0", "1@nan,1,4:0,1,0", "1@0,1,4:0,inf,0",
                          "1@0,1,4:0,1,0:nan", "1:0,1,4:0,1,0", "1@0,1:0,1,0", "1@0,1,4", "@0,1,4:0,1,0", "1@a"}) {
    CAPTURE(key);
    CHECK(mistake(first + key).find(fmt::format("'{}' is not SECONDS@", key)) != std::string::npos);
  }
}

TEST_CASE("a scene with a camera path: its first camera is the path's at every time, and nothing else changes") {
  SceneOverrides overrides;
  overrides.camera_path = "linear:0@0,0.2,1:0,0.2,0:40;2@0.1,0.2,1:0,0.2,0:50";
  overrides.at_seconds = 1;
  Scene scene = load_scene("builtin:cornell", overrides);
  const Hash128 hash = scene.hash();
  CHECK(scene.warnings.empty());
  REQUIRE(scene.cameras.size() == 2);
  CHECK(scene.cameras.front().yfov == test::relative(glm::radians(45.f)));
  const SceneChange change = evaluate(scene, 2);
  CHECK(change.only_camera());
  CHECK(glm::vec3(scene.cameras.front().world_from_camera[3]) == glm::vec3(0.1f, 0.2f, 1));
  CHECK_FALSE(evaluate(scene, 3).any());  // it stands still
  CHECK(scene.hash() == hash);
  CHECK(scene.cameras[1].name == "front");
}

TEST_CASE("built-in scenes bring paths by name") {
  for (const char* name : {"cornell", "cornell-mirror", "mirror-hall", "blocks"}) {
    SceneOverrides overrides;
    overrides.camera_path = "walk";
    Scene scene = load_scene(std::string("builtin:") + name, overrides);
    REQUIRE(scene.camera_path);
    CHECK(camera_path_mistake(*scene.camera_path).empty());
    const Bounds bounds = scene.bounds();
    for (int i = 0; i <= 80; ++i) {
      evaluate(scene, 0.1 * i);
      const glm::vec3 eye(scene.cameras.front().world_from_camera[3]);
      CHECK(eye.x > bounds.min.x);
      CHECK(eye.x < bounds.max.x);
      CHECK(eye.y < bounds.max.y);
    }
  }
}
