// SPDX-License-Identifier: Apache-2.0
// Rays that leave and reach surfaces under parity: the state that they begin with, hits of their own surface,
// connections with lights.
#include <doctest/doctest.h>

#include <array>
#include <cmath>

#include "../../framework/services/layered_raster/scene.h"
#include "closed_bodies.h"
#include "compared_rig.h"
#include "lucarium/compute/program/source_library.h"
#include "test_support.h"
#include "voxel_abuffer/structure/state.h"

using namespace lucarium;
using namespace lucarium::test;
using abuffer::Search;
using abuffer::VoxelAbuffer;

const lucarium::EmbeddedSources& test_voxel_abuffer_kernels();
const lucarium::EmbeddedSources& voxel_abuffer_kernels();

namespace {

std::vector<int> start_states(AbufferRig& rig, const VoxelAbuffer& structure, const EndedRays& batch) {
  SourceLibrary library;
  library.add(test_voxel_abuffer_kernels());
  library.add(voxel_abuffer_kernels());
  const Program program(rig.scheduler.device(), library,
                        {.name = "start_states",
                         .files = {"test_voxel_abuffer/start_states.cl"},
                         .defines = {{"ABUFFER_WITH_PARITY", ""}}});
  const auto count = static_cast<uint32_t>(batch.rays.size());
  const TypedBuffer<Ray> rays(rig.scheduler.device(), "test", "rays", batch.rays);
  const TypedBuffer<RayEnds> ends(rig.scheduler.device(), "test", "ends", batch.ends);
  const TypedBuffer<int> states(rig.scheduler.device(), "test", "states", count);
  const VoxelAbuffer::State& s = structure.state();
  ScheduleRecorder recorder = rig.scheduler.record("states", "test");
  recorder.pass("states", program, "start_states")
      .global(count)
      .arg("abuffer_grid", s.grid_buffer)
      .arg("abuffer_triangles", s.triangles)
      .arg("abuffer_classes", s.triangle_classes)
      .arg("abuffer_parity_start", s.parity->start())
      .arg("abuffer_parity_depths", s.parity->depths())
      .arg("abuffer_parity_fragments", s.parity->fragments())
      .arg("rays", rays)
      .arg("ends", ends)
      .arg("offset", structure.options().offset)
      .arg("count", count)
      .arg("states", states);
  Schedule schedule = recorder.compile();
  rig.scheduler.run(schedule);
  rig.scheduler.finish();
  return states.download();
}

}  // namespace

TEST_CASE("starts: rays begin with the number of solids around them, on both sides of surfaces") {
  Soup soup = torus();
  const auto torus_end = static_cast<uint32_t>(soup.triangles.size());
  append(soup, sphere({0.9f, 0.2f, 0.1f}, 0.7f));
  const auto ball_end = static_cast<uint32_t>(soup.triangles.size());
  append(soup, box({-0.3f, -0.9f, -0.5f}, {1.1f, 0.3f, 0.8f}));
  AbufferRig rig(scene_of(soup));
  const VoxelAbuffer structure = rig.make();
  const float h = structure.state().grid.center.w;
  const EndedRays batch = bounce_rays(rig, full_run() ? 1000000 : 60000, 5);
  const std::vector<int> found = start_states(rig, structure, batch);
  std::array<uint32_t, 2> tested{}, wrong{};  // from fronts, from backs
  for (size_t i = 0; i < found.size(); ++i) {
    const glm::vec3 p = batch.rays[i].origin.xyz();
    // Signed distances to the smooth bodies; their facets lie up to 2e-3 m inside.
    const float ring = std::hypot(std::hypot(p.x, p.z) - 1, p.y) - 0.4f;
    const float ball = glm::distance(p, glm::vec3(0.9f, 0.2f, 0.1f)) - 0.7f;
    const glm::vec3 q = glm::abs(p - glm::vec3(0.4f, -0.3f, 0.15f)) - glm::vec3(0.7f, 0.6f, 0.65f);
    const std::array distances{ring, ball, std::max({q.x, q.y, q.z})};
    const uint32_t end = batch.ends[i].start, triangle = end & ~LUCARIUM_RAY_END_BACK;
    const size_t own = triangle < torus_end ? 0 : triangle < ball_end ? 1 : 2;
    const bool back = end & LUCARIUM_RAY_END_BACK;
    int expected = back;
    bool near = false;
    for (size_t k = 0; k < 3; ++k) {
      if (k == own) continue;
      near = near || std::fabs(distances[k]) < 3 * h + 2e-3f;
      expected += distances[k] < 0;
    }
    if (near) continue;
    ++tested[back];
    wrong[back] += found[i] != expected;
  }
  MESSAGE(wrong[0], " of ", tested[0], " from fronts, ", wrong[1], " of ", tested[1], " from backs");
  for (const int back : {0, 1}) {
    CHECK(tested[back] > batch.rays.size() / 3);
    CHECK(static_cast<double>(wrong[back]) <= 1e-4 * tested[back]);
  }
}

