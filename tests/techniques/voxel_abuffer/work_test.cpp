// SPDX-License-Identifier: Apache-2.0
// What count_work counts: lengths of lists and the steps of rays; and what a profile shows of a build.
#include <doctest/doctest.h>

#include <cmath>
#include <set>

#include "../../framework/services/layered_raster/scene.h"
#include "abuffer_rig.h"
#include "closed_bodies.h"
#include "test_support.h"
#include "voxel_abuffer/moving/moving_set.h"
#include "voxel_abuffer/structure/state.h"

using namespace lucarium;
using namespace lucarium::test;
using abuffer::AbufferWork;
using abuffer::Intersect;
using abuffer::Search;
using abuffer::VoxelAbuffer;
using abuffer::VoxelAbufferOptions;

namespace {

/// From one side of a plate across z = 0 to the other, across all of its square of edge 2.
std::vector<Ray> rays_across(uint32_t count) {
  Random random(2);
  std::vector<Ray> rays;
  for (uint32_t i = 0; i < count; ++i) {
    const glm::vec3 to(random.uniform(-0.9f, 0.9f), random.uniform(-0.9f, 0.9f), 0);
    const glm::vec3 from = to + glm::vec3(random.uniform(-1, 1), random.uniform(-1, 1), 3);
    rays.push_back(make_ray(from, glm::normalize(to - from)));
  }
  return rays;
}

/// Longest list and number of columns with any, from the start tables.
struct Lists {
  uint32_t longest = 0, filled = 0;
  void add(const VoxelAbuffer& structure, const std::optional<abuffer::AbufferLists>& lists) {
    if (!lists) return;
    const std::vector<uint32_t> start = lists->start().download();
    const AbufferGrid& grid = structure.state().grid;
    const uint32_t edge = grid.voxels.w, all = grid.voxels.x * grid.voxels.y * grid.voxels.z;
    for (const uint32_t k : {0u, 1u, 2u}) {
      const uint32_t along = k == 0 ? grid.voxels.x : k == 1 ? grid.voxels.y : grid.voxels.z;
      const uint32_t first = k * grid.bricks.w, columns = all / along * edge * edge;
      for (uint32_t i = first; i < first + columns; ++i) {
        longest = std::max(longest, start[i + 1] - start[i]);
        filled += start[i + 1] > start[i];
      }
    }
  }
};

}  // namespace

TEST_CASE("work: lengths of lists are those of the start tables, and 2 per slab along their normal") {
  Soup soup;
  for (int i = 0; i < 40; ++i) {
    const float z = 0.1f * static_cast<float>(i);
    append(soup, box({-1, -1, z}, {1, 1, z + 0.03f}));
  }
  append(soup, random_soup(200, 6, 1));  // open: exact
  AbufferRig rig(scene_of(soup));
  const VoxelAbuffer structure = rig.make({.abuffer_size = 400, .count_work = true});
  const auto& s = structure.statistics();
  Lists lists;
  lists.add(structure, structure.state().exact);
  lists.add(structure, structure.state().parity);
  CHECK(s.longest_list == lists.longest);
  CHECK(s.longest_list >= 80);
  CHECK(s.longest_list <= 90);
  CHECK(s.filled_columns == lists.filled);
  CHECK(rig.make({.abuffer_size = 400}).statistics().longest_list == 0);
}

TEST_CASE("work: a ray through one triangle is one search and one triangle test") {
  Soup soup;
  soup.add_triangle({-4, -4, 0}, {4, -4, 0}, {0, 4, 0});
  AbufferRig rig(scene_of(soup));
  std::vector<Ray> rays = rays_across(3000);
  const VoxelAbuffer structure = rig.make({.abuffer_size = 256, .intersect = Intersect::exact, .count_work = true});
  rig.trace(structure, rays);  // closest and any
  AbufferWork work = structure.work();
  CHECK(work.searches == 6000);
  CHECK(work.triangle_tests == 6000);
  CHECK(work.voxel_steps >= 6000);
  CHECK(work.column_steps >= 6000);
  CHECK(work.bisection_steps == 0);
  for (Ray& ray : rays) ray.direction.w = -1;  // inactive: no search
  rig.trace(structure, rays);
  CHECK(structure.work().searches == 6000);
}

TEST_CASE("work: bisection steps are those asked for, and any-hit rays need none") {
  AbufferRig rig(scene_of(box({-1, -1, -0.4f}, {1, 1, 0})));
  const std::vector<Ray> rays = rays_across(3000);
  const auto bisections = [&](Search search, uint32_t steps) {
    VoxelAbufferOptions options{.abuffer_size = 256, .search = search, .bisections = steps};
    options.count_work = true;
    const VoxelAbuffer structure = rig.make(options);
    rig.trace(structure, rays);
    const AbufferWork work = structure.work();
    CHECK(work.searches == 6000);
    // At most four points in every two of a voxel's eight slices.
    if (search == Search::three_steps) CHECK(work.column_steps <= 4 * 4 * work.voxel_steps);
    return work.bisection_steps;
  };
  CHECK(bisections(Search::columns, 10) == 0);
  for (const Search search : {Search::three_steps, Search::one_step}) {
    const uint64_t ten = bisections(search, 10);
    CHECK(ten > 15000);
    CHECK(ten <= 30000);  // once per closest ray
    CHECK(bisections(search, 5) * 2 == ten);
  }
}

