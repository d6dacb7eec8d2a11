// SPDX-License-Identifier: Apache-2.0
#include "lucarium/scene/builtin/scenes.h"

#include <doctest/doctest.h>

#include <algorithm>

#include "lucarium/base/error.h"
#include "lucarium/scene/load/load_scene.h"
#include "scene_support.h"
#include "tolerance.h"

using namespace lucarium;

namespace {

double triangle_area(const Mesh& mesh, const glm::uvec3& t) {
  const glm::dvec3 a(mesh.positions[t.x]), b(mesh.positions[t.y]), c(mesh.positions[t.z]);
  return 0.5 * glm::length(glm::cross(b - a, c - a));
}

/// Signed volume enclosed by the chosen meshes; positive when they face outwards.
template <class Chosen>
double signed_volume(const Scene& scene, Chosen&& chosen) {
  double volume = 0;
  for (const Mesh& mesh : scene.meshes) {
    if (!chosen(mesh)) continue;
    for (const glm::uvec3& t : mesh.triangles) {
      const glm::dvec3 a(mesh.positions[t.x]), b(mesh.positions[t.y]), c(mesh.positions[t.z]);
      volume += glm::dot(a, glm::cross(b, c)) / 6;
    }
  }
  return volume;
}

/// Triangles without area, or whose shading normals are not unit vectors on the front side.
size_t count_bad_triangles(const Mesh& mesh) {
  size_t bad = 0;
  for (const glm::uvec3& t : mesh.triangles) {
    const glm::vec3 &a = mesh.positions[t.x], &b = mesh.positions[t.y], &c = mesh.positions[t.z];
    const glm::vec3 n = glm::cross(b - a, c - a);
    bool sound = triangle_area(mesh, t) > 1e-9;
    for (int i = 0; i < 3; ++i) {
      const glm::vec3& normal = mesh.normals[t[i]];
      sound = sound && std::abs(glm::length(normal) - 1) < 1e-4f && glm::dot(normal, n) > 0;
    }
    bad += !sound;
  }
  return bad;
}

}  // namespace

TEST_CASE("every built-in scene has a camera, a light, and sound triangles") {
  for (const std::string& name : builtin_scene_names()) {
    CAPTURE(name);
    const Scene scene = load_scene("builtin:" + name);
    CHECK_FALSE(scene.cameras.empty());
    CHECK(scene.has_light());
    CHECK(scene.warnings.empty());
    for (const Mesh& mesh : scene.meshes) {
      CAPTURE(mesh.name);
      REQUIRE(mesh.normals.size() == mesh.positions.size());
      CHECK(count_bad_triangles(mesh) == 0);
    }
    for (const SceneMaterial& material : scene.materials) {
      const glm::vec4 albedo = (1 - material.transmission) * material.base_color;
      CHECK(std::max({albedo.r, albedo.g, albedo.b}) <= 0.8f);
    }
  }
}

TEST_CASE("an unknown built-in scene names the nearest") {
  CHECK_THROWS_WITH_AS(make_builtin_scene("cornel"), doctest::Contains("did you mean 'cornell'"), Error);
}

TEST_CASE("the Cornell box: open towards the camera only, blocks closed, lamp of 130 x 105 mm") {
  const Scene scene = make_builtin_scene("cornell");
  const auto is_block = [](const Mesh& m) { return m.name.find("block") != std::string::npos; };
  const auto [block_edges, open_block_edges] = test::count_edges(scene, is_block);
  CHECK(block_edges == 2 * 18);
  CHECK(open_block_edges == 0);
  // Walls, ceiling and lamp together lack just the four edges of the open side.
  CHECK(test::count_edges(scene, [&](const Mesh& m) { return !is_block(m); }).second == 4);
  // Footprints by the shoelace formula: 27 633 mm^2 and 27 626.5 mm^2.
  CHECK(signed_volume(scene, is_block) == test::relative(0.027633 * 0.165 + 0.0276265 * 0.33, 1e-5));
  double area = 0;
  for (const SceneInstance& instance : scene.instances) {
    if (!scene.materials[instance.material].emits()) continue;
    const Mesh& mesh = scene.meshes[instance.mesh];
    for (const glm::uvec3& t : mesh.triangles) {
      area += triangle_area(mesh, t);
      CHECK(mesh.normals[t.x] == glm::vec3(0, -1, 0));
    }
  }
  CHECK(area == test::relative(0.130 * 0.105, 1e-5));
}

