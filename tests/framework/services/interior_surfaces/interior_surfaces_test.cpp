// SPDX-License-Identifier: Apache-2.0
// What lies inside solids, by one definition for texels and points.
#include <doctest/doctest.h>

#include <algorithm>
#include <bit>
#include <cmath>

#include "device_fixture.h"
#include "lucarium/scene/builtin/builder.h"
#include "lucarium/services/bvh/bvh.h"
#include "lucarium/services/interior_surfaces/point_interior.h"
#include "lucarium/services/interior_surfaces/texel_interior.h"
#include "test_support.h"
#include "tolerance.h"

using namespace lucarium;
using namespace lucarium::test;

namespace {

/// A floor of 4 m x 4 m at y = 0 that shows its front upwards: instance 0, triangles 0 and 1.
Scene floor_scene() {
  Scene scene;
  const int white = add_lambert(scene, "white", glm::vec3(0.5f));
  const Mesh mesh = MeshBuilder("floor").box_face({-2, 0, -2}, {2, 1, 2}, 1, 0, true).take();
  add_instance(scene, add_mesh(scene, mesh), white);
  return scene;
}

void add_box(Scene& scene, const glm::vec3& low, const glm::vec3& high, int material = 0) {
  add_instance(scene, add_mesh(scene, MeshBuilder("box").box(low, high).take()), material);
}

struct Place {
  glm::vec3 position;
  bool open;
};

/// A grid of points of the floor, on its front or behind it.
std::vector<Place> places(const Scene& scene, const InteriorRule& rule, PointInterior::Side side, uint32_t walks) {
  KernelScheduler scheduler(test_device());
  const SceneBuffers buffers(*test_device(), scene);
  const Bvh bvh(*test_device(), scene, buffers);
  const PointInterior interior(*test_device(), scheduler, buffers, bvh, rule, "test", "");
  const std::vector<Vertex> vertices = buffers.scene_vertices.download();
  const std::vector<Triangle> triangles = buffers.scene_triangles.download(0, 2);
  std::vector<InteriorPoint> points;
  std::vector<Place> result;
  for (uint32_t t = 0; t < 2; ++t)
    for (int i = 0; i < 32; ++i)
      for (int j = 0; i + j < 32; ++j) {
        const float u = (static_cast<float>(i) + 0.31f) / 33, v = (static_cast<float>(j) + 0.37f) / 33;
        const glm::vec3 a = vertices[triangles[t].v0].position.xyz(), b = vertices[triangles[t].v1].position.xyz(),
                        c = vertices[triangles[t].v2].position.xyz();
        points.push_back({t, u, v});
        result.push_back({a + u * (b - a) + v * (c - a), false});
      }
  const std::vector<bool> open = interior.are_open(points, {}, side, walks, {});
  for (size_t i = 0; i < open.size(); ++i) result[i].open = open[i];
  return result;
}

/// Shares of open places within the square |x|, |z| < half, and outside of it; `margin` about its edge is left out.
glm::dvec2 open_shares(const std::vector<Place>& list, float half, float margin = 0.02f) {
  glm::dvec2 open(0), all(0);
  for (const Place& p : list) {
    const float d = std::max(std::abs(p.position.x), std::abs(p.position.z)) - half;
    if (std::abs(d) < margin) continue;
    open[d > 0] += p.open;
    all[d > 0] += 1;
  }
  REQUIRE(all[0] > 50);
  return {open[0] / all[0], all[1] > 0 ? open[1] / all[1] : 1};
}

constexpr auto kOwn = PointInterior::Side::own, kBehind = PointInterior::Side::behind;

}  // namespace

TEST_CASE("points below a solid that stands in the floor are interior, others open") {
  Scene scene = floor_scene();
  add_box(scene, {-1, -0.5f, -1}, {1, 1, 1});
  for (const uint32_t steps : {1u, 6u}) {
    CAPTURE(steps);
    const glm::dvec2 shares = open_shares(places(scene, {.steps = steps}, kOwn, 8), 1);
    CHECK(shares[0] == 0);
    CHECK(shares[1] == 1);
  }
}

