// SPDX-License-Identifier: Apache-2.0
// Search by parity where solids touch, along edges, and where meshes are open: against the hierarchy's hits.
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

Soup inverted(Soup soup) {
  for (Triangle& t : soup.triangles) std::swap(t.v1, t.v2);
  return soup;
}

/// A room with a box on its floor, one on that, one that touches it and a slab in the wall's plane.
Soup furnished_room() {
  Soup soup = inverted(box({-2, 0, -2}, {2, 2.5f, 2}));
  append(soup, box({-0.8f, 0, -0.5f}, {0.1f, 0.71f, 0.42f}));
  append(soup, box({0.1f, 0, -0.33f}, {0.63f, 0.4f, 0.42f}));
  append(soup, box({-0.6f, 0.71f, -0.21f}, {-0.13f, 1.13f, 0.33f}));
  append(soup, box({-2, 0.3f, -1}, {-1.7f, 1.7f, 1.1f}));
  return soup;
}

struct Limits {
  double lost;        ///< missed, or found where there is nothing
  double far;         ///< more than four pixels off
  double turned;      ///< another face of the same edge
  double connection;  ///< free though blocked, or blocked though free
};

void check_groups(AbufferRig& rig, const VoxelAbuffer& structure, const WalkedRays& rays, const Limits& bound) {
  const float pixel = structure.state().grid.center.w;
  for (const WalkedRays::Group& group : rays.groups) {
    CAPTURE(group.name);
    const WalkErrors e = walk_errors(rig, structure, group, pixel);
    MESSAGE(group.name, ": missed ", e.of(e.missed), " invented ", e.of(e.invented), " far ", e.of(e.far), " turned ",
            e.of(e.turned), " occlusion ", e.of(e.occlusion));
    CHECK(e.rays > 1000);
    CHECK(e.of(e.missed + e.invented) <= bound.lost);
    CHECK(e.of(e.far) <= bound.far);
    CHECK(e.of(e.turned) <= bound.turned);
    CHECK(e.of(e.occlusion) <= (group.hits.empty() ? bound.connection : bound.lost));
  }
}

}  // namespace

TEST_CASE("contacts: solids that touch a room's floor, its wall and each other are hit where they are") {
  AbufferRig rig(scene_of(furnished_room()));
  const WalkedRays rays = walk_rays(rig, {0.9f, 1.6f, 1.9f}, full_run() ? 400000 : 30000, 3);
  // Half as many pixels, twice the errors.
  for (const uint32_t size : {320u, 640u, 1280u}) {
    if (size == 1280 && !full_run()) continue;
    CAPTURE(size);
    const double coarse = 1280.0 / size;
    check_groups(rig, rig.make({.abuffer_size = size, .intersect = Intersect::parity}), rays,
                 {0.0002 * coarse, 0.001 * coarse, 0.0005 * coarse, 0.0015 * coarse});
  }
}

TEST_CASE("contacts: a mesh without an inside is hit by parity where it is, and nowhere beside its rim") {
  using check::make_material_scene;
  AbufferRig rig(make_material_scene(MaterialKind::diffuse, LightKind::emissive));
  const WalkedRays rays = walk_rays(rig, {0.9f, 1.6f, 3.4f}, full_run() ? 400000 : 60000, 3);
  const VoxelAbuffer structure = rig.make({.abuffer_size = 512, .intersect = Intersect::parity});
  CHECK(structure.statistics().open_components == 2);
  CHECK(structure.statistics().exact_triangles == 0);
  check_groups(rig, structure, rays, {0.003, 0.002, 0.001, 0.003});
}

