// SPDX-License-Identifier: Apache-2.0
// builtin:solids and builtin:debris: every body is closed at every time, and has the volume that it should have.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <glm/gtc/constants.hpp>

#include "lucarium/base/error.h"
#include "lucarium/scene/builtin/builder.h"
#include "lucarium/scene/builtin/scenes.h"
#include "lucarium/scene/load/load_scene.h"
#include "lucarium/scene/mesh_components.h"
#include "tolerance.h"

using namespace lucarium;

namespace {

/// The components of one instance in world space.
MeshComponents components_of(const Scene& scene, const SceneInstance& instance) {
  const Mesh& mesh = instance.shape(scene);
  std::vector<glm::vec3> positions;
  for (const glm::vec3& p : mesh.positions) positions.emplace_back(instance.world_from_object * glm::vec4(p, 1));
  return mesh_components(positions, mesh.triangles);
}

const SceneInstance& instance_of(const Scene& scene, const std::string& name) {
  const auto found = std::find_if(scene.instances.begin(), scene.instances.end(),
                                  [&](const SceneInstance& i) { return scene.meshes[i.mesh].name == name; });
  REQUIRE_MESSAGE(found != scene.instances.end(), name);
  return *found;
}

/// Of an instance that is one closed body.
double solid_volume(const Scene& scene, const std::string& name) {
  CAPTURE(name);
  const MeshComponents found = components_of(scene, instance_of(scene, name));
  REQUIRE(found.components.size() == 1);
  CHECK(found.components[0].closed);
  return found.components[0].volume;
}

double sphere_volume(double radius) { return 4. / 3 * glm::pi<double>() * radius * radius * radius; }

/// Volume of a body that is star-shaped around its origin, from the radii of its corners alone: ∫ r³/3 dΩ.
double star_volume(const Mesh& mesh) {
  double volume = 0;
  for (const glm::uvec3& t : mesh.triangles) {
    glm::dvec3 d[3];
    double cubes = 0;
    for (int i = 0; i < 3; ++i) {
      const glm::dvec3 p(mesh.positions[t[i]]);
      d[i] = glm::normalize(p);
      cubes += std::pow(glm::length(p), 3) / 3;
    }
    // Solid angle by van Oosterom and Strackee.
    const double numerator = glm::dot(d[0], glm::cross(d[1], d[2]));
    const double denominator = 1 + glm::dot(d[0], d[1]) + glm::dot(d[1], d[2]) + glm::dot(d[2], d[0]);
    volume += 2 * std::atan2(numerator, denominator) * cubes / 3;
  }
  return volume;
}

/// Smallest cosine between a corner's normal and the mean of its faces' normals, weighted by area.
float worst_normal(const Mesh& mesh) {
  std::vector<glm::vec3> mean(mesh.positions.size(), glm::vec3(0));
  for (const glm::uvec3& t : mesh.triangles) {
    const glm::vec3 &a = mesh.positions[t.x], &b = mesh.positions[t.y], &c = mesh.positions[t.z];
    for (int i = 0; i < 3; ++i) mean[t[i]] += glm::cross(b - a, c - a);
  }
  float worst = 1;
  for (size_t i = 0; i < mean.size(); ++i) worst = std::min(worst, glm::dot(glm::normalize(mean[i]), mesh.normals[i]));
  return worst;
}

/// Length of the (2, 3) torus knot on the torus of radii 0.4 and 0.2.
double knot_length() {
  constexpr int steps = 10'000;
  double length = 0;
  for (int i = 0; i < steps; ++i) {
    const double around = 2 * (0.4 + 0.2 * std::cos(3 * 2 * glm::pi<double>() * i / steps));
    length += std::hypot(around, 3 * 0.2) * 2 * glm::pi<double>() / steps;
  }
  return length;
}

/// Of the polyhedron that bursts: tetrahedra from the centre.
double burst_volume() {
  double volume = 0;
  for (const auto& [a, b, c] : icosphere(3))
    volume += glm::dot(glm::dvec3(a), glm::cross(glm::dvec3(b), glm::dvec3(c))) / 6;
  return std::pow(0.7, 3) * volume;
}

}  // namespace

