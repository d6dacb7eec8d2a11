// SPDX-License-Identifier: Apache-2.0
// Rays by parity against closed forms: a glass sphere, a room that nothing leaves, and errors over the resolution.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "../../framework/services/layered_raster/scene.h"
#include "closed_bodies.h"
#include "compared_rig.h"
#include "test_support.h"
#include "voxel_abuffer/structure/state.h"

using namespace lucarium;
using namespace lucarium::test;
using abuffer::Intersect;
using abuffer::Search;
using abuffer::VoxelAbuffer;

namespace {

/// Where a ray in the unit ball from its surface leaves it.
glm::dvec3 across_ball(const glm::dvec3& p, const glm::dvec3& d) { return p - 2 * glm::dot(p, d) * d; }

/// A closed room about the origin, turned off the axes.
Soup turned_room() {
  Soup room = box({-5, -3, -4}, {5, 3, 4});
  for (Triangle& t : room.triangles) std::swap(t.v1, t.v2);  // fronts inside
  const glm::vec3 axis = glm::normalize(glm::vec3(1, 2, 3));
  for (Vertex& v : room.vertices) {
    const glm::vec3 p = v.position.xyz();
    const float c = std::cos(0.7f), s = std::sin(0.7f);
    v.position = float4(c * p + s * glm::cross(axis, p) + (1 - c) * glm::dot(axis, p) * axis, 0.f);
  }
  return room;
}

}  // namespace

TEST_CASE("closed forms: light is refracted through a glass sphere to where it should be") {
  const double ratio = 1 / 1.5;
  AbufferRig rig(scene_of(sphere({}, 1, full_run() ? 400 : 160)));
  Random random(5);
  EndedRays entering;
  std::vector<glm::dvec3> exits;
  while (exits.size() < (full_run() ? 200000 : 20000)) {
    const glm::dvec3 o(3.f * random.direction()), d = glm::normalize(glm::dvec3(random.in_cube(1)) - o);
    const double middle = -glm::dot(o, d), inside = 1 - glm::dot(o + middle * d, o + middle * d);
    if (inside < 0.05) continue;  // grazing: facets would count
    const glm::dvec3 p = o + (middle - std::sqrt(inside)) * d;
    entering.add(make_ray(glm::vec3(o), glm::vec3(d)), {LUCARIUM_NONE, LUCARIUM_NONE});
    exits.push_back(across_ball(p, glm::refract(d, p, ratio)));
  }
  for (const Search search : {Search::columns, Search::three_steps}) {
    CAPTURE(static_cast<int>(search));
    const VoxelAbuffer structure = rig.make({.search = search});
    const double h = static_cast<double>(structure.state().grid.center.w);
    const std::vector<Hit> first = trace(rig, structure, entering).hits;
    EndedRays within;
    uint32_t missed = 0;
    for (size_t i = 0; i < first.size(); ++i) {
      missed += first[i].triangle == LUCARIUM_NO_HIT;
      if (missed) break;
      const Ray& ray = entering.rays[i];
      const glm::dvec3 d(ray.direction.xyz()), p = glm::dvec3(ray.origin.xyz()) + double{first[i].distance} * d;
      const glm::dvec3 refracted = glm::refract(d, glm::normalize(p), ratio);
      within.add(make_ray(glm::vec3(p), glm::vec3(refracted)),
                 {first[i].triangle | LUCARIUM_RAY_END_BACK, LUCARIUM_NONE});
    }
    REQUIRE(missed == 0);
    const std::vector<Hit> second = trace(rig, structure, within).hits;
    std::vector<double> errors;
    for (size_t i = 0; i < second.size(); ++i) {
      const Ray& ray = within.rays[i];
      const glm::dvec3 p = glm::dvec3(ray.origin.xyz()) + double{second[i].distance} * glm::dvec3(ray.direction.xyz());
      missed += second[i].triangle == LUCARIUM_NO_HIT;
      errors.push_back(glm::length(p - exits[i]) / h);
    }
    std::sort(errors.begin(), errors.end());
    MESSAGE("errors [pixels]: median ", errors[errors.size() / 2], ", 99 % ", errors[errors.size() * 99 / 100],
            ", largest ", errors.back());
    CHECK(missed == 0);
    CHECK(errors.back() <= 2);
  }
}

TEST_CASE("closed forms: nothing leaves a closed room") {
  AbufferRig rig(scene_of(turned_room()));
  const uint32_t batches = full_run() ? 10 : 1, per_batch = full_run() ? 1000000 : 200000;
  const VoxelAbuffer exact = rig.make({.intersect = Intersect::exact}), parity = rig.make();
  CHECK(parity.statistics().exact_triangles == 0);
  uint32_t rays = 0, from_exact = 0, from_parity = 0;
  for (uint32_t batch = 0; batch < batches; ++batch) {
    const EndedRays all = bounce_rays(rig, 2 * per_batch, 11 + batch);
    EndedRays inside;
    for (size_t i = 0; i < all.rays.size(); ++i)
      if (!(all.ends[i].start & LUCARIUM_RAY_END_BACK)) inside.add(all.rays[i], all.ends[i]);
    Random random(batch);
    for (size_t i = 0; i < inside.rays.size() / 8; ++i)  // and from an eye in the room
      inside.add(make_ray({0.3f, 0.4f, -0.2f}, random.direction()), {LUCARIUM_NONE, LUCARIUM_NONE});
    const auto escapes = [&](const VoxelAbuffer& structure) {
      const AbufferRig::Results found = trace(rig, structure, inside);
      uint32_t count = 0;
      for (size_t i = 0; i < inside.rays.size(); ++i)
        count += found.hits[i].triangle == LUCARIUM_NO_HIT || !found.occluded[i];
      return count;
    };
    rays += static_cast<uint32_t>(inside.rays.size());
    from_exact += escapes(exact);
    from_parity += escapes(parity);
  }
  MESSAGE(from_exact, " and ", from_parity, " of ", rays);
  CHECK(rays >= batches * per_batch);
  CHECK(from_exact == 0);
  CHECK(static_cast<double>(from_parity) <= 1e-5 * rays);
}

TEST_CASE("closed forms: rays by parity that miss and that hit wrongly halve when pixels do") {
  AbufferRig rig(scene_of(closed_bodies()));
  const TestRays rays = scene_rays(rig, full_run() ? 2000000 : 240000, 3);
  const Bvh bvh(rig.scheduler.device(), rig.scene, rig.buffers);
  const AbufferRig::Results right = rig.trace(bvh, rays.rays);
  double before = 0, first = 0;
  for (const uint32_t size : {320u, 640u, 1280u, 2560u}) {
    if (size == 2560 && !full_run()) continue;
    CAPTURE(size);
    const AbufferRig::Results found = rig.trace(rig.make({.abuffer_size = size}), rays.rays, rays.ends);
    double wrong = 0;
    for (size_t i = 0; i < rays.rays.size(); ++i)
      wrong += (right.hits[i].triangle == LUCARIUM_NO_HIT) != (found.hits[i].triangle == LUCARIUM_NO_HIT);
    MESSAGE(size, ": ", wrong, " of ", rays.rays.size());
    // Counts: standard deviation is their root.
    if (before > 0) CHECK(wrong <= 0.5 * before + 4 * std::sqrt(wrong + 0.25 * before));
    CHECK(wrong > 0);
    before = wrong;
    if (size == 320) {
      first = wrong;
      continue;
    }
    // All doublings together, in which noise counts less.
    const double share = 320.0 / size;
    CHECK(wrong <= share * first + 3 * std::sqrt(wrong + share * share * first));
  }
}