TEST_CASE("contacts: rays that pass within a pixel of an edge meet nothing there, those between two triangles one") {
  // The staircase of an edge reaches half a pixel beyond it.
  AbufferRig rig(check::make_material_scene(MaterialKind::diffuse, LightKind::emissive));
  const Bvh bvh(rig.scheduler.device(), rig.scene, rig.buffers);
  for (const Intersect intersect : {Intersect::automatic, Intersect::parity}) {
    CAPTURE(static_cast<int>(intersect));
    const VoxelAbuffer structure = rig.make({.abuffer_size = 256, .intersect = intersect});
    const float pixel = structure.state().grid.center.w;
    const glm::vec3 eye(0.9f, 1.6f, 3.4f);
    Random random(6);
    std::vector<Ray> rays;
    for (int i = 0; i < 30000; ++i) {
      const float along = random.uniform(-1, 1);
      const glm::vec3 edge = i % 3 == 0 ? glm::vec3(0.4f * along, 1.05f, -0.5f)  // of the box, above, at the back
                             : i % 3 == 1
                                 ? glm::vec3(2.5f * along, 0, -3)             // the floor's rim
                                 : 0.5f * glm::vec3(along, 1.1f + along, 1);  // between two triangles of its front
      rays.push_back(make_ray(eye, glm::normalize(edge + pixel * random.in_cube(1) - eye)));
    }
    const AbufferRig::Results right = rig.trace(bvh, rays), found = rig.trace(structure, rays);
    uint32_t past = 0, invented = 0, shaded = 0, missed = 0;
    for (size_t i = 0; i < rays.size(); ++i) {
      const bool hit = right.hits[i].triangle != LUCARIUM_NO_HIT, told = found.hits[i].triangle != LUCARIUM_NO_HIT;
      past += !hit;
      invented += !hit && told;
      shaded += !hit && found.occluded[i];
      if (i % 3 == 2) missed += !(std::fabs(right.hits[i].distance - found.hits[i].distance) <= 4 * pixel);
    }
    MESSAGE(invented, " of ", past, " that meet nothing, ", shaded, " as shadow rays; ", missed,
            " between triangles missed");
    CHECK(past > 5000);
    CHECK(invented <= past / 500);
    CHECK(shaded <= past / 500);
    CHECK(missed <= rays.size() / 1000);
  }
}

TEST_CASE("contacts: rays from within half a pixel of another solid meet it, or leave") {
  AbufferRig rig(scene_of(furnished_room()));
  const VoxelAbuffer structure = rig.make({.abuffer_size = 320, .intersect = Intersect::parity});
  const float pixel = structure.state().grid.center.w;
  const Bvh bvh(rig.scheduler.device(), rig.scene, rig.buffers);
  // The floor beside a box: columns whose centres lie in the box reach over it.
  const uint32_t down = rig.trace(bvh, {make_ray({0.9f, 1, 0.9f}, {0, -1, 0})}).hits[0].triangle;
  Random random(4);
  TestRays rays;
  for (uint32_t i = 0; i < 20000; ++i) {
    const glm::vec3 from(0.63f + random.uniform(0.05f, 0.5f) * pixel, 1e-4f, random.uniform(-0.3f, 0.4f));
    rays.rays.push_back(make_ray(from, glm::normalize(glm::vec3(0, 1.0001f, 0) + random.direction())));
    rays.ends.push_back({down, LUCARIUM_NONE});
  }
  const AbufferRig::Results right = rig.trace(bvh, rays.rays), found = rig.trace(structure, rays.rays, rays.ends);
  uint32_t wrong = 0, near = 0, negative = 0;
  for (size_t i = 0; i < rays.rays.size(); ++i) {
    near += right.hits[i].distance < pixel;
    wrong += !(std::fabs(right.hits[i].distance - found.hits[i].distance) < 4 * pixel);
    negative += !(found.hits[i].distance > 0);
  }
  MESSAGE(wrong, " wrong, ", near, " hit the box at once");
  CHECK(near > 5000);
  CHECK(negative == 0);
  CHECK(wrong <= 4);
  // To points of the walls: free where the way leads off the box.
  for (Ray& ray : rays.rays) ray.direction.w = 0.5f;
  const std::vector<uint32_t> free = rig.trace(bvh, rays.rays).occluded;
  for (const Search search : {Search::columns, Search::three_steps}) {
    const VoxelAbuffer of_search = rig.make({.abuffer_size = 320, .intersect = Intersect::parity, .search = search});
    const std::vector<uint32_t> told = rig.trace(of_search, rays.rays, rays.ends).occluded;
    uint32_t unlike = 0;
    for (size_t i = 0; i < free.size(); ++i) unlike += free[i] != told[i];
    MESSAGE(unlike, " of them wrong");
    CHECK(unlike <= 200);
  }
}