TEST_CASE("the room is closed, faces inwards and has the golden numbers") {
  const Scene scene = make_builtin_scene("room");
  const auto is_box = [](const Mesh& m) { return m.name == "box"; };
  const auto is_wall = [](const Mesh& m) { return m.name != "box"; };
  CHECK(test::count_edges(scene, is_box).second == 0);
  CHECK(test::count_edges(scene, is_wall).second == 0);
  CHECK(signed_volume(scene, is_wall) == test::relative(-8));
  CHECK(signed_volume(scene, is_box) == test::relative(0.5 * 0.8 * 0.5));
  const Bounds bounds = scene.bounds();
  CHECK(bounds.min == glm::vec3(-1, 0, -1));
  CHECK(bounds.max == glm::vec3(1, 2, 1));
  REQUIRE(scene.lights.size() == 1);
  CHECK(scene.lights[0].intensity == glm::vec3(1));
  CHECK(glm::vec3(scene.lights[0].world_from_light[3]) == glm::vec3(-0.6f, 1.3f, -0.7f));
  for (const SceneMaterial& material : scene.materials) CHECK(material.ior == 1);
}

TEST_CASE("the furnace is a closed convex body of flat facets") {
  const Scene scene = make_builtin_scene("furnace");
  CHECK(test::count_edges(scene, [](const Mesh&) { return true; }).second == 0);
  const Mesh& mesh = scene.meshes[0];
  CHECK(mesh.triangles.size() == 1280);
  size_t not_flat = 0;
  for (const glm::uvec3& t : mesh.triangles) {
    const glm::vec3 n =
        glm::cross(mesh.positions[t.y] - mesh.positions[t.x], mesh.positions[t.z] - mesh.positions[t.x]);
    not_flat += glm::dot(glm::normalize(n), mesh.normals[t.x]) < 0.99999f;
  }
  CHECK(not_flat == 0);
  REQUIRE(scene.environment);
  CHECK(scene.environment->width == 0);
  CHECK(scene.environment->factor == glm::vec3(1));
}

