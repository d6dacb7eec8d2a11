// SPDX-License-Identifier: Apache-2.0
// Search by parity: against the hierarchy's hits, and the states of points against closed forms.
#include <doctest/doctest.h>

#include <array>
#include <cmath>

#include "../../framework/services/layered_raster/scene.h"
#include "abuffer_rig.h"
#include "lucarium/scene/builtin/scenes.h"
#include "test_support.h"
#include "tolerance.h"
#include "voxel_abuffer/structure/state.h"

using namespace lucarium;
using namespace lucarium::test;
using abuffer::Intersect;
using abuffer::Search;
using abuffer::VoxelAbuffer;

namespace {

void append(Soup& soup, const Soup& more) {
  const auto first = static_cast<uint32_t>(soup.vertices.size());
  soup.vertices.insert(soup.vertices.end(), more.vertices.begin(), more.vertices.end());
  for (const Triangle& t : more.triangles) soup.triangles.push_back({first + t.v0, first + t.v1, first + t.v2, 0});
}

/// A point of a parametric surface that closes around both parameters (torus) or between poles (sphere).
template <class Point>
Soup surface(uint32_t rings, uint32_t segments, const Point& point) {
  Soup soup;
  for (uint32_t ring = 0; ring < rings; ++ring)
    for (uint32_t segment = 0; segment < segments; ++segment)
      soup.add_vertex(point(6.2831853f * static_cast<float>(ring) / static_cast<float>(rings),
                            6.2831853f * static_cast<float>(segment) / static_cast<float>(segments)));
  const auto at = [&](uint32_t ring, uint32_t segment) { return ring % rings * segments + segment % segments; };
  for (uint32_t ring = 0; ring < rings; ++ring)
    for (uint32_t segment = 0; segment < segments; ++segment) {
      soup.triangles.push_back({at(ring, segment), at(ring + 1, segment), at(ring + 1, segment + 1), 0});
      soup.triangles.push_back({at(ring, segment), at(ring + 1, segment + 1), at(ring, segment + 1), 0});
    }
  return soup;
}

/// Around the y axis, radii 1 and 0.4.
Soup torus() {
  return surface(160, 80, [](float around, float across) {
    const float r = 1 + 0.4f * std::cos(across);
    return glm::vec3(r * std::cos(around), -0.4f * std::sin(across), -r * std::sin(around));
  });
}

Soup sphere(const glm::vec3& center, float radius) {
  Soup soup;
  const uint32_t rings = 80, segments = 160;
  const uint32_t top = soup.add_vertex(center + glm::vec3(0, radius, 0)),
                 bottom = soup.add_vertex(center - glm::vec3(0, radius, 0));
  for (uint32_t ring = 1; ring < rings; ++ring)
    for (uint32_t s = 0; s < segments; ++s) {
      const float polar = 3.14159265f * static_cast<float>(ring) / static_cast<float>(rings),
                  azimuth = 6.2831853f * static_cast<float>(s) / static_cast<float>(segments);
      soup.add_vertex(center + radius * glm::vec3(std::sin(polar) * std::cos(azimuth), std::cos(polar),
                                                  std::sin(polar) * std::sin(azimuth)));
    }
  const auto at = [&](uint32_t ring, uint32_t s) { return 2 + (ring - 1) * segments + s % segments; };
  for (uint32_t s = 0; s < segments; ++s) {
    soup.triangles.push_back({top, at(1, s + 1), at(1, s), 0});
    soup.triangles.push_back({bottom, at(rings - 1, s), at(rings - 1, s + 1), 0});
    for (uint32_t ring = 1; ring + 1 < rings; ++ring) {
      soup.triangles.push_back({at(ring, s), at(ring, s + 1), at(ring + 1, s), 0});
      soup.triangles.push_back({at(ring, s + 1), at(ring + 1, s + 1), at(ring + 1, s), 0});
    }
  }
  return soup;
}

/// Sphere and torus, apart, turned off the axes.
Soup bodies() {
  Soup soup = torus();
  append(soup, sphere({0.2f, 1.1f, 0.3f}, 0.6f));
  const glm::vec3 axis = glm::normalize(glm::vec3(1, 2, 3));
  for (Vertex& v : soup.vertices) {
    const glm::vec3 p = v.position.xyz();
    const float c = std::cos(0.7f), s = std::sin(0.7f);
    v.position = float4(c * p + s * glm::cross(axis, p) + (1 - c) * glm::dot(axis, p) * axis, 0.f);
  }
  return soup;
}

struct Rates {
  double missed = 0, invented = 0, far = 0, occlusion = 0;
};

/// Where rays start.
enum Start { camera, front, back };
Start start_of(const RayEnds& ends) {
  return ends.start == LUCARIUM_NONE ? camera : ends.start & LUCARIUM_RAY_END_BACK ? back : front;
}

/// Rays told wrongly, per ray, by where they start; far: hits more than four pixels off.
std::array<Rates, 3> compare(AbufferRig& rig, const VoxelAbuffer& structure, const TestRays& rays) {
  const Bvh bvh(rig.scheduler.device(), rig.scene, rig.buffers);
  const AbufferRig::Results right = rig.trace(bvh, rays.rays),
                            found = rig.trace(structure, rays.rays, rays.ends);
  const float h = structure.state().grid.center.w;
  std::array<Rates, 3> all;
  for (size_t i = 0; i < rays.rays.size(); ++i) {
    Rates& rates = all[start_of(rays.ends[i])];
    const double one = 3.0 / static_cast<double>(rays.rays.size());  // about a third of each
    const bool hit = right.hits[i].triangle != LUCARIUM_NO_HIT, got = found.hits[i].triangle != LUCARIUM_NO_HIT;
    if (hit && !got) rates.missed += one;
    if (!hit && got) rates.invented += one;
    if (hit && got && std::fabs(right.hits[i].distance - found.hits[i].distance) > 4 * h) rates.far += one;
    if (right.occluded[i] != found.occluded[i]) rates.occlusion += one;
  }
  return all;
}

}  // namespace

TEST_CASE("parity hits closed bodies where the hierarchy does") {
  AbufferRig rig(scene_of(bodies()));
  const TestRays rays = scene_rays(rig, full_run() ? 1000000 : 60000, 3);
  for (const auto& [search, miss] : {std::pair{Search::columns, 0.001}, {Search::three_steps, 0.002},
                                     {Search::one_step, 0.005}}) {
    CAPTURE(static_cast<int>(search));
    const VoxelAbuffer structure = rig.make({.intersect = Intersect::automatic, .search = search});
    CHECK(structure.statistics().exact_triangles == 0);
    CHECK(structure.statistics().unbalanced_columns == 0);
    const std::array<Rates, 3> all = compare(rig, structure, rays);
    for (const Rates& rates : all) {
    MESSAGE(rates.missed, " missed, ", rates.invented, " invented, ", rates.far, " far, ", rates.occlusion, " any");
    CHECK(rates.missed + rates.invented <= miss);
    CHECK(rates.occlusion <= 2 * miss);
    CHECK(rates.far <= 0.006);
    }
  }
}
