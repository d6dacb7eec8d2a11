// SPDX-License-Identifier: Apache-2.0
// The fragment lists: their numbers against closed forms, and that three stores make the same.
#include <doctest/doctest.h>

#include <array>
#include <bit>
#include <cmath>

#include "../../framework/services/layered_raster/scene.h"
#include "abuffer_rig.h"
#include "closed_bodies.h"
#include "lucarium/scene/mesh_components.h"
#include "test_support.h"
#include "tolerance.h"
#include "voxel_abuffer/structure/state.h"

using namespace lucarium;
using namespace lucarium::test;
using abuffer::Intersect;
using abuffer::VoxelAbuffer;

namespace {

/// The lists of one axis on the host.
struct HostLists {
  std::vector<uint32_t> start, fragments;
  std::vector<float> depths;
  AbufferGrid grid;

  explicit HostLists(const VoxelAbuffer& structure) : grid(structure.state().grid) {
    const abuffer::AbufferLists& lists = *structure.state().parity;
    start = lists.start().download();
    fragments = lists.fragments().download();
    for (const uint32_t bits : lists.depths().download()) depths.push_back(std::bit_cast<float>(bits));
  }
  uint32_t size(int axis) const {
    axis %= 3;
    return (axis == 0 ? grid.voxels.x : axis == 1 ? grid.voxels.y : grid.voxels.z) * grid.voxels.w;
  }
  uint32_t column(int k, uint32_t x, uint32_t y) const {
    const uint32_t edge = grid.voxels.w, voxel = y / edge * (size(k + 1) / edge) + x / edge;
    return static_cast<uint32_t>(k) * grid.bricks.w + (voxel * edge + y % edge) * edge + x % edge;
  }
  static int sign(uint32_t fragment) { return fragment & LAYERED_AWAY ? -1 : 1; }
};

std::vector<std::vector<uint32_t>> contents(const VoxelAbuffer& structure) {
  const VoxelAbuffer::State& s = structure.state();
  std::vector<std::vector<uint32_t>> all = {s.voxels.download(), s.counts.download()};
  for (const auto* lists : {&s.exact, &s.parity})
    if (*lists) {
      const size_t used =
          lists == &s.exact ? structure.statistics().exact_fragments : structure.statistics().parity_fragments;
      all.push_back((*lists)->start().download());
      all.push_back((*lists)->depths().download(0, used));
      all.push_back((*lists)->fragments().download(0, used));
    }
  return all;
}

}  // namespace

TEST_CASE("conservative lists hold a fragment where a triangle touches a pixel of its dominant axis, not more") {
  // Width and height beside the area (Minkowski sum), in one view each.
  AbufferRig rig(scene_of(rough_sphere(60, 80, 5)));
  const auto abuffer = rig.make({.abuffer_size = 700, .intersect = Intersect::exact});
  const auto& s = abuffer.statistics();
  const auto found = static_cast<double>(s.exact_fragments);
  CHECK(found >= 0.999 * s.expected_exact_fragments);
  CHECK(found <= 1.02 * s.expected_exact_fragments);
  CHECK(s.parity_fragments == 0);
}

TEST_CASE("closed bodies: every column balances, fragments are the projected area, volumes are right along each axis") {
  AbufferRig rig(scene_of(closed_bodies()));
  const VoxelAbuffer structure = rig.make({.abuffer_size = full_run() ? 1280u : 640u});
  const auto& s = structure.statistics();
  CHECK(s.unbalanced_columns == 0);
  CHECK(s.exact_triangles == 0);
  CHECK(static_cast<double>(s.parity_fragments) == test::relative(s.expected_parity_fragments, 1e-3));
  const HostLists lists(structure);
  const Mesh& mesh = rig.scene.meshes[0];
  const double volume = signed_volume(mesh.positions, mesh.triangles), h = lists.grid.center.w;
  for (int k = 0; k < 3; ++k) {
    double sum = 0;
    uint32_t unbalanced = 0;
    for (uint32_t y = 0; y < lists.size(k + 2); ++y)
      for (uint32_t x = 0; x < lists.size(k + 1); ++x) {
        const uint32_t column = lists.column(k, x, y);
        int balance = 0;
        for (uint32_t i = lists.start[column]; i < lists.start[column + 1]; ++i) {
          balance += HostLists::sign(lists.fragments[i]);
          sum -= HostLists::sign(lists.fragments[i]) * static_cast<double>(lists.depths[i]);
        }
        unbalanced += balance != 0;
      }
    CHECK(unbalanced == 0);
    CHECK(sum * h * h * h == test::relative(volume, 1e-3));
  }
}

