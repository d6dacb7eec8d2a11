// SPDX-License-Identifier: Apache-2.0
// Which voxels are occupied: those that triangles touch, or only those that hold fragments (conservative_voxels=off).
#include <doctest/doctest.h>

#include <array>
#include <bit>
#include <cmath>
#include <cstdio>

#include "../../framework/services/layered_raster/scene.h"
#include "abuffer_rig.h"
#include "closed_bodies.h"
#include "test_support.h"
#include "voxel_abuffer/structure/grid_layout.h"
#include "voxel_abuffer/structure/inspect.h"
#include "voxel_abuffer/structure/state.h"

using namespace lucarium;
using namespace lucarium::test;
using abuffer::Intersect;
using abuffer::VoxelAbuffer;

namespace {

uint32_t voxel_index(const AbufferGrid& grid, const std::array<uint32_t, 3>& v) {
  const uint32_t brick = ((v[2] / 4) * grid.bricks.y + v[1] / 4) * grid.bricks.x + v[0] / 4;
  return 64 * brick + v[2] % 4 * 16 + v[1] % 4 * 4 + v[0] % 4;
}

/// Occupancy as the fragments of some lists say: a bit pattern per voxel.
void mark(const AbufferGrid& grid, const abuffer::AbufferLists& lists, bool exact, std::vector<uint32_t>& words) {
  const std::vector<uint32_t> start = lists.start().download(), depths = lists.depths().download();
  const std::array<uint32_t, 3> voxels = {grid.voxels.x, grid.voxels.y, grid.voxels.z};
  const uint32_t edge = grid.voxels.w;
  for (uint32_t k = 0; k < 3; ++k)
    for (uint32_t y = 0; y < voxels[(k + 2) % 3]; ++y)
      for (uint32_t x = 0; x < voxels[(k + 1) % 3]; ++x) {
        const uint32_t first = k * grid.bricks.w + (y * voxels[(k + 1) % 3] + x) * edge * edge;
        for (uint32_t i = start[first]; i < start[first + edge * edge]; ++i) {
          const uint32_t near = depths[i] & 0xffffu, far = 65535u - (depths[i] >> 16);
          const float depth = exact ? static_cast<float>(near + far) / 32 : std::bit_cast<float>(depths[i]);
          std::array<uint32_t, 3> v{};
          v[(k + 1) % 3] = x;
          v[(k + 2) % 3] = y;
          v[k] = std::min(static_cast<uint32_t>(std::max(depth / static_cast<float>(edge), 0.f)), voxels[k] - 1);
          words[voxel_index(grid, v)] |= exact ? ABUFFER_EXACT(k) : ABUFFER_PARITY;
        }
      }
}

/// What a structure says of cubes that hold nothing, beside what is counted: numbers of places and octants.
struct FreeCubes {
  int wrong = 0, large = 0;  ///< large: of an edge of 2 to 39
};

/// edge_of(place, octant): what is stated as the edge of the largest cube that begins with a place and grows towards an
/// octant, of places of which all are free. Outside the grid all is free.
template <class Free, class Stated>
FreeCubes compare_free_cubes(const uint4& size, Free&& is_free, Stated&& edge_of) {
  const std::array<int, 3> end = {static_cast<int>(size.x), static_cast<int>(size.y), static_cast<int>(size.z)};
  const auto free = [&](const std::array<int, 3>& at) {
    for (int k = 0; k < 3; ++k)
      if (at[k] < 0 || at[k] >= end[k]) return true;
    return static_cast<bool>(is_free(at));
  };
  FreeCubes found;
  for (int place = 0; place < end[0] * end[1] * end[2]; ++place)
    for (int octant = 0; octant < 8; ++octant) {
      const std::array<int, 3> at = {place % end[0], place / end[0] % end[1], place / end[0] / end[1]};
      const std::array<int, 3> side = {octant & 1 ? 1 : -1, octant & 2 ? 1 : -1, octant & 4 ? 1 : -1};
      const auto ahead = [&](int x, int y, int z) {
        return free({at[0] + side[0] * x, at[1] + side[1] * y, at[2] + side[2] * z});
      };
      int edge = 0;
      for (bool grows = true; grows && edge < 40;) {
        for (int i = 0; i <= edge && grows; ++i)
          for (int j = 0; j <= edge && grows; ++j) grows = ahead(edge, i, j) && ahead(i, edge, j) && ahead(i, j, edge);
        edge += grows;
      }
      const auto stated = static_cast<int>(edge_of(at, octant));
      found.wrong += edge < 40 ? stated != edge : stated < 40;
      found.large += edge > 1 && edge < 40;
    }
  return found;
}

}  // namespace

