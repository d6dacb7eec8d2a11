// SPDX-License-Identifier: Apache-2.0
// builtin:solids: closed bodies over a slab: a torus knot, a horned blob, a ball of glass and a mirror ball, lit by a
// glowing ball and the sky. Animations: `turn` (rigid), `swell` (morph). Declared in builder.h.
#include <cmath>
#include <glm/gtc/constants.hpp>
#include <glm/gtc/quaternion.hpp>

#include "lucarium/scene/builtin/builder.h"
#include "lucarium/scene/mesh_topology.h"

namespace lucarium {

namespace {

constexpr float animation_seconds = 4;

/// Corners of an icosphere, each once, and its triangles.
struct IndexedSphere {
  std::vector<glm::vec3> corners;
  std::vector<glm::uvec3> triangles;
};

IndexedSphere indexed_sphere(int levels) {
  std::vector<glm::vec3> soup;
  for (const std::array<glm::vec3, 3>& face : icosphere(levels)) soup.insert(soup.end(), face.begin(), face.end());
  const std::vector<uint32_t> first = weld_positions(soup);
  IndexedSphere sphere;
  std::vector<uint32_t> index(soup.size());
  for (uint32_t i = 0; i < soup.size(); ++i) {
    index[i] = first[i] == i ? static_cast<uint32_t>(sphere.corners.size()) : index[first[i]];
    if (first[i] == i) sphere.corners.push_back(soup[i]);
  }
  for (size_t i = 0; i < index.size(); i += 3) sphere.triangles.emplace_back(index[i], index[i + 1], index[i + 2]);
  return sphere;
}

Mesh ball(const std::string& name, int levels, float radius) {
  const IndexedSphere sphere = indexed_sphere(levels);
  MeshBuilder builder(name);
  for (const glm::vec3& p : sphere.corners) builder.vertex(radius * p, p);
  for (const glm::uvec3& t : sphere.triangles) builder.face(t.x, t.y, t.z);
  return builder.take();
}

/// A tube of radius 0.11 m around the (2, 3) torus knot on the torus of radii 0.4 and 0.2 m about the Z axis.
Mesh torus_knot() {
  constexpr uint32_t rows = 320, columns = 32;
  constexpr float major = 0.4f, minor = 0.2f, tube = 0.11f;
  MeshBuilder builder("torus knot");
  for (uint32_t i = 0; i < rows; ++i) {
    const float phi = 2 * glm::pi<float>() * static_cast<float>(i) / rows;
    const float c2 = std::cos(2 * phi), s2 = std::sin(2 * phi), c3 = std::cos(3 * phi), s3 = std::sin(3 * phi);
    const glm::vec3 around(c2, s2, 0), outward = c3 * around + glm::vec3(0, 0, -s3);
    const glm::vec3 centre = major * around + minor * outward;
    const glm::vec3 tangent = glm::normalize(2 * (major + minor * c3) * glm::vec3(-s2, c2, 0) -
                                             3 * minor * s3 * around - glm::vec3(0, 0, 3 * minor * c3));
    const glm::vec3 n = glm::normalize(outward - glm::dot(outward, tangent) * tangent), b = glm::cross(tangent, n);
    for (uint32_t j = 0; j < columns; ++j) {
      const float theta = 2 * glm::pi<float>() * static_cast<float>(j) / columns;
      const glm::vec3 normal = std::cos(theta) * n + std::sin(theta) * b;
      builder.vertex(centre + tube * normal, normal);
    }
  }
  const auto at = [](uint32_t i, uint32_t j) { return i % rows * columns + j % columns; };
  for (uint32_t i = 0; i < rows; ++i) {
    for (uint32_t j = 0; j < columns; ++j) {
      builder.face(at(i, j), at(i, j + 1), at(i + 1, j + 1));
      builder.face(at(i, j), at(i + 1, j + 1), at(i + 1, j));
    }
  }
  return builder.take();
}

/// A star-shaped body: radius over the unit direction d = size (1 + Σ height exp(sharpness (d·axis − 1))).
struct Horn {
  glm::vec3 axis;
  float height, sharpness;
};

constexpr float blob_size = 0.38f;

/// Point in direction d, and the normal there, not of unit length: radius d − its gradient on the sphere. Both are
/// linear in the heights, so that morphs between two sets of horns have exact normals.
void horned_point(const std::vector<Horn>& horns, const glm::vec3& d, glm::vec3& point, glm::vec3& normal) {
  float radius = blob_size;
  glm::vec3 gradient(0);
  for (const Horn& horn : horns) {
    const glm::vec3 axis = glm::normalize(horn.axis);
    const float rise = blob_size * horn.height * std::exp(horn.sharpness * (glm::dot(d, axis) - 1));
    radius += rise;
    gradient += rise * horn.sharpness * axis;
  }
  point = radius * d;
  normal = radius * d - (gradient - glm::dot(gradient, d) * d);
}

/// Five horns; the morph target draws them in and raises five others.
Mesh horned_blob() {
  const std::vector<Horn> rest = {{{0.3f, 1, 0.2f}, 1.2f, 60},
                                  {{-1, 0.5f, 0.3f}, 0.9f, 40},
                                  {{0.9f, 0.2f, 0.6f}, 1.f, 80},
                                  {{0.1f, 0.1f, -1}, 0.7f, 30},
                                  {{-0.3f, 0, 1}, 0.8f, 50}};
  const std::vector<Horn> swollen = {{{-0.4f, 1, -0.1f}, 0.9f, 30},
                                     {{1, 0.4f, -0.2f}, 0.8f, 25},
                                     {{-0.9f, -0.1f, 0.5f}, 0.9f, 50},
                                     {{0.5f, 0.3f, 1}, 0.7f, 20},
                                     {{0, 0.6f, -1}, 0.8f, 40}};
  const IndexedSphere sphere = indexed_sphere(5);
  MeshBuilder builder("horned blob");
  MorphTarget target;
  for (const glm::vec3& d : sphere.corners) {
    glm::vec3 point, normal, moved, moved_normal;
    horned_point(rest, d, point, normal);
    horned_point(swollen, d, moved, moved_normal);
    builder.vertex(point, normal);
    target.positions.push_back(moved - point);
    target.normals.push_back((moved_normal - normal) / glm::length(normal));
  }
  for (const glm::uvec3& t : sphere.triangles) builder.face(t.x, t.y, t.z);
  Mesh mesh = builder.take();
  mesh.morph_targets.push_back(std::move(target));
  return mesh;
}

int add_glass(Scene& scene) {
  SceneMaterial glass;
  glass.name = "glass";
  glass.base_color = {0.96f, 0.98f, 0.97f, 1};
  glass.metallic = 0;
  glass.roughness = 0;
  glass.transmission = 1;
  glass.thickness = 1;
  scene.materials.push_back(glass);
  return static_cast<int>(scene.materials.size()) - 1;
}

/// One turn of the knot about the vertical, and a round of the mirror ball.
Animation turn(int knot, int mirror, const glm::vec3& knot_place, const glm::vec3& mirror_place) {
  Animation animation{.name = "turn", .channels = {}, .duration = animation_seconds};
  AnimationChannel rotation{.node = knot, .path = AnimationPath::rotation, .times = {}, .values = {}};
  AnimationChannel round{.node = mirror, .path = AnimationPath::translation, .times = {}, .values = {}};
  constexpr int keys = 33;
  for (int key = 0; key < keys; ++key) {
    const float part = static_cast<float>(key) / (keys - 1), angle = 2 * glm::pi<float>() * part;
    for (AnimationChannel* channel : {&rotation, &round}) channel->times.push_back(part * animation_seconds);
    const glm::quat q = glm::angleAxis(angle, glm::vec3(0, 1, 0));
    rotation.values.insert(rotation.values.end(), {q.x, q.y, q.z, q.w});
    const glm::vec3 arm = mirror_place - glm::vec3(knot_place.x, mirror_place.y, knot_place.z);
    const glm::vec3 place = mirror_place - arm + glm::angleAxis(angle, glm::vec3(0, 1, 0)) * arm;
    round.values.insert(round.values.end(), {place.x, place.y, place.z});
  }
  animation.channels = {rotation, round};
  return animation;
}

}  // namespace

Scene make_solids() {
  Scene scene;
  const int stone = add_lambert(scene, "slab", {0.62f, 0.60f, 0.56f});
  const int lacquer = add_dielectric(scene, "red lacquer", {0.62f, 0.10f, 0.07f}, 0.35f);
  const int gold = add_metal(scene, "brass", {0.78f, 0.58f, 0.26f}, 0.3f);
  const int mirror = add_metal(scene, "mirror", glm::vec3(0.8f), 0.f);
  const int glass = add_glass(scene);
  const int lamp = add_emitter(scene, "lamp", {150.f, 128.f, 98.f});

  const glm::vec3 knot_place(-0.62f, 0.78f, -0.45f), mirror_place(-0.62f, 0.3f, 0.75f);
  add_instance(scene, add_mesh(scene, MeshBuilder("slab").box({-2, -0.15f, -2}, {2, 0, 2}).take()), stone);
  const int knot = add_node_instance(scene, add_mesh(scene, torus_knot()), gold, knot_place);
  const int blob = add_node_instance(scene, add_mesh(scene, horned_blob()), lacquer, {0.85f, 0.62f, -0.35f});
  const int ball_of_mirror =
      add_node_instance(scene, add_mesh(scene, ball("mirror ball", 4, 0.22f)), mirror, mirror_place);
  add_node_instance(scene, add_mesh(scene, ball("glass ball", 5, 0.3f)), glass, {0.45f, 0.36f, 0.85f});
  add_node_instance(scene, add_mesh(scene, ball("lamp", 3, 0.22f)), lamp, {-1.1f, 2.4f, 1.2f});
  scene.nodes[blob].morph_weights = {0};

  scene.animations.push_back(turn(knot, ball_of_mirror, knot_place, mirror_place));
  AnimationChannel swell{.node = blob, .path = AnimationPath::weights, .times = {}, .values = {}};
  swell.times = {0, animation_seconds / 2, animation_seconds};
  swell.values = {0, 1, 0};
  scene.animations.push_back({.name = "swell", .channels = {swell}, .duration = animation_seconds});

  scene.environment = clear_sky(0.3f);
  scene.cameras.push_back(look_at_camera("front", {0.35f, 1.7f, 3.3f}, {0.05f, 0.5f, 0.f}, 37.f));
  scene.cameras.push_back(look_at_camera("low", {2.3f, 0.5f, 1.6f}, {0.f, 0.6f, -0.1f}, 42.f));
  scene.cameras.push_back(look_at_camera("above", {-1.2f, 3.6f, 1.4f}, {0.1f, 0.2f, 0.f}, 42.f));
  return scene;
}

}  // namespace lucarium
