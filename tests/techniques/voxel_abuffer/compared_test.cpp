// SPDX-License-Identifier: Apache-2.0
// Structures to compare with: a grid's hits are those of the hierarchy; voxels and octrees miss them by their voxels.
#include <doctest/doctest.h>

#include <algorithm>
#include <memory>

#include "../../framework/services/layered_raster/scene.h"
#include "compared_rig.h"
#include "lucarium/base/error.h"
#include "lucarium/scene/builtin/scenes.h"
#include "lucarium/scene/load/load_scene.h"
#include "test_support.h"
#include "voxel_abuffer/compared/sparse_octree.h"
#include "voxel_abuffer/compared/triangle_grid.h"
#include "voxel_abuffer/compared/voxel_bits.h"

using namespace lucarium;
using namespace lucarium::test;
using abuffer::ComparedStructure;
using abuffer::SparseOctree;
using abuffer::TriangleGrid;
using abuffer::VoxelBits;

namespace {

std::vector<std::unique_ptr<ComparedStructure>> all_structures(AbufferRig& rig, uint32_t size) {
  std::vector<std::unique_ptr<ComparedStructure>> all;
  all.push_back(std::make_unique<TriangleGrid>(rig.scheduler, rig.buffers, size));
  all.push_back(std::make_unique<VoxelBits>(rig.scheduler, rig.buffers, size));
  all.push_back(std::make_unique<SparseOctree>(rig.scheduler, rig.buffers, size));
  return all;
}

/// All kinds of rays.
EndedRays mixed_rays(const AbufferRig& rig, uint32_t count, uint32_t seed) {
  EndedRays all = camera_rays(rig, count / 3, seed);
  for (const EndedRays& more : {bounce_rays(rig, count / 3, seed + 1), connections(rig, count / 3, seed + 2)})
    for (size_t i = 0; i < more.rays.size(); ++i) all.add(more.rays[i], more.ends[i]);
  return all;
}

}  // namespace

