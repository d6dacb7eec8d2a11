// SPDX-License-Identifier: Apache-2.0
// Where hits by parity and by planes lie: against a sphere, with attributes of the pixel's centre, computed and stored;
// and search by planes on meshes with holes.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "../../framework/services/layered_raster/scene.h"
#include "abuffer_rig.h"
#include "closed_bodies.h"
#include "test_support.h"
#include "voxel_abuffer/structure/state.h"
#include "voxel_abuffer/structure_bytes.h"

using namespace lucarium;
using namespace lucarium::test;
using abuffer::Attributes;
using abuffer::Intersect;
using abuffer::Search;
using abuffer::VoxelAbuffer;

namespace {

/// Rays from far around the unit sphere that meet it well inside, and their distances to it.
struct SphereRays {
  std::vector<Ray> rays;
  std::vector<double> distances;
};
SphereRays sphere_rays(uint32_t count) {
  Random random(5);
  SphereRays all;
  while (all.rays.size() < count) {
    const glm::vec3 from = 3.f * random.direction(), to = random.in_cube(1);
    const glm::dvec3 o(from), d = glm::normalize(glm::dvec3(to) - o);
    const double middle = -glm::dot(o, d), inside = 1 - glm::dot(o + middle * d, o + middle * d);
    if (inside < 0.05) continue;  // grazing: facets would count
    all.rays.push_back(make_ray(from, glm::vec3(d)));
    all.distances.push_back(middle - std::sqrt(inside));
  }
  return all;
}

struct Errors {
  double median, most;  ///< of half and of 99 % of hits [pixels]
};
Errors errors_of(const std::vector<Hit>& hits, const std::vector<double>& expected, float pixel) {
  std::vector<double> errors;
  for (size_t i = 0; i < hits.size(); ++i)
    errors.push_back(std::fabs(static_cast<double>(hits[i].distance) - expected[i]) / static_cast<double>(pixel));
  std::sort(errors.begin(), errors.end());
  return {errors[errors.size() / 2], errors[errors.size() * 99 / 100]};
}

uint32_t different(const std::vector<Hit>& a, const std::vector<Hit>& b) {
  uint32_t count = 0;
  for (size_t i = 0; i < a.size(); ++i) count += std::memcmp(&a[i], &b[i], sizeof(Hit)) != 0;
  return count;
}

}  // namespace

TEST_CASE("attributes: hits of a sphere are off by a share of a pixel that does not depend on its size") {
  AbufferRig rig(scene_of(sphere({}, 1, full_run() ? 400 : 120)));
  const SphereRays rays = sphere_rays(full_run() ? 200000 : 20000);
  const Bvh bvh(rig.scheduler.device(), rig.scene, rig.buffers);
  std::vector<double> facets;  // which are farther from the sphere than planes from them
  for (const Hit& hit : rig.trace(bvh, rays.rays).hits) facets.push_back(static_cast<double>(hit.distance));
  double coarsest = 0;
  for (const uint32_t size : {320u, 640u, 1280u}) {
    if (size > 640 && !full_run()) continue;
    CAPTURE(size);
    const auto errors = [&](Intersect intersect, Attributes attributes, const std::vector<double>& expected) {
      const VoxelAbuffer structure = rig.make({.abuffer_size = size, .intersect = intersect, .attributes = attributes});
      return errors_of(rig.trace(structure, rays.rays).hits, expected, structure.state().grid.center.w);
    };
    const Errors pixel = errors(Intersect::automatic, Attributes::pixel, rays.distances);
    CHECK(pixel.median <= 0.2);
    CHECK(pixel.most <= 2);
    if (coarsest == 0) coarsest = pixel.median;
    CHECK(std::fabs(pixel.median - coarsest) <= 0.1 * coarsest);
    for (const Attributes attributes : {Attributes::triangle, Attributes::pixel}) {
      const Errors plane = errors(Intersect::plane, attributes, facets);
      MESSAGE(size, ": pixel ", pixel.median, ", ", pixel.most, "; plane ", plane.median, ", ", plane.most);
      CHECK(plane.median <= 0.002);
      CHECK(plane.most <= 0.02);
    }
  }
}

TEST_CASE("attributes: pixel gives the triangle's point at the pixel's centre") {
  AbufferRig rig(scene_of(closed_bodies()));
  const VoxelAbuffer structure =
      rig.make({.abuffer_size = 640, .intersect = Intersect::automatic, .attributes = Attributes::pixel});
  const TestRays rays = scene_rays(rig, 9000, 8);
  const std::vector<Hit> hits = rig.trace(structure, rays.rays, rays.ends).hits;
  const std::vector<float> words = structure.state().triangles.download();
  const AbufferGrid& grid = structure.state().grid;
  uint32_t found = 0, off = 0;
  for (const Hit& hit : hits) {
    if (hit.triangle == LUCARIUM_NO_HIT) continue;
    const float* w = words.data() + size_t{ABUFFER_TRIANGLE_WORDS} * hit.triangle;
    const glm::vec3 a(w[0], w[1], w[2]), b(w[3], w[4], w[5]), c(w[6], w[7], w[8]);
    const glm::vec3 p = (a + hit.u * (b - a) + hit.v * (c - a) - grid.center.xyz() - grid.corner.xyz()) * grid.corner.w;
    uint32_t centred = 0;
    for (int k = 0; k < 3; ++k) centred += std::fabs(p[k] - std::floor(p[k]) - 0.5f) < 0.02f;
    ++found;
    off += centred < 2;
  }
  CHECK(found > 3000);
  CHECK(off <= found / 1000);  // the raster's corners are snapped to 1/256 pixel: some centres lie beside the triangle
}