TEST_CASE("work: voxels below eight pixels are searched by all columns") {
  AbufferRig rig(scene_of(box({-1, -1, -0.4f}, {1, 1, 0})));
  const std::vector<Ray> rays = rays_across(3000);
  for (const uint32_t voxels : {32u, 37u}) {
    CAPTURE(voxels);
    const auto work = [&](Search search) {
      const VoxelAbuffer structure =
          rig.make({.abuffer_size = 256, .grid_size = voxels, .search = search, .count_work = true});
      rig.trace(structure, rays);
      return structure.work();
    };
    const AbufferWork columns = work(Search::columns);
    for (const Search search : {Search::three_steps, Search::one_step}) {
      const AbufferWork points = work(search);
      CHECK((points.bisection_steps > 0) == (voxels == 32));
      CHECK((points.column_steps == columns.column_steps) == (voxels == 37));
    }
  }
}

TEST_CASE("work: starts are ambiguous on a plate thinner than a pixel, not on a thick one") {
  for (const float thickness : {0.004f, 0.5f}) {  // a pixel is 0.008 m
    CAPTURE(thickness);
    AbufferRig rig(scene_of(box({-1, -1, -thickness}, {1, 1, 0})));
    const VoxelAbuffer structure = rig.make({.abuffer_size = 256, .count_work = true});
    CHECK(structure.state().grid.center.w > 0.004f);
    std::vector<Ray> rays;
    std::vector<RayEnds> ends;
    Random random(3);
    for (uint32_t i = 0; i < 2000; ++i) {
      // Triangles 2 and 3 are the upper face.
      rays.push_back(make_ray({random.uniform(-0.9f, 0.9f), random.uniform(-0.9f, 0.9f), 1e-5f}, {0, 0, 1}));
      ends.push_back({rays.back().origin.x > rays.back().origin.y ? 3u : 2u, LUCARIUM_NONE});
    }
    rig.trace(structure, rays, ends);
    const AbufferWork work = structure.work();
    CHECK(work.searches == 4000);
    CHECK(work.ambiguous_starts == (thickness < 0.01f ? 4000 : 0));
    CHECK(work.facing_misses == 0);
  }
}

TEST_CASE("work: counting changes no hit, sums do not depend on threads, and both sets are counted") {
  Soup soup = closed_bodies();
  append(soup, random_soup(100, 6, 1));
  std::vector<AbufferWork> works;
  for (const int threads : {1, 2}) {
    AbufferRig rig(scene_of(soup), {.threads = threads});
    const TestRays rays = scene_rays(rig, 9000, 4);
    for (const Search search : {Search::columns, Search::three_steps}) {
      const VoxelAbufferOptions options{.abuffer_size = 256, .search = search};
      VoxelAbufferOptions counting = options;
      counting.count_work = true;
      const VoxelAbuffer counts = rig.make(counting), plain = rig.make(options);
      const AbufferRig::Results a = rig.trace(counts, rays.rays, rays.ends), b = rig.trace(plain, rays.rays, rays.ends);
      CHECK(std::memcmp(a.hits.data(), b.hits.data(), a.hits.size() * sizeof(Hit)) == 0);
      CHECK(a.occluded == b.occluded);
      CHECK(plain.work().searches == 0);
      works.push_back(counts.work());
      CHECK(works.back().searches > 20000);  // two each
    }
    const abuffer::MovingSet sets(rig.scheduler, rig.scene, rig.buffers, {.abuffer_size = 256, .count_work = true});
    rig.trace(sets, rays.rays, rays.ends);
    // Nothing moves, and columns are searched: as the first of these structures.
    CHECK(sets.work().searches == works[works.size() - 2].searches);
    CHECK(sets.work().column_steps > 100000);
  }
  for (size_t i = 0; i < 2; ++i) {
    const AbufferWork &a = works[i], &b = works[i + 2];
    CHECK(a.searches == b.searches);
    CHECK(a.voxel_steps == b.voxel_steps);
    CHECK(a.column_steps == b.column_steps);
    CHECK(a.bisection_steps == b.bisection_steps);
    CHECK(a.triangle_tests == b.triangle_tests);
    CHECK(a.ambiguous_starts == b.ambiguous_starts);
    CHECK(a.facing_misses == b.facing_misses);
  }
}

TEST_CASE("profile: every pass of a build is in it") {
  Soup soup = closed_bodies();
  append(soup, random_soup(50, 6, 1));
  AbufferRig rig(scene_of(soup));
  const VoxelAbuffer structure = rig.make({.abuffer_size = 256, .count_work = true});
  rig.scheduler.finish();
  std::set<std::string> found;
  for (const PassProfile& pass : rig.scheduler.profile().passes)
    if (pass.count > 0) found.insert(pass.name);
  for (const char* name :
       {"prepare_triangles",     "clear_voxels",     "clear_counts",  "clear_facing",  "exact_x.count.even_rows",
        "exact_y.fill.odd_rows", "exact_z.add_base", "parity_x.pack", "parity_y.pack", "parity_z.add_base",
        "mark_voxels",           "count_cells",      "mark_bricks",   "mark_empty",    "keep_cell_count",
        "mark_reaches",          "clear_cells",      "turn_cells",    "choose_axes",   "clear_marked",
        "check_columns",         "exact.measure",    "parity.measure"}) {
    CAPTURE(std::string(name));
    CHECK(found.count(name) == 1);
  }
}