TEST_CASE("several steps distinguish a solid within a solid from an open place") {
  Scene scene = floor_scene();
  add_box(scene, {-1, -0.5f, -1}, {1, 1, 1});
  add_box(scene, {-0.25f, 0.5f, -0.25f}, {0.25f, 0.8f, 0.25f});  // its front is all that some first rays meet
  const glm::dvec2 one = open_shares(places(scene, {.steps = 1}, kOwn, 8), 1);
  const glm::dvec2 six = open_shares(places(scene, {.steps = 6}, kOwn, 8), 1);
  // A walk of six steps must meet the small front three times.
  CHECK(one[0] > 0.2);
  CHECK(six[0] < 0.2 * one[0]);
  CHECK(one[1] == 1);
  CHECK(six[1] == 1);
}

TEST_CASE("fronts in contact see nothing of each other, fronts farther apart do") {
  Scene scene = floor_scene();
  add_box(scene, {-1, 0.01f, -1}, {1, 1, 1});  // a box 1 cm above the floor
  const auto middle = [&](float contact) {
    return open_shares(places(scene, {.steps = 6, .contact = contact}, kOwn, 8), 0.9f, 0.1f);
  };
  CHECK(middle(0.02f)[0] == 0);
  CHECK(middle(0.02f)[1] == 1);
  CHECK(middle(0.005f)[0] == 1);  // six steps stay in the gap
}

TEST_CASE("glass lets walks escape, two-sided sheets let them go on") {
  for (const bool glass : {true, false}) {
    CAPTURE(glass);
    Scene scene = floor_scene();
    const int cover = add_lambert(scene, "cover", glm::vec3(0.5f));
    scene.materials[static_cast<size_t>(cover)].transmission = glass ? 1.f : 0.f;
    scene.materials[static_cast<size_t>(cover)].double_sided = !glass;
    add_box(scene, {-1, -0.5f, -1}, {1, 0.5f, 1}, cover);
    CHECK(open_shares(places(scene, {.steps = 6}, kOwn, 8), 1)[0] == 1);
    // Inside a solid the sheet helps nobody.
    add_box(scene, {-1.5f, -1, -1.5f}, {1.5f, 1, 1.5f});
    const double inside = open_shares(places(scene, {.steps = 6}, kOwn, 8), 1)[0];
    // A walk that stays between floor and sheet cannot decide.
    CHECK(inside >= (glass ? 1 : 0.01));
  }
}

TEST_CASE("backs are asked for from their own side") {
  Scene scene = floor_scene();
  add_box(scene, {-1, -1, -1}, {1, -0.1f, 1});  // below the floor, which hides no back: its top is a front
  CHECK(open_shares(places(scene, {.steps = 1}, kBehind, 4), 1)[0] == 1);
  scene = floor_scene();
  add_box(scene, {-1, -0.5f, -1}, {1, 1, 1});
  CHECK(open_shares(places(scene, {.steps = 6}, kBehind, 4), 1)[0] == 0);
  scene = floor_scene();
  add_box(scene, {-1, 0, -1}, {1, 1, 1});  // stands on the floor: the floor's front is inside, its back is not
  CHECK(open_shares(places(scene, {.steps = 1}, kOwn, 4), 1)[0] == 0);
  CHECK(open_shares(places(scene, {.steps = 1}, kBehind, 4), 1)[0] == 1);
}

TEST_CASE("points that are known to be open are left out") {
  Scene scene = floor_scene();
  add_box(scene, {-1, 0, -1}, {1, 1, 1});  // over the middle of the floor
  KernelScheduler scheduler(test_device());
  const SceneBuffers buffers(*test_device(), scene);
  const Bvh bvh(*test_device(), scene, buffers);
  const PointInterior interior(*test_device(), scheduler, buffers, bvh, {}, "test", "");
  const std::vector<InteriorPoint> points(3, InteriorPoint{0, 0.01f, 0.49f});  // about the middle of the floor
  const std::vector<uint8_t> known = {0, 1, 0};
  CHECK(interior.are_open(points, known, kOwn, 8, {}) == std::vector<bool>{false, true, false});
}

