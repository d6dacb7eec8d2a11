// SPDX-License-Identifier: Apache-2.0
// What can go wrong: rays that are none, surfaces that let rays pass, extreme scenes, seams that open, memory.
#include <doctest/doctest.h>

#include <cmath>
#include <cstring>
#include <limits>

#include "../../framework/services/layered_raster/scene.h"
#include "abuffer_rig.h"
#include "closed_bodies.h"
#include "lucarium/base/error.h"
#include "lucarium/scene/builtin/scenes.h"
#include "test_support.h"
#include "voxel_abuffer/structure/state.h"

using namespace lucarium;
using namespace lucarium::test;
using abuffer::Intersect;
using abuffer::Search;
using abuffer::VoxelAbuffer;

namespace {

/// Closed squares of thickness 0.1 across the z axis at z = 0, 1, …
Soup slabs(uint32_t count) {
  Soup soup;
  for (uint32_t i = 0; i < count; ++i) {
    const auto z = static_cast<float>(i);
    append(soup, box({-2.03f, -1.97f, z + 0.013f}, {2.01f, 1.99f, z + 0.113f}));
  }
  return soup;
}

}  // namespace

TEST_CASE("inactive, zero, infinite and NaN rays miss; their neighbours are traced") {
  AbufferRig rig(scene_of(closed_bodies()));
  TestRays rays = scene_rays(rig, 4000, 3);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  for (size_t i = 0; i < rays.rays.size(); i += 2) {
    Ray& ray = rays.rays[i];
    switch (i / 2 % 6) {
      case 0: ray.direction.w = -1; break;
      case 1: ray.direction = float4(0, 0, 0, INFINITY); break;
      case 2: ray.origin.x = nan; break;
      case 3: ray.direction.y = nan; break;
      case 4: ray.origin.z = INFINITY; break;
      default: ray.direction.x = -INFINITY;
    }
  }
  for (const Intersect intersect : {Intersect::exact, Intersect::automatic}) {
    const VoxelAbuffer structure = rig.make({.abuffer_size = 256, .intersect = intersect});
    const AbufferRig::Results found = rig.trace(structure, rays.rays, rays.ends);
    uint32_t hits = 0, wrong = 0;
    for (size_t i = 0; i < rays.rays.size(); ++i) {
      const bool hit = found.hits[i].triangle != LUCARIUM_NO_HIT;
      if (i % 2) hits += hit;
      if (i % 2 == 0) wrong += hit || found.occluded[i] || !std::isinf(found.hits[i].distance);
    }
    CHECK(wrong == 0);
    CHECK(hits > 500);
  }
}

TEST_CASE("exact search decides MASK and BLEND as the hierarchy does") {
  for (const AlphaMode mode : {AlphaMode::blend, AlphaMode::mask}) {
    AbufferRig rig(scene_of(random_soup(2000, 5), veil(0.4f, mode)));
    const Bvh bvh(rig.scheduler.device(), rig.scene, rig.buffers);
    const VoxelAbuffer structure = rig.make({.abuffer_size = 300, .intersect = Intersect::exact});
    const std::vector<Ray> rays = scene_rays(rig, 12000, 5).rays;
    CHECK(differences(rig.trace(bvh, rays), rig.trace(structure, rays)) == 0);
  }
}

TEST_CASE("parity: where BLEND lets a ray pass, the state behind is the one to leave") {
  // Eight closed slabs of alpha a: a ray gets through all 16 surfaces with probability (1 - a)^16.
  const float alpha = 0.04f;
  AbufferRig rig(scene_of(slabs(8), veil(alpha)));
  for (const Search search : {Search::columns, Search::three_steps}) {
    CAPTURE(static_cast<int>(search));
    const VoxelAbuffer structure = rig.make({.abuffer_size = 1280, .search = search});
    CHECK(structure.statistics().exact_triangles == 0);
    std::vector<Ray> rays;
    Random random(6);
    for (uint32_t i = 0; i < 20000; ++i) {
      const glm::vec3 from(random.uniform(-1.5f, 1.5f), random.uniform(-1.5f, 1.5f), -1);
      const glm::vec3 to(random.uniform(-1.5f, 1.5f), random.uniform(-1.5f, 1.5f), 9);
      Ray ray = make_ray(from, glm::normalize(to - from));
      const uint32_t seed = i + 1;
      std::memcpy(&ray.origin.w, &seed, sizeof(seed));
      rays.push_back(ray);
    }
    const AbufferRig::Results found = rig.trace(structure, rays);
    double passed = 0, unoccluded = 0;
    for (size_t i = 0; i < rays.size(); ++i) {
      passed += found.hits[i].triangle == LUCARIUM_NO_HIT;
      unoccluded += !found.occluded[i];
    }
    const double p = std::pow(1 - static_cast<double>(alpha), 16), n = 20000;
    // Slabs are thinner than voxels: samples overlook some (one step: half of them).
    const double tolerance = 4 * std::sqrt(p * (1 - p) / n) + (search == Search::columns ? 0 : 0.01);
    CHECK(std::fabs(passed / n - p) <= tolerance);
    CHECK(std::fabs(unoccluded / n - p) <= tolerance);
  }
}