TEST_CASE("voxels: without conservative ones those that hold fragments are occupied, a few less") {
  Soup soup = closed_bodies();
  append(soup, random_soup(300, 6, 1));  // open: exact
  AbufferRig rig(scene_of(soup));
  abuffer::VoxelAbufferOptions options{.abuffer_size = 640, .intersect = Intersect::automatic};
  const VoxelAbuffer all = rig.make(options);
  options.conservative_voxels = false;
  const VoxelAbuffer some = rig.make(options);
  const std::vector<uint32_t> touched = all.state().voxels.download(), words = some.state().voxels.download();
  const std::vector<uint64_t> bricks = some.state().bricks.download();
  std::vector<uint32_t> expected(words.size(), 0);
  mark(some.state().grid, *some.state().exact, true, expected);
  mark(some.state().grid, *some.state().parity, false, expected);
  const glm::uvec4 size(some.state().grid.bricks.x, some.state().grid.bricks.y, some.state().grid.bricks.z, 64);
  const size_t inside = size_t{size.x} * size.y * size.z * size.w;  // the buffers may be larger
  uint32_t wrong = 0, more = 0, occupied = 0, missed = 0, unlike_bricks = 0;
  for (size_t i = 0; i < words.size(); ++i) {
    const uint32_t bits = words[i] & ABUFFER_OCCUPIED, triangles = touched[i] & ABUFFER_OCCUPIED;
    wrong += bits != expected[i];
    more += (bits & ~triangles & ABUFFER_PARITY) != 0;
    occupied += triangles != 0;
    missed += triangles != 0 && bits == 0;
    unlike_bricks += i < inside && (bricks[i / 64] >> (i % 64) & 1) != (bits != 0);
  }
  CHECK(wrong == 0);
  CHECK(more == 0);
  CHECK(unlike_bricks == 0);
  CHECK(occupied > 3000);
  CHECK(missed > occupied / 500);
  CHECK(missed < occupied / 10);
}

TEST_CASE("voxels: every empty brick knows the largest cube of empty bricks towards each octant") {
  AbufferRig rig(scene_of(random_soup(12, 6, 1)));
  const VoxelAbuffer structure = rig.make({.abuffer_size = 256, .grid_size = 64});
  const uint4 size = structure.state().grid.bricks;
  const std::vector<uint64_t> words = structure.state().bricks.download();
  const size_t count = abuffer::brick_count(structure.state().grid);
  REQUIRE(words.size() >= 2 * count);
  const auto index = [&](const std::array<int, 3>& at) {
    return static_cast<size_t>((at[2] * static_cast<int>(size.y) + at[1]) * static_cast<int>(size.x) + at[0]);
  };
  const FreeCubes found = compare_free_cubes(
      size, [&](const std::array<int, 3>& at) { return words[index(at)] == 0; },
      [&](const std::array<int, 3>& at, int octant) { return words[count + index(at)] >> (8 * octant) & 255; });
  CHECK(found.wrong == 0);
  CHECK(found.large > 100);
}

TEST_CASE("voxels: search by parity knows the largest cube without its triangles from each voxel towards each octant") {
  Soup soup = closed_bodies();
  append(soup, random_soup(12, 6, 1));  // open: exact
  AbufferRig rig(scene_of(soup));
  const VoxelAbuffer structure = rig.make({.abuffer_size = 256, .grid_size = 32});
  const AbufferGrid& grid = structure.state().grid;
  const std::vector<uint64_t> words = structure.state().bricks.download();
  const std::vector<uint32_t> voxels = structure.state().voxels.download();
  const size_t bricks = abuffer::brick_count(grid);
  REQUIRE(words.size() >= 66 * bricks);
  const auto index = [&](const std::array<int, 3>& at) {
    return static_cast<size_t>(
        voxel_index(grid, {static_cast<uint32_t>(at[0]), static_cast<uint32_t>(at[1]), static_cast<uint32_t>(at[2])}));
  };
  size_t exact_only = 0;
  for (const uint32_t word : voxels) exact_only += (word & ABUFFER_OCCUPIED) && !(word & ABUFFER_PARITY);
  CHECK(exact_only > 50);
  const FreeCubes found = compare_free_cubes(
      {4 * grid.bricks.x, 4 * grid.bricks.y, 4 * grid.bricks.z, 0},
      [&](const std::array<int, 3>& at) { return !(voxels[index(at)] & ABUFFER_PARITY); },
      [&](const std::array<int, 3>& at, int octant) {
        const size_t byte = 64 * bricks * static_cast<size_t>(octant) + index(at);
        return words[2 * bricks + byte / 8] >> (8 * (byte % 8)) & 255;
      });
  CHECK(found.wrong == 0);
  CHECK(found.large > 1000);
}