TEST_CASE("attributes: stored are the bits of the pixel's, material and 32 bytes per fragment") {
  for (const bool lets_pass : {false, true}) {
    Scene scene = scene_of(closed_bodies(), lets_pass ? veil(0.5f) : SceneMaterial());
    scene.materials.insert(scene.materials.begin(), SceneMaterial());  // another one before it
    scene.instances[0].material = 1;
    AbufferRig rig(std::move(scene));
    const TestRays rays = scene_rays(rig, 12000, 4);
    for (const Intersect intersect : {Intersect::automatic, Intersect::plane})
      for (const Search search : {Search::columns, Search::three_steps}) {
        abuffer::VoxelAbufferOptions options{.abuffer_size = 400, .intersect = intersect, .search = search};
        options.attributes = Attributes::pixel;
        const VoxelAbuffer pixel = rig.make(options);
        const size_t estimate = abuffer::estimate_abuffer_bytes(rig.scene, options);
        options.attributes = Attributes::stored;
        const VoxelAbuffer stored = rig.make(options);
        const AbufferRig::Results a = rig.trace(pixel, rays.rays, rays.ends),
                                  b = rig.trace(stored, rays.rays, rays.ends);
        CHECK(different(a.hits, b.hits) == 0);
        CHECK(a.occluded == b.occluded);
        options.attributes = Attributes::triangle;
        CHECK(different(rig.trace(rig.make(options), rays.rays, rays.ends).hits, b.hits) > 3000);
        const size_t fragments = stored.statistics().parity_fragments;
        const size_t more = stored.statistics().bytes - pixel.statistics().bytes;
        CHECK(more >= 24 * fragments);
        CHECK(more <= 27 * fragments + 24 * 5000);
        options.attributes = Attributes::stored;
        const size_t stated = abuffer::estimate_abuffer_bytes(rig.scene, options) - estimate;
        CHECK(stated >= 24 * fragments);
        CHECK(stated <= more);
        const auto attributes = stored.state().parity->attributes().download(0, fragments);
        CHECK(std::all_of(attributes.begin(), attributes.end(),
                          [](const AbufferAttributes& each) { return each.material == 1; }));
      }
  }
}

TEST_CASE("planes: closed meshes, and those with holes, are hit where the hierarchy hits them") {
  for (const bool holes : {false, true}) {
    CAPTURE(holes);
    Soup soup = closed_bodies();
    Random random(12);
    if (holes) std::erase_if(soup.triangles, [&](const Triangle&) { return random.uniform() < 0.02f; });
    AbufferRig rig(scene_of(soup));
    const Bvh bvh(rig.scheduler.device(), rig.scene, rig.buffers);
    const TestRays rays = scene_rays(rig, full_run() ? 300000 : 30000, 3);
    const AbufferRig::Results right = rig.trace(bvh, rays.rays);
    const auto wrong = [&](Intersect intersect) {
      const VoxelAbuffer structure = rig.make({.abuffer_size = full_run() ? 1280u : 640u, .intersect = intersect});
      const AbufferRig::Results found = rig.trace(structure, rays.rays, rays.ends);
      uint32_t count = 0;
      for (size_t i = 0; i < rays.rays.size(); ++i) {
        const bool hit = right.hits[i].triangle != LUCARIUM_NO_HIT, got = found.hits[i].triangle != LUCARIUM_NO_HIT;
        count += hit != got || (hit && std::fabs(right.hits[i].distance - found.hits[i].distance) >
                                           4 * structure.state().grid.center.w);
      }
      return static_cast<double>(count) / static_cast<double>(rays.rays.size());
    };
    const double planes = wrong(Intersect::plane), parity = wrong(Intersect::parity);
    MESSAGE("planes ", planes, " parity ", parity);
    CHECK(planes <= 0.01);
    // With holes parity errs more often, by more than the noise of both counts.
    if (holes) CHECK(parity - planes > 4 * std::sqrt((parity + planes) / static_cast<double>(rays.rays.size())));
  }
}

