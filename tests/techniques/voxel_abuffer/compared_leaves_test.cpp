// SPDX-License-Identifier: Apache-2.0
// Occupied voxels and sparse octrees to compare with: what they find lies within a voxel of the surfaces, and the more
// voxels, the fewer rays are wrong.
#include <doctest/doctest.h>

#include <algorithm>

#include "../../framework/services/layered_raster/scene.h"
#include "closed_bodies.h"
#include "compared_rig.h"
#include "lucarium/scene/load/load_scene.h"
#include "tolerance.h"
#include "voxel_abuffer/compared/sparse_octree.h"
#include "voxel_abuffer/compared/voxel_bits.h"
#include "voxel_abuffer/structure/grid_layout.h"

using namespace lucarium;
using namespace lucarium::test;
using abuffer::SparseOctree;
using abuffer::VoxelBits;

namespace {

/// Diagonal of a voxel, of `size` along the longest side.
float diagonal_of(const AbufferRig& rig, uint32_t size) {
  const glm::vec3 extent = rig.buffers.info().bounds_max.xyz() - rig.buffers.info().bounds_min.xyz();
  return std::sqrt(3.f) * std::max({extent.x, extent.y, extent.z}) / static_cast<float>(size - 4);
}

struct Wrong {
  double missed = 0, early = 0, late = 0, blocked = 0, free = 0;  ///< parts of the rays
  double mean = 0;  ///< difference of distances where both hit, at most `far` each [m]
};

constexpr float far = 0.1f;  // of a scene of 4 m

/// How hits differ from the hierarchy's: none where there is one; far before it, or where there is none; more than
/// `slack` behind it; connections taken as blocked, and as free.
Wrong compare(AbufferRig& rig, const Intersector& structure, const EndedRays& rays, float slack) {
  const Bvh bvh(rig.scheduler.device(), rig.scene, rig.buffers);
  const AbufferRig::Results expected = trace(rig, bvh, rays), found = trace(rig, structure, rays);
  Wrong wrong;
  const double one = 1 / static_cast<double>(rays.rays.size());
  for (size_t i = 0; i < rays.rays.size(); ++i) {
    const float a = expected.hits[i].distance, b = found.hits[i].distance;
    if (std::isfinite(a) && !std::isfinite(b)) wrong.missed += one;
    if (std::isfinite(b) && b < a - far) wrong.early += one;
    if (std::isfinite(b) && b > a + slack) wrong.late += one;
    if (std::isfinite(a) && std::isfinite(b)) wrong.mean += one * std::min(std::abs(a - b), far);
    if (expected.occluded[i] != found.occluded[i]) (found.occluded[i] ? wrong.blocked : wrong.free) += one;
  }
  return wrong;
}

Soup tilted_plane() {
  Soup soup;
  const glm::vec3 a(-1, -0.31f, -1.2f), b(1.1f, 0.22f, -0.9f), c(-0.9f, 0.1f, 1.3f);
  soup.add_triangle(a, b, c);
  soup.add_triangle(b, b + c - a, c);
  return soup;
}

glm::vec3 plane_normal(const Mesh& mesh) {
  const glm::uvec3& t = mesh.triangles[0];
  return glm::normalize(
      glm::cross(mesh.positions[t.y] - mesh.positions[t.x], mesh.positions[t.z] - mesh.positions[t.x]));
}

}  // namespace

TEST_CASE("pairs of voxels and triangles: as many as a cube's and a triangle's Minkowski sum has volume") {
  AbufferRig rig(scene_of(rough_sphere(20, 30, 5)));
  const VoxelBits voxels(rig.scheduler, rig.buffers, 200);
  const AbufferGrid grid = abuffer::make_grid({200, 200}, rig.scene.bounds(), 1);
  const float h = grid.center.w, edge = 1.02f;  // with the pad
  double expected = 0;
  const Mesh& mesh = rig.scene.meshes[0];
  for (const glm::uvec3& t : mesh.triangles) {
    const glm::vec3 a = mesh.positions[t.x] / h, b = mesh.positions[t.y] / h, c = mesh.positions[t.z] / h;
    const glm::vec3 areas = 0.5f * glm::abs(glm::cross(b - a, c - a));
    const glm::vec3 size = glm::max(a, glm::max(b, c)) - glm::min(a, glm::min(b, c));
    expected += edge * edge * edge + edge * edge * (size.x + size.y + size.z) + edge * (areas.x + areas.y + areas.z);
  }
  CHECK(voxels.statistics().pairs == test::relative(expected, 5e-3));
  CHECK(voxels.statistics().occupied_voxels < voxels.statistics().pairs);
}