TEST_CASE("tiny, huge, far, flat and empty scenes are traced as by the hierarchy") {
  struct Extreme {
    const char* name;
    Soup soup;
  };
  Soup flat;
  flat.add_triangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  Soup line;
  line.add_triangle({0, 0, 0}, {1, 0, 0}, {2, 0, 0});
  for (const Extreme& e :
       {Extreme{"tiny", placed(closed_bodies(), 1e-3f, {})}, Extreme{"huge", placed(closed_bodies(), 1e3f, {})},
        Extreme{"far", placed(closed_bodies(), 1, {1000, -700, 300})}, Extreme{"flat", flat}, Extreme{"line", line},
        Extreme{"empty", {}}}) {
    CAPTURE(e.name);
    AbufferRig rig(scene_of(e.soup));
    const Bvh bvh(rig.scheduler.device(), rig.scene, rig.buffers);
    const VoxelAbuffer exact = rig.make({.abuffer_size = 256, .intersect = Intersect::exact});
    const TestRays rays = scene_rays(rig, 6000, 5);
    CHECK(differences(rig.trace(bvh, rays.rays), rig.trace(exact, rays.rays)) == 0);
    const VoxelAbuffer parity = rig.make({.abuffer_size = 256});
    CHECK(rig.trace(parity, rays.rays, rays.ends).hits.size() == rays.rays.size());
  }
}

TEST_CASE("open components are searched exactly beside closed ones") {
  Soup soup = closed_bodies();
  const auto closed = static_cast<uint32_t>(soup.triangles.size());
  append(soup, placed(random_soup(300, 8, 1), 1, {0, 0, 3}));
  AbufferRig rig(scene_of(soup));
  const VoxelAbuffer structure = rig.make({.abuffer_size = 640});
  CHECK(structure.statistics().parity_triangles == closed);
  CHECK(structure.statistics().exact_triangles == 300);
  CHECK(structure.statistics().open_components == 300);
  const TestRays rays = scene_rays(rig, 20000, 5);
  const Bvh bvh(rig.scheduler.device(), rig.scene, rig.buffers);
  const AbufferRig::Results right = rig.trace(bvh, rays.rays), found = rig.trace(structure, rays.rays, rays.ends);
  uint32_t open_hits = 0, wrong = 0, err = 0;
  for (size_t i = 0; i < rays.rays.size(); ++i) {
    err += (right.hits[i].triangle == LUCARIUM_NO_HIT) != (found.hits[i].triangle == LUCARIUM_NO_HIT);
    if (right.hits[i].triangle == LUCARIUM_NO_HIT || right.hits[i].triangle < closed) continue;
    ++open_hits;
    wrong += std::memcmp(&right.hits[i], &found.hits[i], sizeof(Hit)) != 0;
  }
  CHECK(open_hits > 500);
  CHECK(wrong <= open_hits / 200);
  CHECK(err <= 40);
}

TEST_CASE("components whose seams a deformation opened become exact, and parity again when they close") {
  // Every triangle has corners of its own: welded while their positions are equal.
  const Soup shared = closed_bodies();
  Soup split;
  for (const Triangle& t : shared.triangles)
    split.add_triangle(shared.corner(t.v0), shared.corner(t.v1), shared.corner(t.v2));
  Scene scene = scene_of(split);
  const auto rest = std::make_shared<const Mesh>(scene.meshes[0]);
  scene.instances[0].pose = rest;
  AbufferRig rig(std::move(scene));
  VoxelAbuffer structure = rig.make({.abuffer_size = 400});
  CHECK(structure.statistics().exact_triangles == 0);
  const auto follow = [&](std::shared_ptr<const Mesh> pose) {
    rig.scene.instances[0].pose = std::move(pose);
    SceneChange change;
    change.deformed_instances = {0};
    rig.buffers.update(rig.scene, change);
    structure.update(rig.scene, change);
  };
  auto open = std::make_shared<Mesh>(*rest);
  const size_t last = 3 * (shared.triangles.size() - 400);  // of the sphere
  for (size_t i = last; i < last + 30; ++i) open->positions[i] *= 1.2f;
  follow(open);
  CHECK(structure.statistics().unbalanced_columns > 0);
  CHECK(structure.statistics().moved_components == 1);
  CHECK(structure.statistics().exact_triangles > 20000);
  CHECK(structure.statistics().parity_triangles > 20000);
  const TestRays rays = scene_rays(rig, 9000, 5);
  const Bvh bvh(rig.scheduler.device(), rig.scene, rig.buffers);
  const AbufferRig::Results right = rig.trace(bvh, rays.rays), found = rig.trace(structure, rays.rays, rays.ends);
  uint32_t err = 0;
  for (size_t i = 0; i < rays.rays.size(); ++i)
    err += (right.hits[i].triangle == LUCARIUM_NO_HIT) != (found.hits[i].triangle == LUCARIUM_NO_HIT);
  CHECK(err <= 18);
  follow(rest);
  CHECK(structure.statistics().exact_triangles == 0);
  CHECK(structure.statistics().unbalanced_columns == 0);
}

TEST_CASE("what does not fit is refused, by name") {
  AbufferRig rig(scene_of(closed_bodies()));
  CHECK_THROWS_WITH_AS(rig.make({.abuffer_size = 300, .grid_size = 512}),
                       doctest::Contains("grid_size=512 exceeds abuffer_size=300"), Error);
  CHECK_THROWS_WITH_AS(rig.make({.abuffer_size = 4096, .grid_size = 2048}), doctest::Contains("lower grid_size"),
                       Error);
}
