// SPDX-License-Identifier: Apache-2.0
// Search by parity of meshes without an inside, beside closed bodies: against the hierarchy's hits.
#include <doctest/doctest.h>

#include "../../framework/services/layered_raster/scene.h"
#include "closed_bodies.h"
#include "lucarium/conformance/check_scenes.h"
#include "test_support.h"
#include "voxel_abuffer/structure/state.h"
#include "walked_rays.h"

using namespace lucarium;
using namespace lucarium::test;
using abuffer::Intersect;
using abuffer::Search;
using abuffer::VoxelAbuffer;

namespace {

/// From low to high at a height, facing up or down.
Soup sheet(const glm::vec2& low, const glm::vec2& high, float y, bool up) {
  Soup soup;
  soup.add_vertex({low.x, y, low.y});
  soup.add_vertex({low.x, y, high.y});
  soup.add_vertex({high.x, y, high.y});
  soup.add_vertex({high.x, y, low.y});
  soup.triangles = {{0, 1, 2, 0}, {0, 2, 3, 0}};
  if (!up)
    for (Triangle& t : soup.triangles) std::swap(t.v1, t.v2);
  return soup;
}

/// From a point of a surface, cosine-distributed around the normal of its side.
void add_bounce(TestRays& rays, Random& random, const glm::vec3& point, const glm::vec3& normal, uint32_t end) {
  rays.rays.push_back(make_ray(point + 1e-4f * normal, glm::normalize(1.0001f * normal + random.direction())));
  rays.ends.push_back({end, LUCARIUM_NONE});
}

/// Rays that miss, hit nothing that is there, or are more than four pixels off.
uint32_t count_wrong(AbufferRig& rig, const VoxelAbuffer& structure, const TestRays& rays) {
  const Bvh bvh(rig.scheduler.device(), rig.scene, rig.buffers);
  const std::vector<Hit> right = rig.trace(bvh, rays.rays).hits,
                         found = rig.trace(structure, rays.rays, rays.ends).hits;
  const float reach = 4 * structure.state().grid.center.w;
  uint32_t wrong = 0;
  for (size_t i = 0; i < right.size(); ++i) {
    const bool hit = right[i].triangle != LUCARIUM_NO_HIT, told = found[i].triangle != LUCARIUM_NO_HIT;
    wrong += hit != told || (hit && !(std::fabs(right[i].distance - found[i].distance) <= reach));
  }
  return wrong;
}

}  // namespace

TEST_CASE("open meshes: a floor two pixels under a glass box takes no ray from it") {
  // Voxels of four pixels, so that the axis changes beside the box.
  AbufferRig rig(check::make_material_scene(MaterialKind::refraction, LightKind::emissive));
  const HostTriangles host(rig.buffers);
  Random random(7);
  TestRays below, inside, under;
  std::vector<Ray> down;
  for (int i = 0; i < 40000; ++i)
    down.push_back(make_ray({random.uniform(-0.7f, 0.7f), 0.01f, random.uniform(-0.7f, 0.7f)}, {0, -1, 0}));
  const Bvh bvh(rig.scheduler.device(), rig.scene, rig.buffers);
  const std::vector<Hit> floors = rig.trace(bvh, down).hits;
  for (size_t i = 0; i < down.size(); ++i)
    add_bounce(below, random, down[i].origin.xyz() - glm::vec3(0, 0.01f, 0), {0, 1, 0}, floors[i].triangle);
  constexpr uint32_t first = 2, last = 13;  // triangles of the box
  for (int i = 0; i < 40000; ++i) {
    const uint32_t t = first + random.below(last - first + 1);
    const float root = std::sqrt(random.uniform()), v = random.uniform() * root;
    const glm::vec3 point = (1 - root) * host.corner(t, 0) + (root - v) * host.corner(t, 1) + v * host.corner(t, 2);
    add_bounce(inside, random, point, -host.normal(t), t | LUCARIUM_RAY_END_BACK);
    if (host.normal(t).y < -0.5f) add_bounce(under, random, point, host.normal(t), t);
  }
  for (const Search search : {Search::columns, Search::three_steps, Search::one_step}) {
    CAPTURE(static_cast<int>(search));
    const uint32_t voxels = search == Search::columns ? 64 : 32;  // points are taken from 8 pixels per voxel on
    const VoxelAbuffer structure =
        rig.make({.abuffer_size = 256, .grid_size = voxels, .intersect = Intersect::parity, .search = search});
    CHECK(structure.statistics().open_components == 2);
    const uint32_t wrong_below = count_wrong(rig, structure, below), wrong_inside = count_wrong(rig, structure, inside),
                   wrong_under = count_wrong(rig, structure, under);
    MESSAGE(wrong_below, " from the floor, ", wrong_inside, " from inside, ", wrong_under, " of ", under.rays.size(),
            " from the bottom wrong");
    CHECK(wrong_below <= below.rays.size() / 250);
    CHECK(wrong_inside <= inside.rays.size() / 1000);
    CHECK(wrong_under <= under.rays.size() / 500);
  }
}