TEST_CASE("the atrium has about 300 000 triangles, sun, sky and lanterns") {
  const Scene scene = load_scene("builtin:atrium");
  CHECK(scene.triangle_count() > 250'000);
  CHECK(scene.triangle_count() < 350'000);
  REQUIRE(scene.lights.size() == 1);
  CHECK(scene.lights[0].type == LightType::directional);
  REQUIRE(scene.environment);
  CHECK(scene.environment->width > 0);
  CHECK(scene.cameras.size() == 3);
  size_t lanterns = 0;
  for (const SceneInstance& instance : scene.instances) lanterns += scene.materials[instance.material].emits();
  CHECK(lanterns == 12);
  // What keeps the light out is closed: walls, slabs, roof and foundation.
  for (const char* name : {"outer wall", "upper floor", "roof", "foundation", "cornice", "roof cornice", "parapet"}) {
    CAPTURE(name);
    const auto [edges, open] = test::count_edges(scene, [&](const Mesh& m) { return m.name == name; });
    CHECK(edges > 0);
    CHECK(open == 0);
    CHECK(signed_volume(scene, [&](const Mesh& m) { return m.name == name; }) > 0);
  }
}

TEST_CASE("lamps share out the same emitting area") {
  const auto emitting_area = [](const std::string& name) {
    const Scene scene = make_builtin_scene(name);
    double area = 0;
    for (const SceneInstance& instance : scene.instances) {
      if (!scene.materials[instance.material].emits()) continue;
      for (const glm::uvec3& t : scene.meshes[instance.mesh].triangles)
        area += triangle_area(scene.meshes[instance.mesh], t);
    }
    return area;
  };
  const double one = emitting_area("lamps-1");
  CHECK(one > 0);
  CHECK(emitting_area("lamps-10") == test::relative(one, 1e-5));
  CHECK(emitting_area("lamps-100") == test::relative(one, 1e-5));
}

TEST_CASE("blocks: as many triangles as asked for, of the same area, none of two blocks inside one another") {
  for (const int triangles : {100, 118, 1000, 30'011, 100'000, 1'000'000}) {
    CAPTURE(triangles);
    const Scene scene = make_builtin_scene("blocks:triangles=" + std::to_string(triangles));
    CHECK(scene.triangle_count() == static_cast<uint64_t>(triangles));
    double area = 0;
    std::vector<Bounds> blocks;
    const auto is_block = [](const Mesh& m) { return m.name.find("blocks") != std::string::npos; };
    for (const Mesh& mesh : scene.meshes) {
      CHECK(count_bad_triangles(mesh) == 0);
      if (!is_block(mesh)) continue;
      for (size_t i = 0; i < mesh.triangles.size(); ++i) {
        if (i % 12 == 0) blocks.emplace_back();
        area += triangle_area(mesh, mesh.triangles[i]);
        for (int k = 0; k < 3; ++k) blocks.back().add(mesh.positions[mesh.triangles[i][k]]);
      }
    }
    CHECK(area == test::relative(16.0, 1e-4));
    CHECK(signed_volume(scene, is_block) > 0);
    CHECK(blocks.size() == static_cast<size_t>((triangles - 14) / 12));
    // The spheres about blocks keep apart, and from walls and lamp.
    const double radius = 0.5 * std::sqrt(3 * area / (6.0 * static_cast<double>(blocks.size())));
    size_t close = 0;
    for (size_t i = 0; i < blocks.size(); ++i) {
      const glm::vec3 c = blocks[i].center();
      close += std::min({c.x + 2, 2 - c.x, c.y, 2.99f - c.y, c.z + 2, 2 - c.z}) <= radius;
      for (size_t j = i + 1; j < std::min(blocks.size(), i + 500); ++j)
        close += glm::distance(c, blocks[j].center()) <= 2 * radius;
    }
    CHECK(close == 0);
  }
}

TEST_CASE("the lamp of the blocks has as many triangles as asked for, of the same area, facing down, apart") {
  for (const int lights : {1, 2, 3, 10, 1000, 100'000}) {
    CAPTURE(lights);
    const Scene scene = make_builtin_scene("blocks:lights=" + std::to_string(lights));
    CHECK(scene.triangle_count() == static_cast<uint64_t>(3000 - 2 + lights));
    const auto lamp =
        std::find_if(scene.meshes.begin(), scene.meshes.end(), [](const Mesh& mesh) { return mesh.name == "lamp"; });
    REQUIRE(lamp != scene.meshes.end());
    REQUIRE(lamp->triangles.size() == static_cast<size_t>(lights));
    double area = 0;
    bool below = true, apart = true;
    Bounds before;
    for (size_t i = 0; i < lamp->triangles.size(); ++i) {
      const glm::uvec3& t = lamp->triangles[i];
      area += triangle_area(*lamp, t);
      Bounds bounds;
      for (int k = 0; k < 3; ++k) {
        bounds.add(lamp->positions[t[k]]);
        below &= lamp->normals[t[k]] == glm::vec3(0, -1, 0);
      }
      below &= bounds.min.y > 2.98f && bounds.max.y < 3 && bounds.min.x > -2 && bounds.max.x < 2 && bounds.min.z > -2 &&
               bounds.max.z < 2;
      // Of a row: each begins where the one before it has ended; the next row begins behind it.
      if (i > 0 && lights != 2) apart &= bounds.min.x > before.max.x || bounds.min.z > before.max.z;
      before = bounds;
    }
    CHECK(area == test::relative(1.0, 1e-4));
    CHECK(below);
    CHECK(apart);
  }
  CHECK_THROWS_WITH_AS(make_builtin_scene("blocks:lights=0"), doctest::Contains("from 1 to 100000"), Error);
}

TEST_CASE("the mirror hall: about 9400 triangles, one wall half mirror and half diffuse without a coat") {
  const Scene scene = make_builtin_scene("mirror-hall");
  CHECK(scene.triangle_count() > 9300);
  CHECK(scene.triangle_count() < 9500);
  size_t half = 0;
  for (const SceneInstance& instance : scene.instances) {
    const SceneMaterial& material = scene.materials[instance.material];
    if (material.metallic != 0.5f) continue;
    CHECK(material.roughness == 0);
    CHECK(material.ior == 1);
    for (const glm::vec3& p : scene.meshes[instance.mesh].positions) CHECK(p.x == -3);
    ++half;
  }
  CHECK(half == 1);
  const auto is_wall = [](const Mesh& m) {
    return m.name.find("wall") != std::string::npos || m.name == "mirror" || m.name == "floor" || m.name == "ceiling";
  };
  CHECK(test::count_edges(scene, is_wall).second == 0);
  CHECK(signed_volume(scene, is_wall) == test::relative(-6 * 3.6 * 8, 1e-5));
  const auto is_figure = [](const Mesh& m) { return m.name == "figure"; };
  CHECK(test::count_edges(scene, is_figure).second == 0);
  CHECK(signed_volume(scene, is_figure) > 0.1);
}