TEST_CASE("the state of a point counts the solids around it, along each axis") {
  Soup soup = torus();
  append(soup, sphere({0.9f, 0.2f, 0.1f}, 0.7f));
  append(soup, box({-0.3f, -0.9f, -0.5f}, {1.1f, 0.3f, 0.8f}));
  AbufferRig rig(scene_of(soup));
  const VoxelAbuffer structure = rig.make({.abuffer_size = 640});
  const HostLists lists(structure);
  const float h = lists.grid.center.w;
  // Signed distances to the smooth bodies; their facets lie up to 2e-3 m inside.
  const auto distances = [](const glm::vec3& p) {
    const float ring = std::hypot(std::hypot(p.x, p.z) - 1, p.y) - 0.4f;
    const float ball = glm::distance(p, glm::vec3(0.9f, 0.2f, 0.1f)) - 0.7f;
    const glm::vec3 q = glm::abs(p - glm::vec3(0.4f, -0.3f, 0.15f)) - glm::vec3(0.7f, 0.6f, 0.65f);
    return std::array{ring, ball, std::max({q.x, q.y, q.z})};
  };
  Random random(4);
  const uint32_t points = full_run() ? 1000000 : 50000;
  uint32_t wrong = 0, tested = 0, inside = 0;
  for (uint32_t i = 0; i < points; ++i) {
    const glm::vec3 p = random.in_cube(1.5f), local = (p - lists.grid.center.xyz() - lists.grid.corner.xyz()) / h;
    int expected = 0;
    bool near = false;
    for (const float d : distances(p)) {
      near = near || std::fabs(d) < h + 2e-3f;
      expected += d < 0;
    }
    if (near) continue;
    ++tested;
    inside += expected > 0;
    for (int k = 0; k < 3; ++k) {
      const float x = local[(k + 1) % 3], y = local[(k + 2) % 3];
      int w = 0;
      if (x >= 0 && y >= 0 && x < static_cast<float>(lists.size(k + 1)) && y < static_cast<float>(lists.size(k + 2))) {
        const uint32_t column = lists.column(k, static_cast<uint32_t>(x), static_cast<uint32_t>(y));
        for (uint32_t f = lists.start[column]; f < lists.start[column + 1]; ++f)
          if (lists.depths[f] < local[k]) w += HostLists::sign(lists.fragments[f]);
      }
      wrong += w != expected;
    }
  }
  CHECK(tested > points / 2);
  CHECK(inside > points / 20);
  CHECK(wrong == 0);
}

TEST_CASE("three stores and any number of threads build the same structure") {
  Soup soup = closed_bodies();
  append(soup, random_soup(200, 3, 1));  // open: exact
  std::vector<std::vector<std::vector<uint32_t>>> all;
  for (const int threads : {1, 2}) {
    DeviceOptions device;
    device.threads = threads;
    AbufferRig rig(scene_of(soup), device);
    for (const LayeredVariant list : {LayeredVariant::tiles, LayeredVariant::exact, LayeredVariant::linked_list})
      all.push_back(contents(rig.make({.abuffer_size = 256, .list = list})));
  }
  CHECK(all[0].size() == 8);
  for (size_t i = 1; i < all.size(); ++i) {
    CAPTURE(i);
    CHECK(all[i] == all[0]);
  }
}

TEST_CASE("a structure that is built again is the same, and so is one that follows a motion") {
  const auto scene_at = [](float x) {
    Scene scene = scene_of(closed_bodies());
    scene.instances[0].world_from_object[3].x = x;
    return scene;
  };
  AbufferRig rig(scene_at(0));
  VoxelAbuffer structure = rig.make({.abuffer_size = 256});
  const auto first = contents(structure);
  structure.rebuild();
  CHECK(contents(structure) == first);
  rig.scene.instances[0].world_from_object[3].x = 0.7f;
  SceneChange change;
  change.moved_instances = {0};
  change.previous_world_from_object = {glm::mat4(1)};
  rig.buffers.update(rig.scene, change);
  structure.update(rig.scene, change);
  AbufferRig moved(scene_at(0.7f));
  CHECK(contents(structure) == contents(moved.make({.abuffer_size = 256})));
}