TEST_CASE("however many points there are, each is judged as if alone") {
  Scene scene = floor_scene();
  add_box(scene, {-1, -0.5f, -1}, {1, 1, 1});
  add_box(scene, {-0.25f, 0.5f, -0.25f}, {0.25f, 0.8f, 0.25f});  // some walks take several steps
  KernelScheduler scheduler(test_device());
  const SceneBuffers buffers(*test_device(), scene);
  const Bvh bvh(*test_device(), scene, buffers);
  const PointInterior interior(*test_device(), scheduler, buffers, bvh, {}, "test", "");
  std::vector<InteriorPoint> points;  // more than walk at a time
  std::vector<uint8_t> known;
  for (uint32_t i = 0; i < 150000; ++i) {
    const float u = std::fmod(0.618034f * static_cast<float>(i % 4096), 1.f);
    points.push_back({i % 2, u, (1 - u) * static_cast<float>(i % 101) / 101});
    known.push_back(i % 7 == 0);
  }
  const std::vector<bool> all = interior.are_open(points, known, kOwn, 8, {});
  constexpr size_t few = 3000;
  const std::vector<bool> first =
      interior.are_open(std::span(points).first(few), std::span(known).first(few), kOwn, 8, {});
  CHECK(std::equal(first.begin(), first.end(), all.begin()));
  const auto open = static_cast<double>(std::count(first.begin(), first.end(), true));
  CHECK(open > 0.3 * few);
  CHECK(open < 0.95 * few);
  // The same places of the floor throughout, so that about as many are open.
  CHECK(static_cast<double>(std::count(all.end() - few, all.end(), true)) == test::relative(open, 0.1));
}

TEST_CASE("texels count the part of their area that is not inside solids") {
  // 16 columns, each in a plinth: 0.2 m of it lies within, and the plinth's top goes on below it.
  Scene scene;
  add_lambert(scene, "white", glm::vec3(0.5f));
  for (int axis = 0; axis < 3; ++axis)
    for (int side = 0; side < 2; ++side)
      add_instance(scene,
                   add_mesh(scene, MeshBuilder("wall").box_face({0, -0.4f, 0}, {1, 1, 1}, axis, side, true).take()), 0);
  for (int i = 0; i < 16; ++i) {
    const glm::vec3 low(0.12f + 0.22f * static_cast<float>(i / 4), -0.2f, 0.1f + 0.22f * static_cast<float>(i % 4));
    add_box(scene, low, low + glm::vec3(0.09f, 0.6f, 0.07f));
    add_box(scene, low - glm::vec3(0.04f, 0.1f, 0.04f), low + glm::vec3(0.13f, 0.2f, 0.11f));
  }
  const double expected = 16 * (0.2 * 2 * (0.09 + 0.07) + 2 * 0.09 * 0.07);
  KernelScheduler scheduler(test_device());
  const SceneBuffers buffers(*test_device(), scene);
  const Bvh bvh(*test_device(), scene, buffers);
  SurfaceAtlasOptions options;
  options.texel_count = 1500;
  options.samples = 8;
  const SurfaceAtlas atlas(*test_device(), scheduler, scene, buffers, options, "test");
  const std::vector<AtlasTexel> texels = atlas.texels().download();
  for (const uint32_t steps : {1u, 6u}) {  // nothing here lies in two solids
    CAPTURE(steps);
    TexelInterior interior(*test_device(), scheduler, buffers, bvh, atlas, "test", "", {.steps = steps});
    while (!interior.complete()) REQUIRE(interior.advance());
    const std::vector<float2> shares = interior.shares().download();
    const std::vector<uint32_t> hidden = interior.hidden().download();
    double area = 0;
    for (size_t side = 0; side < shares.size(); ++side) {
      area += static_cast<double>(texels[side].area * (1 - shares[side].x));
      CHECK(std::popcount(hidden[side]) == std::lround(8 * (1 - shares[side].x)));
      if (hidden[side] == 0) CHECK(shares[side].y == 1.f);
      CHECK(shares[side].y >= 0.f);
      CHECK(shares[side].y <= 1.f);
    }
    CHECK(area == test::relative(expected, 0.03));
  }
}