TEST_CASE("voxels: parity finds the same in grids whose voxels are too many for free cubes of their own") {
  AbufferRig rig(scene_of(closed_bodies()));
  const TestRays rays = scene_rays(rig, 10000, 4);
  const Bvh bvh(rig.scheduler.device(), rig.scene, rig.buffers);
  const AbufferRig::Results right = rig.trace(bvh, rays.rays, rays.ends);
  std::vector<size_t> all_wrong;
  for (const uint32_t voxels : {64u, 128u}) {
    CAPTURE(voxels);
    const VoxelAbuffer structure = rig.make({.abuffer_size = 256, .grid_size = voxels, .intersect = Intersect::parity});
    CHECK(abuffer::keeps_reaches(structure.state().grid) == (voxels == 64));
    const AbufferRig::Results found = rig.trace(structure, rays.rays, rays.ends);
    size_t wrong = 0;
    for (size_t i = 0; i < rays.rays.size(); ++i)
      wrong += (found.hits[i].triangle == LUCARIUM_NO_HIT) != (right.hits[i].triangle == LUCARIUM_NO_HIT);
    all_wrong.push_back(wrong);
  }
  MESSAGE(all_wrong[0], " and ", all_wrong[1], " of ", rays.rays.size());
  CHECK(all_wrong[0] < rays.rays.size() / 100);
  CHECK(all_wrong[0] <= all_wrong[1]);
}

TEST_CASE("voxels: exact search loses rays without conservative ones") {
  AbufferRig rig(scene_of(closed_bodies()));
  const std::vector<Ray> rays = scene_rays(rig, full_run() ? 300000 : 30000, 4).rays;
  const Bvh bvh(rig.scheduler.device(), rig.scene, rig.buffers);
  const AbufferRig::Results right = rig.trace(bvh, rays);
  const auto lost = [&](bool conservative) {
    // Voxels as small as pixels: larger ones rarely matter, as the columns of exact lists are conservative.
    abuffer::VoxelAbufferOptions options{.abuffer_size = 256, .grid_size = 256, .intersect = Intersect::exact};
    options.conservative_voxels = conservative;
    return differences(right, rig.trace(rig.make(options), rays));
  };
  CHECK(lost(true) == 0);
  const size_t without = lost(false);
  MESSAGE(without, " of ", rays.size());
  CHECK(without > 0);
  CHECK(without < rays.size() / 20);
}

TEST_CASE("voxels: a thin plate is searched along its normal, though the normals of its faces cancel") {
  Soup plate = box({-1, -1, 0.01f}, {1, 1, 0.02f});      // within one layer of voxels
  append(plate, box({0.3f, -1, 0.012f}, {1, 1, 1.5f}));  // on it a block, whose side has the greater average
  AbufferRig rig(scene_of(plate));
  const auto axes = [&](abuffer::AxisRule rule) {
    const VoxelAbuffer structure = rig.make({.abuffer_size = 256, .axis_rule = rule});
    const AbufferGrid& grid = structure.state().grid;
    const std::vector<uint32_t> words = structure.state().voxels.download();
    std::array<uint32_t, 4> count{};
    // Inside the plate's rim.
    for (uint32_t y = 4; y + 4 < grid.voxels.y; ++y)
      for (uint32_t x = 4; x + 4 < grid.voxels.x; ++x) {
        const uint32_t word = words[voxel_index(grid, {x, y, 0})];
        if (word & ABUFFER_OCCUPIED) ++count[word >> ABUFFER_AXIS_SHIFT & 3u];
      }
    return count;
  };
  const auto absolute = axes(abuffer::AxisRule::absolute_normal), average = axes(abuffer::AxisRule::average_normal);
  CHECK(absolute[2] > 300);
  CHECK(absolute[0] + absolute[1] + absolute[3] == 0);
  CHECK(average[0] > 20);
  CHECK(average[2] > 100);
  CHECK(average[1] + average[3] == 0);
}

TEST_CASE("voxels: inspect() reports the voxel of a point, and how its triangle is searched") {
  const Soup soup = closed_bodies();
  AbufferRig rig(scene_of(soup));
  const VoxelAbuffer abuffer = rig.make({.abuffer_size = 256, .intersect = Intersect::automatic});
  const AbufferGrid& grid = abuffer.state().grid;
  for (uint32_t triangle = 0; triangle < soup.triangles.size(); triangle += 101) {
    const Triangle& t = soup.triangles[triangle];
    const glm::vec3 middle = (soup.corner(t.v0) + soup.corner(t.v1) + soup.corner(t.v2)) / 3.f;
    const auto rows = abuffer::describe_voxel(abuffer, triangle, middle);
    REQUIRE(rows.size() == 4);
    glm::uvec3 voxel, count;
    CAPTURE(rows[1].second);
    REQUIRE(std::sscanf(rows[1].second.c_str(), "%u, %u, %u of %u × %u × %u", &voxel.x, &voxel.y, &voxel.z, &count.x,
                        &count.y, &count.z) == 6);
    CHECK(count == glm::uvec3(grid.voxels.x, grid.voxels.y, grid.voxels.z));
    const glm::vec3 center(grid.center.x, grid.center.y, grid.center.z),
        corner(grid.corner.x, grid.corner.y, grid.corner.z);
    const glm::vec3 place = (middle - center - corner) * grid.corner.w / static_cast<float>(grid.voxels.w);
    CHECK(glm::distance(place, glm::vec3(voxel) + 0.5f) < 0.87f);
    CHECK(rows[2].second.find("parity along") != std::string::npos);
    CHECK(rows[3].second == "parity, a solid");
  }
}