TEST_CASE("planes: connections between points of surfaces are free where the hierarchy says so") {
  AbufferRig rig(scene_of(closed_bodies()));
  // So coarse that a pixel's neighbours lie in other planes.
  const VoxelAbuffer structure = rig.make({.abuffer_size = 128, .intersect = Intersect::plane});
  const std::vector<float> words = structure.state().triangles.download();
  const auto side = [&](uint32_t end) {
    const float* w = words.data() + size_t{ABUFFER_TRIANGLE_WORDS} * (end & ~LUCARIUM_RAY_END_BACK);
    const glm::vec3 a(w[0], w[1], w[2]), b(w[3], w[4], w[5]), c(w[6], w[7], w[8]);
    return glm::normalize(glm::cross(b - a, c - a)) * (end & LUCARIUM_RAY_END_BACK ? -1.f : 1.f);
  };
  // From surfaces to the begin of the ray before, on the sides that face each other. For the hierarchy they end before
  // the surface there, for planes in it.
  const TestRays rays = scene_rays(rig, 60000, 21);
  TestRays connections;
  std::vector<Ray> shorter;
  for (size_t i = 4; i < rays.rays.size(); i += 3) {
    const glm::vec3 from = rays.rays[i].origin.xyz(), to = rays.rays[i - 3].origin.xyz();
    const uint32_t start = rays.ends[i].start, end = rays.ends[i - 3].start;
    const glm::vec3 d = glm::normalize(to - from);
    if (glm::dot(d, side(start)) <= 0.05f || glm::dot(d, side(end)) >= -0.05f) continue;
    const float off = 1e-4f * rig.scene.bounds().radius() / -glm::dot(d, side(end));
    shorter.push_back(make_ray(from, d, glm::length(to - from)));
    connections.rays.push_back(make_ray(from, d, glm::length(to - from) + off * 1.0001f));
    connections.ends.push_back({start, end});
  }
  const Bvh bvh(rig.scheduler.device(), rig.scene, rig.buffers);
  const std::vector<uint32_t> right = rig.trace(bvh, shorter).occluded,
                              found = rig.trace(structure, connections.rays, connections.ends).occluded;
  uint32_t free = 0, wrong = 0;
  for (size_t i = 0; i < right.size(); ++i) {
    free += !right[i];
    wrong += right[i] != found[i];
  }
  MESSAGE(wrong, " of ", right.size(), ", free ", free);
  CHECK(free > right.size() / 20);
  CHECK(wrong <= right.size() / 100);
}

TEST_CASE("planes: of sheets in one voxel the nearest is hit") {
  Soup sheets;
  for (uint32_t i = 0; i < 50; ++i) {
    const float z = 0.02f * static_cast<float>(i);
    sheets.add_triangle({-3, -3, z}, {3, -3, z}, {0, 3, z});
  }
  AbufferRig rig(scene_of(sheets));
  for (const uint32_t grid : {16u, 64u}) {
    const VoxelAbuffer structure = rig.make({.abuffer_size = 640, .grid_size = grid, .intersect = Intersect::plane});
    Random random(3);
    std::vector<Ray> rays;
    for (int i = 0; i < 1000; ++i) {
      const glm::vec3 to(random.uniform(-0.9f, 0.9f), random.uniform(-2, 0), i % 2 ? 0.98f : 0.f);
      const glm::vec3 from(to.x + random.uniform(-0.1f, 0.1f), to.y + random.uniform(-0.1f, 0.1f), i % 2 ? 3.f : -3.f);
      rays.push_back(make_ray(from, glm::normalize(to - from)));
    }
    const std::vector<Hit> hits = rig.trace(structure, rays).hits;
    uint32_t wrong = 0;
    for (size_t i = 0; i < hits.size(); ++i) wrong += hits[i].triangle != (i % 2 ? 49u : 0u);
    CHECK(wrong == 0);
  }
}

TEST_CASE("planes: a wall is met where it stands on a floor, whose voxels are searched along the other axis") {
  Soup soup = box({-3, -0.1f, -3}, {3, 0, 3});
  append(soup, box({-0.4f, 0.01f, -0.4f}, {0.4f, 1, 0.4f}));
  AbufferRig rig(scene_of(soup));
  const Bvh bvh(rig.scheduler.device(), rig.scene, rig.buffers);
  const VoxelAbuffer structure = rig.make({.abuffer_size = 256, .intersect = Intersect::plane});
  Random random(3);
  std::vector<Ray> rays;
  for (int i = 0; i < 4000; ++i) {
    const glm::vec3 from(random.uniform(-1, 1), random.uniform(0.2f, 0.5f), 2.5f);
    rays.push_back(make_ray(
        from, glm::normalize(glm::vec3(random.uniform(-0.35f, 0.35f), random.uniform(0.04f, 0.15f), 0.4f) - from)));
  }
  const std::vector<Hit> right = rig.trace(bvh, rays).hits, found = rig.trace(structure, rays).hits;
  uint32_t wrong = 0;
  for (size_t i = 0; i < rays.size(); ++i)
    wrong += !(std::fabs(right[i].distance - found[i].distance) <= 4 * structure.state().grid.center.w);
  MESSAGE(wrong, " wrong");
  CHECK(wrong <= rays.size() / 200);
}