TEST_CASE("solids are closed bodies with the volumes of their closed forms") {
  const Scene scene = load_scene("builtin:solids");
  CHECK(scene.triangle_count() > 60'000);
  CHECK(scene.triangle_count() < 80'000);
  CHECK(solid_volume(scene, "slab") == test::relative(4 * 0.15 * 4, 1e-6));
  // Inscribed polyhedra: a little less than the sphere, by about π/√27 · 4π/faces.
  const double glass = solid_volume(scene, "glass ball"), mirror = solid_volume(scene, "mirror ball");
  CHECK(glass < sphere_volume(0.3));
  CHECK(glass == test::relative(sphere_volume(0.3), 1e-3));
  CHECK(mirror < sphere_volume(0.22));
  CHECK(mirror == test::relative(sphere_volume(0.22), 3e-3));
  CHECK(solid_volume(scene, "lamp") == test::relative(sphere_volume(0.22), 1e-2));
  // Pappus: the section's area, a polygon of 32 corners, times the length of the middle line; 320 chords of that line
  // are shorter, and each section is turned against the next by 0.08 rad.
  const double section = 16 * 0.11 * 0.11 * std::sin(2 * glm::pi<double>() / 32);
  const double knot = solid_volume(scene, "torus knot");
  CHECK(knot < section * knot_length());
  CHECK(knot == test::relative(section * knot_length(), 4e-3));
}

TEST_CASE("the horned blob stays a star-shaped body with true normals while it swells") {
  for (const char* at : {"0", "0.7", "2"}) {
    CAPTURE(at);
    SceneOverrides overrides;
    overrides.animation = "swell";
    overrides.at_seconds = std::stod(at);
    const Scene scene = load_scene("builtin:solids", overrides);
    const SceneInstance& blob = instance_of(scene, "horned blob");
    CHECK(solid_volume(scene, "horned blob") == test::relative(star_volume(blob.shape(scene)), 2e-3));
    CHECK(worst_normal(blob.shape(scene)) > 0.99f);
  }
}

TEST_CASE("solids: one animation is rigid, the other a morph") {
  Scene scene = load_scene("builtin:solids");
  REQUIRE(scene.animations.size() == 2);
  const double knot = solid_volume(scene, "torus knot");
  const SceneChange turned = evaluate(scene, 0.9, 0);
  CHECK(turned.moved_instances.size() == 2);
  CHECK(turned.deformed_instances.empty());
  CHECK(solid_volume(scene, "torus knot") == test::relative(knot, 1e-5));
  evaluate(scene, 0, 0);
  const SceneChange swollen = evaluate(scene, 0.9, 1);
  CHECK(swollen.moved_instances.empty());
  CHECK(swollen.deformed_instances.size() == 1);
}

TEST_CASE("debris: closed pieces that fill the ball, and stay rigid as they fly") {
  for (const int pieces : {1, 2, 40, 4000}) {
    CAPTURE(pieces);
    Scene scene = load_scene(pieces == 4000 ? "builtin:debris" : "builtin:debris:pieces=" + std::to_string(pieces));
    const SceneInstance& burst = instance_of(scene, "pieces");
    const MeshComponents rest = components_of(scene, burst);
    CHECK(rest.components.size() == static_cast<size_t>(pieces));
    CHECK(evaluate(scene, 1.37).deformed_instances.size() == 1);
    const MeshComponents flying = components_of(scene, burst);
    REQUIRE(flying.components.size() == rest.components.size());
    double sum = 0;
    size_t open = 0, changed = 0;
    for (size_t i = 0; i < rest.components.size(); ++i) {
      const MeshComponent &a = rest.components[i], &b = flying.components[i];
      sum += a.volume;
      open += !a.closed || !b.closed || a.volume <= 0;
      changed += std::abs(a.volume - b.volume) > 1e-4 * a.volume + 1e-9;
    }
    CHECK(sum == test::relative(burst_volume(), 1e-5));
    CHECK(open == 0);
    CHECK(changed == 0);
    CHECK(burst.shape(scene).triangles.size() == scene.meshes[burst.mesh].triangles.size());
    if (pieces == 4000) CHECK(std::abs(static_cast<double>(scene.triangle_count()) - 200'000) < 10'000);
  }
}

TEST_CASE("debris flies above the floor, and its normals turn with it") {
  Scene scene = load_scene("builtin:debris:pieces=300");
  for (const double at : {0., 1., 1.99}) {
    evaluate(scene, at);
    const auto index = static_cast<int>(&instance_of(scene, "pieces") - scene.instances.data());
    CHECK(scene.instance_bounds(index).min.y > 0);
    const Mesh& mesh = scene.instances[index].shape(scene);
    float worst = 1;
    for (const glm::uvec3& t : mesh.triangles) {
      const glm::vec3 &a = mesh.positions[t.x], &b = mesh.positions[t.y], &c = mesh.positions[t.z];
      worst = std::min(worst, glm::dot(glm::normalize(glm::cross(b - a, c - a)), mesh.normals[t.x]));
    }
    CHECK(worst > 0.9f);
  }
}

TEST_CASE("parameters of built-in scenes: wrong ones say what may be given") {
  const auto fails = [](const char* text, const char* message) {
    CHECK_THROWS_WITH_AS(make_builtin_scene(text), doctest::Contains(message), Error);
  };
  fails("debris:pieces=0",
        "builtin:debris: pieces='0' is not a whole number from 1 to 100000; for example pieces=4000");
  fails("debris:pieces=100001", "is not a whole number from 1 to 100000");
  fails("debris:pieces=4.5", "is not a whole number");
  fails("debris:pieces=99999999999", "is not a whole number");
  fails("debris:pieces", "pieces='' is not a whole number");
  fails("debris:piece=4", "there is no parameter 'piece'; did you mean 'pieces'?");
  fails("debris:", "there is no parameter ''; known are pieces");
  fails("debris:pieces=4,", "there is no parameter ''");
  fails("cornell:pieces=4", "builtin:cornell: this scene has no parameters; leave out ':pieces=4'");
  fails("debri:pieces=4", "did you mean 'debris'?");
  CHECK(make_builtin_scene("debris:pieces=3").source == "builtin:debris:pieces=3");
  CHECK(builtin_scene_parameters("debris").size() == 1);
  CHECK(builtin_scene_parameters("room").size() == 1);
  CHECK(builtin_scene_parameters("cornell").empty());
  CHECK(builtin_scene_parameters("no such scene").empty());
}