TEST_CASE("starts: no ray that leaves a convex body meets it again") {
  Soup ellipsoid = sphere({}, 1, 60);
  for (Vertex& v : ellipsoid.vertices) {
    const glm::vec3 p = v.position.xyz() * glm::vec3(1, 0.6f, 0.8f);
    v.position = float4(p.x + 0.3f * p.y, p.y - 0.2f * p.z, p.z + 0.1f * p.x, 0);
  }
  const Soup thick = box({-1, -0.3f, -0.6f}, {1, 0.3f, 0.6f}), thin = box({-1, -1, 0}, {1, 1, 5e-4f});  // a third pixel
  for (const Soup& body : {ellipsoid, thick, thin}) {
    AbufferRig rig(scene_of(body));
    const EndedRays all = bounce_rays(rig, full_run() ? 1000000 : 60000, 7);
    EndedRays fronts;
    for (size_t i = 0; i < all.rays.size(); ++i)
      if (!(all.ends[i].start & LUCARIUM_RAY_END_BACK)) fronts.add(all.rays[i], all.ends[i]);
    for (const Search search : {Search::columns, Search::three_steps, Search::one_step}) {
      CAPTURE(static_cast<int>(search));
      const VoxelAbuffer structure = rig.make({.search = search});
      CHECK(structure.statistics().exact_triangles == 0);
      const AbufferRig::Results found = trace(rig, structure, fronts);
      uint32_t hits = 0, occluded = 0;
      for (size_t i = 0; i < fronts.rays.size(); ++i) {
        hits += found.hits[i].triangle != LUCARIUM_NO_HIT;
        occluded += found.occluded[i] != 0;
      }
      CHECK(hits == 0);
      CHECK(occluded == 0);
    }
  }
}

TEST_CASE("ends: connections between points of surfaces are free where the hierarchy says so") {
  AbufferRig rig(scene_of(closed_bodies()));
  const EndedRays batch = connections(rig, full_run() ? 1000000 : 60000, 9);
  const Bvh bvh(rig.scheduler.device(), rig.scene, rig.buffers);
  const std::vector<uint32_t> right = trace(rig, bvh, batch).occluded;
  for (const Search search : {Search::columns, Search::three_steps, Search::one_step}) {
    CAPTURE(static_cast<int>(search));
    const std::vector<uint32_t> found = trace(rig, rig.make({.search = search}), batch).occluded;
    uint32_t free = 0, wrong = 0;
    for (size_t i = 0; i < right.size(); ++i) {
      free += !right[i];
      wrong += (right[i] != 0) != (found[i] != 0);
    }
    MESSAGE(wrong, " of ", right.size(), " wrong, ", free, " free");
    CHECK(free > right.size() / 10);
    CHECK(static_cast<double>(wrong) <= 1.5e-3 * static_cast<double>(right.size()));
  }
}
