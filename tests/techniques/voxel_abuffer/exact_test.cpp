// SPDX-License-Identifier: Apache-2.0
// Exact search: the hits of the hierarchy, to the bit.
#include <doctest/doctest.h>

#include <cstring>

#include "../../framework/services/layered_raster/scene.h"
#include "abuffer_rig.h"
#include "lucarium/scene/builtin/scenes.h"
#include "test_support.h"

using namespace lucarium;
using namespace lucarium::test;
using abuffer::Intersect;
using abuffer::VoxelAbuffer;

namespace {

struct Differences {
  uint32_t hits = 0, occluded = 0, hit_rays = 0;
};

Differences compare(AbufferRig& rig, const VoxelAbuffer& structure, const std::vector<Ray>& rays) {
  const Bvh bvh(rig.scheduler.device(), rig.scene, rig.buffers);
  const AbufferRig::Results expected = rig.trace(bvh, rays), found = rig.trace(structure, rays);
  Differences d;
  for (size_t i = 0; i < rays.size(); ++i) {
    const bool differs = std::memcmp(&expected.hits[i], &found.hits[i], sizeof(Hit)) != 0;
    d.hits += differs;
    if (differs && d.hits < 5) {
      const Hit &a = expected.hits[i], &b = found.hits[i];
      MESSAGE("ray ", i, " from ", rays[i].origin.x, " ", rays[i].origin.y, " ", rays[i].origin.z, " along ",
              rays[i].direction.x, " ", rays[i].direction.y, " ", rays[i].direction.z, ": ", a.triangle, " at ",
              a.distance, " ", a.u, " ", a.v, ", found ", b.triangle, " at ", b.distance, " ", b.u, " ", b.v);
    }
    d.occluded += expected.occluded[i] != found.occluded[i];
    d.hit_rays += expected.hits[i].triangle != LUCARIUM_NO_HIT;
  }
  return d;
}

}  // namespace

TEST_CASE("exact hits are those of the hierarchy, to the bit: built-in scenes") {
  const uint32_t count = full_run() ? 1000000 : 20000;
  for (const std::string& name : builtin_scene_names()) {
    if (!full_run() && name != "cornell" && name != "atrium" && name != "spheres") continue;
    CAPTURE(name);
    AbufferRig rig(make_builtin_scene(name));
    const VoxelAbuffer structure = rig.make({.abuffer_size = full_run() ? 1280u : 512u, .intersect = Intersect::exact});
    const Differences d = compare(rig, structure, scene_rays(rig, count, 7).rays);
    CHECK(d.hits == 0);
    CHECK(d.occluded == 0);
    CHECK(d.hit_rays > count / 4);
  }
}

TEST_CASE("exact hits are those of the hierarchy: unconnected triangles of all sizes, any grid") {
  for (const auto& [size, grid] : {std::pair{128u, 0u}, {300u, 16u}, {256u, 256u}, {1280u, 0u}, {1280u, 64u}}) {
    CAPTURE(size);
    CAPTURE(grid);
    AbufferRig rig(scene_of(random_soup(3000, size)));
    const VoxelAbuffer structure = rig.make({.abuffer_size = size, .grid_size = grid, .intersect = Intersect::exact});
    const Differences d = compare(rig, structure, scene_rays(rig, full_run() ? 300000 : 15000, size).rays);
    CHECK(d.hits == 0);
    CHECK(d.occluded == 0);
    CHECK(d.hit_rays > 1000);
  }
}
