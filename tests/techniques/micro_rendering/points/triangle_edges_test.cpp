// SPDX-License-Identifier: Apache-2.0
// Where discs end: edges that bound them, sides of sheets, and the light of surfaces that are hardly larger than a
// disc.
#include "micro_rendering/points/triangle_edges.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <numbers>

#include "device_fixture.h"
#include "micro_rendering/tree/point_forest.h"
#include "technique_fixture.h"
#include "tolerance.h"

using namespace lucarium;
using namespace lucarium::micro;
using namespace lucarium::test;

namespace {

std::vector<TriangleEdges> edges_in(Mesh mesh, bool two_sided = false) {
  Scene scene;
  scene.source = "test:edges";
  const int grey = add_lambert(scene, "grey", glm::vec3(0.5f));
  scene.materials.back().double_sided = two_sided;
  add_instance(scene, add_mesh(scene, std::move(mesh)), grey);
  const SceneBuffers buffers(*test_device(), scene);
  return find_triangle_edges(find_tree_sources(scene, buffers),
                             buffers.scene_triangles.download(0, buffers.info().triangle_count));
}

long count_of(const TriangleEdges& edges) {
  return (MICRO_CLIPS * 2 - std::count(std::begin(edges.ends), std::end(edges.ends), LUCARIUM_NONE)) / 2;
}

void look(Scene& scene, const glm::vec3& eye, const glm::vec3& target, float yfov) {
  SceneCamera camera;
  camera.yfov = yfov;
  camera.world_from_camera = glm::inverse(glm::lookAt(eye, target, glm::vec3(0, 1, 0.1f)));
  scene.cameras = {camera};
}

/// Irradiance over pi below the middle of a rectangle 2a x 2b of radiance 1 at height h (both planes parallel).
double below_rectangle(double a, double b, double h) {
  const double x = a / h, y = b / h, sx = std::sqrt(1 + x * x), sy = std::sqrt(1 + y * y);
  return 2 / std::numbers::pi * (x / sx * std::atan(y / sx) + y / sy * std::atan(x / sy));
}

}  // namespace

TEST_CASE("discs end where a surface ends or bends away from its front, and go on over flat and hollow edges") {
  for (const TriangleEdges& edges : edges_in(MeshBuilder("box").box({0, 0, 0}, {1, 2, 3}).take())) {
    CHECK(edges.own == 2);        // not the diagonal
    CHECK(count_of(edges) == 4);  // and those of the other half of the face
    CHECK(edges.sheet == 0);
  }
  MeshBuilder room("room");
  for (int axis = 0; axis < 3; ++axis)
    for (int side = 0; side < 2; ++side) room.box_face({0, 0, 0}, {1, 2, 3}, axis, side, true);
  for (const TriangleEdges& edges : edges_in(room.take())) CHECK(count_of(edges) == 0);
  for (const TriangleEdges& edges :
       edges_in(MeshBuilder("quad").quad({0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}).take()))
    CHECK(edges.own == 2);
}

TEST_CASE("triangles of one sheet are joined where they are wound alike") {
  const glm::vec3 a(0, 0, 0), b(1, 0, 0), c(1, 1, 0), d(0, 1, 0), e(2, 0, 0.5f), f(2, 1, 0.5f);
  const auto alike = edges_in(MeshBuilder("alike").quad(a, b, c, d).quad(b, e, f, c).take(), true);
  for (const TriangleEdges& edges : alike) CHECK(edges.sheet == alike[0].sheet);
  CHECK(alike[0].sheet != 0);
  const auto turned = edges_in(MeshBuilder("turned").quad(a, b, c, d).quad(c, f, e, b).take(), true);
  CHECK(turned[0].sheet == turned[1].sheet);
  CHECK(turned[2].sheet == turned[3].sheet);
  CHECK(turned[0].sheet != turned[2].sheet);
}

TEST_CASE("a node's area is what it shows along its axis") {
  // A roof whose halves are at right angles: cos 45 degrees of its area is seen from above. A flat one shows all.
  for (const float height : {1.f, 0.f}) {
    Scene scene;
    scene.source = "test:roof";
    MeshBuilder roof("roof");
    roof.quad({0, height, 0}, {0, height, 0.1f}, {1, 0, 0.1f}, {1, 0, 0})
        .quad({-1, 0, 0}, {-1, 0, 0.1f}, {0, height, 0.1f}, {0, height, 0});
    add_instance(scene, add_mesh(scene, roof.take()), add_lambert(scene, "grey", glm::vec3(0.5f)));
    KernelScheduler scheduler(test_device());
    const SceneBuffers buffers(*test_device(), scene);
    const PointForest forest(*test_device(), scheduler, scene, buffers, {.points_log2 = 10}, "test");
    const float shown = static_cast<float>(forest.nodes.download(1, 1).front().w >> 24) / 255.f;
    CHECK(shown == test::relative(height > 0 ? std::sqrt(0.5) : 1., 0.03));
  }
}

