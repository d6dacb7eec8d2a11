// SPDX-License-Identifier: Apache-2.0
// A structure of its own for what moves: the hits of one structure for all, and nothing that rests is built again.
#include "voxel_abuffer/moving/moving_set.h"

#include <doctest/doctest.h>

#include <cmath>

#include "../../framework/services/layered_raster/scene.h"
#include "abuffer_rig.h"
#include "lucarium/scene/builtin/scenes.h"
#include "test_support.h"
#include "voxel_abuffer/scene_structure.h"
#include "voxel_abuffer/structure/state.h"

using namespace lucarium;
using namespace lucarium::test;
using abuffer::Intersect;
using abuffer::MovingSet;
using abuffer::VoxelAbuffer;

namespace {

void follow(AbufferRig& rig, MovingSet& sets, const SceneChange& change) {
  rig.buffers.update(rig.scene, change);
  sets.update(rig.scene, change);
}

}  // namespace

TEST_CASE("two sets: over frames of animations exact hits are those of one set, and what rests is built once") {
  for (const int animation : {0, 1}) {  // rigid, morph
    CAPTURE(animation);
    Scene scene = make_builtin_scene("solids");
    evaluate(scene, 0, animation);
    AbufferRig rig(std::move(scene));
    const abuffer::VoxelAbufferOptions options{.abuffer_size = 400, .intersect = Intersect::exact};
    MovingSet sets(rig.scheduler, rig.scene, rig.buffers, options);
    CHECK(sets.moving().statistics().exact_triangles > 1000);
    CHECK(sets.resting().statistics().exact_triangles > 1000);
    uint64_t builds = 1;
    for (const double time : {0.0, 0.7, 1.9}) {
      CAPTURE(time);
      if (time > 0) follow(rig, sets, evaluate(rig.scene, time, animation)), ++builds;
      const std::vector<Ray> rays = scene_rays(rig, 12000, 4).rays;
      CHECK(differences(rig.trace(rig.make(options), rays), rig.trace(sets, rays)) == 0);
      CHECK(sets.resting().statistics().builds == 1);
      CHECK(sets.moving().statistics().builds == builds);
    }
    // Its grid covers its own bounds, with pixels that are no smaller.
    const AbufferGrid &all = sets.resting().state().grid, &part = sets.moving().state().grid;
    CHECK(part.center.w >= all.center.w);
    CHECK(part.voxels.x * part.voxels.y * part.voxels.z < all.voxels.x * all.voxels.y * all.voxels.z);
  }
}

TEST_CASE("two sets: a frame of an animation has the hits of a fresh start there, with parity, too") {
  Scene scene = make_builtin_scene("solids");
  evaluate(scene, 0, 0);
  AbufferRig rig(std::move(scene));
  const abuffer::VoxelAbufferOptions options{.abuffer_size = 640, .intersect = Intersect::automatic};
  MovingSet sets(rig.scheduler, rig.scene, rig.buffers, options);
  follow(rig, sets, evaluate(rig.scene, 0.4, 0));
  follow(rig, sets, evaluate(rig.scene, 1.3, 0));
  const TestRays rays = scene_rays(rig, 15000, 6);
  const AbufferRig::Results followed = rig.trace(sets, rays.rays, rays.ends);
  const MovingSet fresh(rig.scheduler, rig.scene, rig.buffers, options);
  CHECK(differences(followed, rig.trace(fresh, rays.rays, rays.ends)) == 0);
  const Bvh bvh(rig.scheduler.device(), rig.scene, rig.buffers);
  const AbufferRig::Results right = rig.trace(bvh, rays.rays);
  const AbufferRig::Results one = rig.trace(rig.make(options), rays.rays, rays.ends);
  uint32_t wrong = 0, wrong_of_one = 0;
  for (size_t i = 0; i < rays.rays.size(); ++i) {
    const bool hit = right.hits[i].triangle != LUCARIUM_NO_HIT;
    wrong += hit != (followed.hits[i].triangle != LUCARIUM_NO_HIT);
    wrong_of_one += hit != (one.hits[i].triangle != LUCARIUM_NO_HIT);
  }
  MESSAGE(wrong, " wrong, of one set ", wrong_of_one);
  CHECK(wrong <= wrong_of_one + rays.rays.size() / 500);
}

TEST_CASE("two sets: what rests is built again when it moves after all; either may be empty") {
  for (const bool animated : {true, false}) {
    CAPTURE(animated);
    AbufferRig rig(animated ? make_builtin_scene("solids") : make_builtin_scene("cornell"));
    const abuffer::VoxelAbufferOptions options{.abuffer_size = 256, .intersect = Intersect::exact};
    MovingSet sets(rig.scheduler, rig.scene, rig.buffers, options);
    const std::vector<bool> moving = abuffer::moving_instances(rig.scene).instances;
    const auto resting = static_cast<int>(std::find(moving.begin(), moving.end(), false) - moving.begin());
    SceneChange change;
    change.moved_instances = {resting};
    change.previous_world_from_object = {rig.scene.instances[resting].world_from_object};
    rig.scene.instances[resting].world_from_object[3].x += 0.3f;
    follow(rig, sets, change);
    CHECK(sets.resting().statistics().builds == 2);
    const std::vector<Ray> rays = scene_rays(rig, 6000, 4).rays;
    CHECK(differences(rig.trace(rig.make(options), rays), rig.trace(sets, rays)) == 0);
    if (!animated) CHECK(sets.moving().statistics().exact_triangles == 0);
  }
}

TEST_CASE("two sets: the memory of both is stated") {
  Scene scene = make_builtin_scene("solids");
  AbufferRig rig(std::move(scene));
  abuffer::AbufferParameters parameters;
  parameters.abuffer_size = 640;
  parameters.static_set = true;
  const auto stated = static_cast<double>(abuffer::SceneStructure::estimate_bytes(rig.scene, parameters));
  const MovingSet sets(rig.scheduler, rig.scene, rig.buffers, abuffer::abuffer_options(parameters));
  const auto found = static_cast<double>(sets.statistics().bytes);
  MESSAGE("stated ", stated, ", found ", found);
  CHECK(stated >= found);  // the raster's own memory is in it, too
  CHECK(stated <= 6 * found);
}