TEST_CASE("an octree's hits are those of as many voxels") {
  AbufferRig rig(load_scene("builtin:solids"));
  const VoxelBits voxels(rig.scheduler, rig.buffers, 256);
  for (const uint32_t size : {256u, 200u}) {
    const SparseOctree octree(rig.scheduler, rig.buffers, size);
    CHECK(octree.depth() == 8);
    CHECK(octree.statistics().pairs == voxels.statistics().pairs);
    CHECK(octree.statistics().occupied_voxels == voxels.statistics().occupied_voxels);
    for (const EndedRays& rays : {camera_rays(rig, 20'000, 3), bounce_rays(rig, 20'000, 4), connections(rig, 5000, 5)})
      CHECK(differences(trace(rig, voxels, rays), trace(rig, octree, rays)) <= 2);
  }
}

TEST_CASE("voxels hide no surface, and wrong rays become fewer in proportion to their size") {
  AbufferRig rig(load_scene("builtin:solids"));
  std::vector<Wrong> camera, bounce, connected;
  for (const uint32_t size : {128u, 256u, 512u}) {
    const VoxelBits voxels(rig.scheduler, rig.buffers, size);
    const float diagonal = diagonal_of(rig, size);
    camera.push_back(compare(rig, voxels, camera_rays(rig, 40'000, 3), diagonal));
    bounce.push_back(compare(rig, voxels, bounce_rays(rig, 40'000, 4), diagonal));
    connected.push_back(compare(rig, voxels, connections(rig, 20'000, 5), diagonal));
    CHECK(camera.back().missed == 0);
    CHECK(camera.back().late == 0);
    CHECK(camera.back().free == 0);
    CHECK(bounce.back().missed < 2e-3);  // nearer than the voxels' diagonal
    CHECK(bounce.back().late < 0.012);   // likewise, or beside it
    CHECK(connected.back().free < 4e-3);
    if (camera.size() < 2) continue;
    const auto falls = [](const std::vector<Wrong>& of, double Wrong::*what) {
      CHECK(of.back().*what < 0.65 * of[of.size() - 2].*what);
    };
    falls(camera, &Wrong::early);
    falls(bounce, &Wrong::early);
    falls(bounce, &Wrong::mean);
    falls(connected, &Wrong::blocked);
  }
  CHECK(camera.back().early < 0.02);
  CHECK(bounce.back().early < 0.015);
  CHECK(connected.back().blocked < 0.005);
}

TEST_CASE("rays leave and reach a surface without meeting its own voxels, however flat") {
  AbufferRig rig(scene_of(tilted_plane()));
  EndedRays rays = bounce_rays(rig, 20'000, 7);
  const VoxelBits voxels(rig.scheduler, rig.buffers, 100);
  const SparseOctree octree(rig.scheduler, rig.buffers, 100);
  const auto stopped = [&](const Intersector& structure) {
    const AbufferRig::Results found = trace(rig, structure, rays);
    return std::count(found.occluded.begin(), found.occluded.end(), 1u) +
           std::count_if(found.hits.begin(), found.hits.end(),
                         [](const Hit& h) { return h.triangle != LUCARIUM_NO_HIT; });
  };
  CHECK(stopped(voxels) == 0);
  CHECK(stopped(octree) == 0);
  const glm::vec3 normal = plane_normal(rig.scene.meshes[0]);
  // The other way round: towards the plane from outside, up to its surface.
  for (size_t i = 0; i < rays.rays.size(); ++i) {
    Ray& ray = rays.rays[i];
    const glm::vec3 point = ray.origin.xyz(), direction = ray.direction.xyz();
    if (std::abs(glm::dot(direction, normal)) < 0.15f) {
      ray.direction.w = -1;  // would begin in the plane's voxels
      continue;
    }
    ray.origin = float4(point + 0.7f * direction, ray.origin.w);
    ray.direction = float4(-direction, 0.7f);
    std::swap(rays.ends[i].start, rays.ends[i].end);
  }
  CHECK(stopped(voxels) == 0);
  CHECK(stopped(octree) == 0);
}

TEST_CASE("rays that go straight on behind what they meet leave a body behind") {
  Soup soup;
  append(soup, box({-1.03f, -0.97f, -1.01f}, {0.98f, 1.02f, 1.04f}));
  AbufferRig rig(scene_of(soup));
  const VoxelBits voxels(rig.scheduler, rig.buffers, 64);
  const SparseOctree octree(rig.scheduler, rig.buffers, 64);
  for (const Intersector* structure :
       {static_cast<const Intersector*>(&voxels), static_cast<const Intersector*>(&octree)}) {
    CAPTURE(structure->name());
    CHECK(structure->name() == (structure == &octree ? "octree" : "voxel"));
    Random random(3);
    EndedRays rays;
    const glm::vec3 eye(4, 3, 5);
    for (int i = 0; i < 2000; ++i) {  // towards an upright edge
      const glm::vec3 target(0.98f + random.uniform(-0.03f, 0.03f), random.uniform(-0.9f, 0.9f), 1.04f);
      rays.add(make_ray(eye, glm::normalize(target - eye)), {LUCARIUM_NONE, LUCARIUM_NONE});
    }
    size_t met = 0;
    for (int round = 0; round < 20 && !rays.rays.empty(); ++round) {
      const AbufferRig::Results found = trace(rig, *structure, rays);
      EndedRays behind;
      for (size_t i = 0; i < rays.rays.size(); ++i) {
        const Hit& hit = found.hits[i];
        if (hit.triangle == LUCARIUM_NO_HIT) continue;
        ++met;
        const Triangle& t = soup.triangles[hit.triangle];
        const glm::vec3 a = soup.corner(t.v0), ab = soup.corner(t.v1) - a, ac = soup.corner(t.v2) - a;
        const glm::vec3 direction = rays.rays[i].direction.xyz();
        const bool back = glm::dot(glm::cross(ab, ac), direction) < 0;
        behind.add(make_ray(a + hit.u * ab + hit.v * ac, direction),
                   {hit.triangle | (back ? LUCARIUM_RAY_END_BACK : 0), LUCARIUM_NONE});
      }
      rays = behind;
    }
    CHECK(rays.rays.empty());
    CHECK(met > 2000);
    CHECK(met < 3 * 2000);
  }
}

TEST_CASE("leaves report the first of their triangles, and where its plane is met") {
  Soup soup = tilted_plane();
  for (const Triangle& t : tilted_plane().triangles)
    soup.add_triangle(soup.corner(t.v0), soup.corner(t.v1), soup.corner(t.v2));  // the same once more
  AbufferRig rig(scene_of(soup));
  Random random(3);
  EndedRays rays;
  for (int i = 0; i < 5000; ++i) {
    const glm::vec3 target(random.uniform(-0.6f, 0.6f), 0, random.uniform(-0.6f, 0.6f)), eye(0.3f, 2, 0.1f);
    rays.add(make_ray(eye, glm::normalize(target - eye)), {LUCARIUM_NONE, LUCARIUM_NONE});
  }
  const Bvh bvh(rig.scheduler.device(), rig.scene, rig.buffers);
  const SparseOctree octree(rig.scheduler, rig.buffers, 100);
  const AbufferRig::Results expected = trace(rig, bvh, rays), found = trace(rig, octree, rays);
  size_t same = 0, alike = 0, second = 0;
  for (size_t i = 0; i < rays.rays.size(); ++i) {
    const Hit &a = expected.hits[i], &b = found.hits[i];
    REQUIRE(b.triangle != LUCARIUM_NO_HIT);
    second += b.triangle >= 2;
    if (std::abs(a.distance - b.distance) > 1e-5f || a.triangle != b.triangle) continue;
    ++same;
    alike += std::abs(a.u - b.u) < 1e-4f && std::abs(a.v - b.v) < 1e-4f;
  }
  CHECK(second == 0);
  CHECK(same > rays.rays.size() / 2);  // others meet the plane behind the first voxel that it touches
  CHECK(alike == same);
}

TEST_CASE("occupied voxels of MASK and BLEND surfaces let rays pass as the surfaces do") {
  AbufferRig rig(scene_of(tilted_plane(), veil(0.25f)));
  Random random(3);
  EndedRays rays;
  for (int i = 0; i < 20'000; ++i)
    rays.add(make_ray({random.uniform(-0.2f, 0.2f), 2, random.uniform(-0.2f, 0.2f)}, {0, -1, 0}),
             {LUCARIUM_NONE, LUCARIUM_NONE});
  const SparseOctree octree(rig.scheduler, rig.buffers, 64);
  const AbufferRig::Results found = trace(rig, octree, rays);
  // A ray passes one or two voxels; in both the same triangle decides, alike.
  CHECK(static_cast<double>(std::count(found.occluded.begin(), found.occluded.end(), 1u)) ==
        test::relative(0.25 * 20'000, 0.1));
  for (size_t i = 0; i < rays.rays.size(); ++i)
    CHECK((found.hits[i].triangle != LUCARIUM_NO_HIT) == (found.occluded[i] == 1));
}