TEST_CASE("contacts: rays that begin in the edge of a room meet its other wall") {
  AbufferRig rig(scene_of(inverted(box({-2, 0, -2}, {2, 2.5f, 2}))));
  const VoxelAbuffer structure = rig.make({.abuffer_size = 320, .intersect = Intersect::parity});
  const float pixel = structure.state().grid.center.w;
  const Bvh bvh(rig.scheduler.device(), rig.scene, rig.buffers);
  const uint32_t down = rig.trace(bvh, {make_ray({1.9f, 1, 0.3f}, {0, -1, 0})}).hits[0].triangle;
  Random random(8);
  TestRays rays;
  for (uint32_t i = 0; i < 2000; ++i) {
    const glm::vec3 from(2 - random.uniform(0.001f, 0.008f) * pixel, 1e-5f, random.uniform(0.1f, 0.5f));
    rays.rays.push_back(
        make_ray(from, glm::normalize(glm::vec3(random.uniform(0.1f, 1), random.uniform(), random.uniform(-1, 1)))));
    rays.ends.push_back({down, LUCARIUM_NONE});
  }
  uint32_t left = 0;
  for (const Hit& hit : rig.trace(structure, rays.rays, rays.ends).hits) left += !(hit.distance < pixel);
  CHECK(left == 0);
}

TEST_CASE("contacts: a face in the last half pixel of a voxel is met from inside") {
  // The state of a column changes up to half a pixel beyond the surface: in the next voxel.
  AbufferRig rig(check::make_material_scene(MaterialKind::diffuse, LightKind::emissive));
  const VoxelAbuffer structure = rig.make({.abuffer_size = 256, .intersect = Intersect::automatic});
  const AbufferGrid& grid = structure.state().grid;
  const float top = (1.05f - grid.center.y - grid.corner.y) * grid.corner.w, edge = static_cast<float>(grid.voxels.w);
  CHECK(top - edge * std::floor(top / edge) > edge - 0.5f);
  CHECK(top - edge * std::floor(top / edge) < edge - 0.2f);
  Random random(1);
  std::vector<Ray> rays;
  for (int i = 0; i < 2000; ++i) {
    const glm::vec3 from(random.uniform(-0.4f, 0.4f), random.uniform(0.1f, 1), random.uniform(-0.4f, 0.4f));
    rays.push_back(
        make_ray(from, glm::normalize(glm::vec3(random.uniform(-0.3f, 0.3f), 1, random.uniform(-0.3f, 0.3f)))));
  }
  uint32_t missed = 0;
  for (const Hit& hit : rig.trace(structure, rays).hits) missed += hit.distance > 1.1f;
  CHECK(missed == 0);
}

TEST_CASE("contacts: bodies whose triangles are smaller than pixels are hit, with an inside and without") {
  // Most of these triangles have no fragments.
  const Soup ball = sphere({0.1f, 0.2f, 0.3f}, 1, 320);
  Soup cup = ball;
  std::erase_if(cup.triangles, [&](const Triangle& t) { return cup.vertices[t.v0].position.z > 0.7f; });
  for (const Soup& body : {ball, cup}) {
    Soup soup = inverted(box({-2, -2, -2}, {4, 4, 4}));
    append(soup, body);
    AbufferRig rig(scene_of(soup));
    const VoxelAbuffer structure = rig.make({.abuffer_size = 256, .intersect = Intersect::parity});
    CHECK(structure.statistics().exact_triangles == 0);
    CAPTURE(structure.statistics().open_components);
    const WalkedRays rays = walk_rays(rig, {0.9f, 1.6f, 3.4f}, 10000, 3);
    // What has no inside errs near its rim.
    const bool open = structure.statistics().open_components > 0;
    check_groups(rig, structure, rays, {0.0005, open ? 0.0016 : 0.0005, 0.001, open ? 0.004 : 0.003});
  }
}

