// SPDX-License-Identifier: Apache-2.0
// Which triangles parity searches: closed components, whatever their material.
#include <doctest/doctest.h>

#include "../../framework/services/layered_raster/scene.h"
#include "abuffer_rig.h"
#include "closed_bodies.h"
#include "lucarium/scene/builtin/scenes.h"
#include "test_support.h"

using namespace lucarium;
using namespace lucarium::test;
using abuffer::classify;
using abuffer::Intersect;

TEST_CASE("classes: MASK, BLEND and double-sided closed components stay in parity") {
  const Soup bodies = closed_bodies();
  for (const AlphaMode mode : {AlphaMode::opaque, AlphaMode::mask, AlphaMode::blend})
    for (const bool double_sided : {false, true}) {
      SceneMaterial material = veil(0.5f, mode);
      material.double_sided = double_sided;
      const auto classes = classify(scene_of(bodies, material), Intersect::automatic);
      CHECK(classes.parity_triangles == bodies.triangles.size());
      CHECK(classes.exact_triangles == 0);
      CHECK(classes.open_components == 0);
      AbufferRig rig(scene_of(bodies, material));
      const auto abuffer = rig.make({.abuffer_size = 256});
      const auto& s = abuffer.statistics();
      CHECK(s.parity_triangles == bodies.triangles.size());
      CHECK(s.unbalanced_columns == 0);
    }
}

TEST_CASE("classes: a component is open as soon as one triangle is missing or turned, and takes no other along") {
  Soup soup = sphere({}, 1, 20);
  const size_t ball = soup.triangles.size();
  append(soup, box({2, 2, 2}, {3, 3, 3}));
  for (const bool turned : {false, true}) {
    Soup broken = soup;
    if (turned)
      std::swap(broken.triangles[7].v0, broken.triangles[7].v1);
    else
      broken.triangles.erase(broken.triangles.begin() + 7);
    const auto classes = classify(scene_of(broken), Intersect::automatic);
    CHECK(classes.open_components == 1);
    CHECK(classes.parity_triangles == 12);
    CHECK(classes.exact_triangles == ball - (turned ? 0 : 1));
  }
}

TEST_CASE("classes: where 2 % of triangles are missing columns do not balance, and auto has the hits of exact search") {
  Soup soup = closed_bodies();
  Random random(12);
  std::erase_if(soup.triangles, [&](const Triangle&) { return random.uniform() < 0.02f; });
  AbufferRig rig(scene_of(soup));
  const abuffer::VoxelAbuffer automatic = rig.make({.abuffer_size = 400});
  const abuffer::VoxelAbuffer exact = rig.make({.abuffer_size = 400, .intersect = Intersect::exact});
  CHECK(automatic.statistics().parity_triangles == 0);
  const TestRays rays = scene_rays(rig, 20000, 5);
  const AbufferRig::Results a = rig.trace(automatic, rays.rays, rays.ends), b = rig.trace(exact, rays.rays);
  CHECK(std::memcmp(a.hits.data(), b.hits.data(), a.hits.size() * sizeof(Hit)) == 0);
  CHECK(a.occluded == b.occluded);
}

TEST_CASE("classes: components of the built-in scenes made for it are closed") {
  for (const char* name : {"solids", "debris"}) {
    CAPTURE(std::string(name));
    const Scene scene = make_builtin_scene(name);
    const auto classes = classify(scene, Intersect::automatic);
    MESSAGE(classes.open_components, " open components, ", classes.exact_triangles, " of ", scene.triangle_count());
    CHECK(classes.exact_triangles < scene.triangle_count() / 100);
  }
}