TEST_CASE("a grid's hits are those of the hierarchy, to the bit: built-in scenes") {
  for (const std::string& name : builtin_scene_names()) {
    if (!full_run() && name != "cornell" && name != "solids" && name != "spheres") continue;
    CAPTURE(name);
    AbufferRig rig(load_scene("builtin:" + name));
    const Bvh bvh(rig.scheduler.device(), rig.scene, rig.buffers);
    const TriangleGrid grid(rig.scheduler, rig.buffers);
    const EndedRays rays = mixed_rays(rig, full_run() ? 1'000'000 : 20'000, 3);
    CHECK(differences(trace(rig, bvh, rays), trace(rig, grid, rays)) == 0);
  }
}

TEST_CASE("a grid's hits are those of the hierarchy: unconnected triangles of all sizes, any grid") {
  for (const auto& [size, voxels] : {std::pair{128u, 0u}, {300u, 16u}, {256u, 256u}, {1280u, 0u}}) {
    CAPTURE(size);
    CAPTURE(voxels);
    AbufferRig rig(scene_of(random_soup(3000, size)));
    const Bvh bvh(rig.scheduler.device(), rig.scene, rig.buffers);
    const TriangleGrid grid(rig.scheduler, rig.buffers, size, voxels);
    const EndedRays rays = bounce_rays(rig, full_run() ? 300'000 : 15'000, size);
    CHECK(differences(trace(rig, bvh, rays), trace(rig, grid, rays)) == 0);
  }
}

TEST_CASE("a grid's hits are those of the hierarchy where MASK and BLEND let rays pass") {
  for (const AlphaMode mode : {AlphaMode::mask, AlphaMode::blend}) {
    const SceneMaterial material = veil(mode == AlphaMode::mask ? 0.4f : 0.3f, mode);
    AbufferRig rig(scene_of(rough_sphere(12, 16, 5), material));
    const Bvh bvh(rig.scheduler.device(), rig.scene, rig.buffers);
    const TriangleGrid grid(rig.scheduler, rig.buffers, 256);
    const EndedRays rays = bounce_rays(rig, 20'000, 5);
    const AbufferRig::Results expected = trace(rig, bvh, rays);
    CHECK(differences(expected, trace(rig, grid, rays)) == 0);
    CHECK((std::count(expected.occluded.begin(), expected.occluded.end(), 1u) > 0) == (mode == AlphaMode::blend));
  }
}

TEST_CASE("structures to compare with: the same bits with one and with two threads") {
  std::vector<AbufferRig::Results> first;
  for (const int threads : {1, 2}) {
    AbufferRig rig(load_scene("builtin:solids"), {.threads = threads});
    const EndedRays rays = mixed_rays(rig, 12'000, 9);
    size_t i = 0;
    for (const auto& structure : all_structures(rig, 256)) {
      CAPTURE(structure->name());
      if (threads == 1)
        first.push_back(trace(rig, *structure, rays));
      else
        CHECK(differences(first[i++], trace(rig, *structure, rays)) == 0);
    }
  }
}

TEST_CASE("structures to compare with follow motions and deformations: the same bits as new ones") {
  for (const int animation : {0, 1}) {
    AbufferRig rig(load_scene("builtin:solids"));
    const auto followed = all_structures(rig, 200);
    const SceneChange change = evaluate(rig.scene, 1.3, animation);
    rig.buffers.update(rig.scene, change);
    const EndedRays rays = mixed_rays(rig, 9000, 2);
    const auto made = all_structures(rig, 200);
    for (size_t i = 0; i < made.size(); ++i) {
      CAPTURE(made[i]->name());
      CHECK(followed[i]->statistics().builds == 1);
      followed[i]->update(change);
      CHECK(followed[i]->statistics().builds == 2);
      CHECK(differences(trace(rig, *followed[i], rays), trace(rig, *made[i], rays)) == 0);
      SceneChange camera;
      camera.camera = true;
      followed[i]->update(camera);
      CHECK(followed[i]->statistics().builds == 2);
    }
  }
}

TEST_CASE("structures to compare with: small, flat, tiny, large and far scenes, and rays that are none") {
  const auto triangle = [](float size, const glm::vec3& at) {
    Soup soup;
    soup.add_triangle(at, at + size * glm::vec3(1, 0.1f, 0), at + size * glm::vec3(0.2f, 0.9f, 0.4f));
    return soup;
  };
  Soup flat;
  flat.add_triangle({0, 0, 0}, {1, 0, 0}, {0, 0, 1});
  flat.add_triangle({1, 0, 0}, {1, 0, 1}, {0, 0, 1});
  Soup broken = triangle(1, glm::vec3(0));
  broken.add_triangle({NAN, 0, 0}, {1, 0, 0}, {0, 1, 0});
  broken.add_triangle({0.5f, 0.2f, 0}, {0.5f, 0.2f, 0}, {0.5f, 0.2f, 0});
  const std::vector<std::pair<const char*, Soup>> soups = {
      {"single", triangle(1, glm::vec3(0))},   {"flat", flat},
      {"tiny", triangle(1e-3f, glm::vec3(0))}, {"large", triangle(1e3f, glm::vec3(0))},
      {"far", triangle(1, {1000, -300, 500})}, {"broken", broken}};
  for (const auto& [name, soup] : soups) {
    CAPTURE(name);
    AbufferRig rig(scene_of(soup));
    const glm::vec3 a = soup.corner(0), b = soup.corner(1), c = soup.corner(2);
    const glm::vec3 n = glm::normalize(glm::cross(b - a, c - a)), middle = (a + b + c) / 3.f;
    const float size = glm::length(b - a);
    EndedRays rays;
    const RayEnds open{LUCARIUM_NONE, LUCARIUM_NONE};
    Random random(4);
    for (int i = 0; i < 300; ++i) {
      const glm::vec3 target = middle + 0.2f * size * random.in_cube(1) * glm::vec3(1, 0, 1);
      const glm::vec3 eye = middle + size * (2.f * n + random.in_cube(0.5f));
      rays.add(make_ray(eye, glm::normalize(target - eye)), open);
    }
    const size_t good = rays.rays.size();
    rays.add(make_ray(middle + n, -n, -1), open);  // inactive
    rays.add(make_ray({NAN, 0, 0}, -n), open);
    rays.add(make_ray(middle + n, {0, NAN, 0}), open);
    rays.add(make_ray(middle + n, glm::vec3(0)), open);
    rays.add(make_ray(middle + size * n, n), open);  // away
    const Bvh bvh(rig.scheduler.device(), rig.scene, rig.buffers);
    const AbufferRig::Results expected = trace(rig, bvh, rays);
    for (const auto& structure : all_structures(rig, 128)) {
      CAPTURE(structure->name());
      const AbufferRig::Results found = trace(rig, *structure, rays);
      if (structure->name() == "grid") CHECK(differences(expected, found) == 0);
      size_t lost = 0, stopped = 0;
      for (size_t i = 0; i < rays.rays.size(); ++i) {
        const bool hit = found.hits[i].triangle != LUCARIUM_NO_HIT;
        CHECK(hit == (found.occluded[i] == 1));
        if (i >= good) stopped += hit;
        lost += expected.hits[i].triangle != LUCARIUM_NO_HIT &&
                !(std::abs(found.hits[i].distance - expected.hits[i].distance) < 0.1f * size);
      }
      CHECK(lost == 0);
      CHECK(stopped == 0);
    }
  }
}

TEST_CASE("structures to compare with over nothing") {
  AbufferRig rig(scene_of(Soup{}));
  EndedRays rays;
  rays.add(make_ray({0, 0, 0}, {1, 0, 0}), {LUCARIUM_NONE, LUCARIUM_NONE});
  for (const auto& structure : all_structures(rig, 128)) {
    CAPTURE(structure->name());
    const AbufferRig::Results found = trace(rig, *structure, rays);
    CHECK(found.hits[0].triangle == LUCARIUM_NO_HIT);
    CHECK(found.occluded[0] == 0);
  }
}

TEST_CASE("structures to compare with are refused where memory does not suffice: the parameter is named") {
  AbufferRig rig(scene_of(rough_sphere(20, 30, 5)), {.memory_limit_bytes = 8 << 20});
  const auto voxels = [&] { VoxelBits(rig.scheduler, rig.buffers, 1024); };
  const auto octree = [&] { SparseOctree(rig.scheduler, rig.buffers, 2048); };
  const auto grid = [&] { TriangleGrid(rig.scheduler, rig.buffers, 2048, 1024); };
  CHECK_THROWS_WITH_AS(voxels(), doctest::Contains("lower abuffer_size"), Error);
  CHECK_THROWS_WITH_AS(octree(), doctest::Contains("lower abuffer_size"), Error);
  CHECK_THROWS_WITH_AS(grid(), doctest::Contains("lower grid_size"), Error);
}