namespace {

Soup turned(Soup soup) {
  const glm::vec3 axis = glm::normalize(glm::vec3(2, -1, 3));
  const float c = std::cos(0.6f), s = std::sin(0.6f);
  for (Vertex& v : soup.vertices) {
    const glm::vec3 p = v.position.xyz();
    v.position = float4(c * p + s * glm::cross(axis, p) + (1 - c) * glm::dot(axis, p) * axis, 0.f);
  }
  return soup;
}

Soup both(Soup soup, const Soup& more) {
  append(soup, more);
  return soup;
}

/// Two points.
Soup line(const glm::vec3& from, const glm::vec3& to) {
  Soup soup;
  soup.add_vertex(from);
  soup.add_vertex(to);
  return soup;
}

}  // namespace

TEST_CASE("contacts: bodies with common walls are searched exactly, and those beside them by parity") {
  const Soup cube = box({0, 0, 0}, {1, 1, 1}), apart = box({3, 0, 0}, {3.5f, 1, 1});
  struct Case {
    const char* name;
    Soup soup;
    uint32_t moved;
  };
  // Bodies with the same corners are one component.
  for (const Case& c : {Case{"of one component", both(cube, box({1, 0, 0}, {2, 1, 1})), 1},
                        {"of two", both(cube, box({1, 0.2f, 0.1f}, {2, 0.8f, 1.7f})), 2},
                        {"on a side of one", both(cube, box({0.2f, 0.3f, 0.1f}, {0.9f, 1, 0.8f})), 0},
                        {"of rooms", both(inverted(cube), inverted(box({1, -0.2f, -0.1f}, {2, 1.3f, 1.7f}))), 2},
                        {"half a pixel apart", both(cube, box({1.006f, 0, 0}, {2, 1, 1})), 0},
                        {"through each other", both(cube, box({0.5f, 0.2f, 0.1f}, {2, 0.8f, 1.7f})), 0}})
    for (const bool off_axes : {false, true}) {
      CAPTURE(std::string(c.name));
      CAPTURE(off_axes);
      const Soup soup = both(c.soup, apart);
      AbufferRig rig(scene_of(off_axes ? turned(soup) : soup));
      const VoxelAbuffer structure = rig.make({.abuffer_size = 320});
      CHECK(structure.statistics().moved_components == c.moved);
      CHECK((structure.statistics().touching_columns > 0) == (c.moved > 0));
      CHECK(structure.statistics().unbalanced_columns == 0);
      CHECK(structure.statistics().parity_triangles == (c.moved > 0 ? 12 : 36));
      if (c.moved == 0) continue;
      // From inside the first one into the second.
      Random random(5);
      std::vector<Ray> rays;
      for (int i = 0; i < 1000; ++i) {
        const Soup way = line({random.uniform(0.1f, 0.9f), random.uniform(0.1f, 0.9f), random.uniform(0.1f, 0.9f)},
                              glm::vec3(1.5f, 0.5f, 0.5f) + random.in_cube(0.4f));
        const Soup placed = off_axes ? turned(way) : way;
        rays.push_back(make_ray(placed.corner(0), glm::normalize(placed.corner(1) - placed.corner(0))));
      }
      const Bvh bvh(rig.scheduler.device(), rig.scene, rig.buffers);
      CHECK(differences(rig.trace(bvh, rays), rig.trace(structure, rays)) == 0);
    }
}