TEST_CASE("open meshes: a floor is met beside a box that stands on it") {
  // The box's bottom and the floor have fragments in the same places, in columns whose centres lie in the box.
  const Soup body = box({-0.5f, 0, -0.5f}, {0.5f, 0.5f, 0.5f}), floor = sheet({-1.01f, -1.02f}, {1, 1}, 0, true);
  for (const bool floor_first : {false, true}) {
    CAPTURE(floor_first);
    Soup soup = floor_first ? floor : body;
    append(soup, floor_first ? body : floor);
    AbufferRig rig(scene_of(soup));
    const VoxelAbuffer structure = rig.make({.abuffer_size = 256, .intersect = Intersect::parity});
    CHECK(structure.statistics().open_components == 1);
    const float pixel = structure.state().grid.center.w;
    Random random(3);
    TestRays rays;
    for (int i = 0; i < 20000; ++i) {
      const float off = 0.5f + random.uniform(0.02f, 0.5f) * pixel, along = random.uniform(-0.4f, 0.4f);
      const glm::vec3 to = i & 1 ? glm::vec3(i & 2 ? off : -off, 0, along) : glm::vec3(along, 0, i & 2 ? off : -off);
      const glm::vec3 from = to + 0.6f * to + glm::vec3(0, random.uniform(0.2f, 1), 0);
      rays.rays.push_back(make_ray(from, glm::normalize(to - from)));
      rays.ends.push_back({LUCARIUM_NONE, LUCARIUM_NONE});
    }
    const uint32_t wrong = count_wrong(rig, structure, rays);
    MESSAGE(wrong, " of ", rays.rays.size(), " wrong");
    CHECK(wrong <= 2);
  }
}

TEST_CASE("open meshes: what looks like a body's inside between two sheets is none") {
  // Two sheets that look away from each other continue the faces of a slab: columns count as many surfaces there.
  constexpr float below = 0.1f, above = 0.128f;  // three and a half pixels
  Soup soup = box({0, below, -1}, {1, above, 1});
  append(soup, sheet({-1, -1}, {-0.001f, 1}, below, false));
  append(soup, sheet({-1, -1}, {-0.001f, 1}, above, true));
  AbufferRig rig(scene_of(soup));
  const VoxelAbuffer structure = rig.make({.abuffer_size = 256, .intersect = Intersect::parity});
  CHECK(structure.statistics().open_components == 2);
  const float pixel = structure.state().grid.center.w;
  Random random(3);
  TestRays rays;
  for (int i = 0; i < 5000; ++i) {
    const float middle = 0.5f * (below + above) + pixel * random.uniform(-0.2f, 0.2f);
    const glm::vec3 from(random.uniform(-0.9f, -0.1f), middle, random.uniform(-0.8f, 0.8f));
    rays.rays.push_back(make_ray(from, glm::normalize(glm::vec3(1, 0, random.uniform(-0.2f, 0.2f)))));
    rays.ends.push_back({LUCARIUM_NONE, LUCARIUM_NONE});
  }
  const uint32_t wrong = count_wrong(rig, structure, rays);
  MESSAGE(wrong, " of ", rays.rays.size(), " wrong");
  CHECK(wrong == 0);
}

TEST_CASE("open meshes: the face of a box is met in rows whose centres lie beside it") {
  // The box begins 0.4 pixels below a row's end: along z no column of that row has its front. Columns along y see it.
  AbufferRig rig(check::make_material_scene(MaterialKind::diffuse, LightKind::emissive));
  const VoxelAbuffer structure = rig.make({.abuffer_size = 256, .intersect = Intersect::automatic});
  const AbufferGrid& grid = structure.state().grid;
  const float pixel = grid.center.w, low = (0.05f - grid.center.y - grid.corner.y) * grid.corner.w;
  CHECK(low - std::floor(low) > 0.5f);
  const glm::vec3 eye(0.9f, 1.6f, 3.4f);
  Random random(4);
  std::vector<Ray> rays;
  for (int i = 0; i < 20000; ++i) {
    const glm::vec3 to(random.uniform(-0.45f, 0.45f), 0.05f + pixel * random.uniform(0.02f, 0.38f), 0.5f);
    rays.push_back(make_ray(eye, glm::normalize(to - eye)));
  }
  const Bvh bvh(rig.scheduler.device(), rig.scene, rig.buffers);
  const std::vector<Hit> right = rig.trace(bvh, rays).hits, found = rig.trace(structure, rays).hits;
  const HostTriangles host(rig.buffers);
  uint32_t turned = 0;
  for (size_t i = 0; i < rays.size(); ++i)
    turned += found[i].triangle == LUCARIUM_NO_HIT ||
              glm::dot(host.normal(found[i].triangle), host.normal(right[i].triangle)) < 0.9f;
  MESSAGE(turned, " of ", rays.size(), " on another face, or none");
  CHECK(turned <= 20);
}