TEST_CASE("folds much finer than discs are reported, wide ones are not") {
  for (const int folds : {1, 100}) {
    Scene scene;
    scene.source = "test:folds";
    MeshBuilder sheet("sheet");
    const float width = 1 / static_cast<float>(folds);
    for (int i = 0; i < folds; ++i) {
      const float low = static_cast<float>(i) * width, middle = low + width / 2, high = low + width, top = width / 2;
      sheet.quad({low, 0, 0}, {low, 0, 1}, {middle, top, 1}, {middle, top, 0})
          .quad({middle, top, 0}, {middle, top, 1}, {high, 0, 1}, {high, 0, 0});
    }
    add_instance(scene, add_mesh(scene, sheet.take()), add_lambert(scene, "grey", glm::vec3(0.5f)));
    KernelScheduler scheduler(test_device());
    const SceneBuffers buffers(*test_device(), scene);
    const PointForest forest(*test_device(), scheduler, scene, buffers, {.points_log2 = 10}, "test");
    MESSAGE(folds, " folds: ", forest.fine_details());
    // Of two points on fine folds each is on either face, whose normals are at right angles: half of the pairs would be
    // on both, and more are, since points that face alike keep farther apart.
    CHECK(forest.fine_details() >= (folds == 1 ? 0 : 0.5));
    CHECK(forest.fine_details() <= (folds == 1 ? 0.03 : 0.75));
  }
}

TEST_CASE("a strip hardly wider than its discs gives the light of its form factor") {
  // Under an environment of 1 a strip that faces down has its albedo as radiance. Discs of radius 0.18 m on 0.4 m of
  // width: a far surface, seen from its black back, takes nearly all points.
  constexpr float half_width = 0.2f, half_length = 1.5f, height = 0.5f;
  Scene scene;
  scene.source = "test:strip";
  const int grey = add_lambert(scene, "grey", glm::vec3(0.5f));
  MeshBuilder builder("strip");
  builder.quad({-half_width, height, -half_length}, {half_width, height, -half_length},
               {half_width, height, half_length}, {-half_width, height, half_length});
  builder.quad({-0.02f, 0, 0.02f}, {0.02f, 0, 0.02f}, {0.02f, 0, -0.02f}, {-0.02f, 0, -0.02f});
  builder.quad({-3.2f, 20, 3.2f}, {3.2f, 20, 3.2f}, {3.2f, 20, -3.2f}, {-3.2f, 20, -3.2f});
  add_instance(scene, add_mesh(scene, builder.take()), grey);
  scene.environment = Environment{};
  look(scene, {0.3f, 0.1f, 0}, {0, 0, 0}, 0.01f);
  const double light =
      mean(indirect_light(scene, "micro_rendering", 8, 1, 8, {{"points_log2", "10"}, {"light_samples", "16"}}));
  const double expected = 0.25 * below_rectangle(half_width, half_length, height);
  MESSAGE("light ", light, ", expected ", expected, ": ", 100 * (light / expected - 1), " %");
  CHECK(light == test::relative(expected, 0.05));
}

TEST_CASE("an outline is no wider in coarse micro-buffers: a square gives the light of its form factor") {
  // As the strip above, of many discs.
  constexpr float half = 0.4f, height = 0.5f;
  Scene scene;
  scene.source = "test:square";
  const int grey = add_lambert(scene, "grey", glm::vec3(0.5f));
  MeshBuilder builder("square");
  builder.quad({-half, height, -half}, {half, height, -half}, {half, height, half}, {-half, height, half});
  builder.quad({-0.02f, 0, 0.02f}, {0.02f, 0, 0.02f}, {0.02f, 0, -0.02f}, {-0.02f, 0, -0.02f});
  add_instance(scene, add_mesh(scene, builder.take()), grey);
  scene.environment = Environment{};
  look(scene, {0.3f, 0.1f, 0}, {0, 0, 0}, 0.01f);
  for (const char* size : {"8", "16"}) {
    const Parameters parameters = {{"points_log2", "12"}, {"light_samples", "16"}, {"micro_size", size}};
    const double light = mean(indirect_light(scene, "micro_rendering", 8, 1, 16, parameters));
    const double expected = 0.25 * below_rectangle(half, half, height);
    MESSAGE("light ", light, ", expected ", expected, ": ", 100 * (light / expected - 1), " %");
    CHECK(light == test::relative(expected, 0.015));
  }
}

TEST_CASE("from outside a two-sided ball nothing of its lit inside is seen") {
  Scene scene;
  scene.source = "test:ball";
  const int grey = add_lambert(scene, "grey", glm::vec3(0.5f));
  scene.materials.back().double_sided = true;
  MeshBuilder ball("ball");
  for (const auto& t : icosphere(3)) ball.triangle(t[0], t[1], t[2]);
  add_instance(scene, add_mesh(scene, ball.take()), grey);
  scene.lights.emplace_back();
  look(scene, {0, 0, 4}, {0, 0, 0}, 0.4f);
  const Parameters parameters = {{"points_log2", "10"}};
  const double outside = mean(indirect_light(scene, "micro_rendering", 12, 1, 4, parameters));
  const double inside = 0.5 / std::numbers::pi;  // radiance: albedo / pi E, E = 1 lx
  MESSAGE("leak ", 100 * outside / (0.5 * inside), " % of what is reflected inside");
  CHECK(outside / (0.5 * inside) < 1e-4);
}
