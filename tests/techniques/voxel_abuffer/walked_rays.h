// SPDX-License-Identifier: Apache-2.0
// Rays as a path tracer makes them in a scene, what the hierarchy says of them, and how another intersector errs.
#pragma once
#include "abuffer_rig.h"

namespace lucarium::test {

/// Rays from an eye, cosine-distributed bounces off their hits, those of these, and connections
/// between their points.
struct WalkedRays {
  struct Group {
    std::string name;
    TestRays rays;
    std::vector<Hit> hits;           ///< of the hierarchy
    std::vector<uint32_t> occluded;  ///< of rays that end short of their ends' surfaces
  };
  std::vector<Group> groups;
};

/// Corners of all triangles, world space.
struct HostTriangles {
  std::vector<Vertex> vertices;
  std::vector<Triangle> triangles;
  explicit HostTriangles(const SceneBuffers& buffers)
      : vertices(buffers.scene_vertices.download()),
        triangles(buffers.scene_triangles.download(0, buffers.info().triangle_count)) {}
  glm::vec3 corner(uint32_t triangle, int k) const {
    const Triangle& t = triangles[triangle];
    return vertices[k == 0 ? t.v0 : k == 1 ? t.v1 : t.v2].position.xyz();
  }
  /// Unit normal of a triangle, or of a ray's end on its side.
  glm::vec3 normal(uint32_t end) const {
    const uint32_t t = end & ~LUCARIUM_RAY_END_BACK;
    const glm::vec3 n = glm::normalize(glm::cross(corner(t, 1) - corner(t, 0), corner(t, 2) - corner(t, 0)));
    return end & LUCARIUM_RAY_END_BACK ? -n : n;
  }
};

/// `eye`: rays go from there to random points within the scene's bounds.
inline WalkedRays walk_rays(AbufferRig& rig, const glm::vec3& eye, uint32_t count, uint32_t seed) {
  const HostTriangles host(rig.buffers);
  const Bvh bvh(rig.scheduler.device(), rig.scene, rig.buffers);
  const Bounds bounds = rig.scene.bounds();
  const float off = 1e-4f * bounds.radius();
  Random random(seed);
  const auto seeded = [&](Ray ray) {
    const uint32_t bits = random.below(1u << 30) + 1;
    std::memcpy(&ray.origin.w, &bits, sizeof(bits));
    return ray;
  };
  WalkedRays all;
  WalkedRays::Group first{"eye", {}, {}, {}};
  for (uint32_t i = 0; i < count; ++i) {
    const glm::vec3 place(random.uniform(), random.uniform(), random.uniform());
    const glm::vec3 to = bounds.min + (bounds.max - bounds.min) * place;
    first.rays.rays.push_back(seeded(make_ray(eye, glm::normalize(to - eye))));
    first.rays.ends.push_back({LUCARIUM_NONE, LUCARIUM_NONE});
  }
  all.groups.push_back(first);
  std::vector<glm::vec3> points;
  std::vector<uint32_t> sides;
  for (const char* name : {"first bounce", "second bounce"}) {
    WalkedRays::Group& last = all.groups.back();
    const AbufferRig::Results right = rig.trace(bvh, last.rays.rays);
    last.hits = right.hits;
    last.occluded = right.occluded;
    WalkedRays::Group next{name, {}, {}, {}};
    for (size_t i = 0; i < last.hits.size(); ++i) {
      const Hit& hit = last.hits[i];
      if (hit.triangle == LUCARIUM_NO_HIT) continue;
      const Ray& ray = last.rays.rays[i];
      const bool back = glm::dot(host.normal(hit.triangle), ray.direction.xyz()) > 0;
      const uint32_t side = hit.triangle | (back ? LUCARIUM_RAY_END_BACK : 0);
      const glm::vec3 n = host.normal(side);
      const glm::vec3 point = ray.origin.xyz() + hit.distance * ray.direction.xyz() + off * n;
      points.push_back(point);
      sides.push_back(side);
      next.rays.rays.push_back(seeded(make_ray(point, glm::normalize(1.0001f * n + random.direction()))));
      next.rays.ends.push_back({side, LUCARIUM_NONE});
    }
    all.groups.push_back(next);
  }
  const AbufferRig::Results right = rig.trace(bvh, all.groups.back().rays.rays);
  all.groups.back().hits = right.hits;
  all.groups.back().occluded = right.occluded;
  // From every point to a random one that faces it: the ray ends in the other's surface, or for the hierarchy just
  // before.
  WalkedRays::Group connections{"connections", {}, {}, {}};
  std::vector<Ray> shorter;
  for (size_t i = 0; i < points.size(); ++i) {
    const size_t j = random.below(static_cast<uint32_t>(points.size()));
    const glm::vec3 n = host.normal(sides[i]), m = host.normal(sides[j]), way = points[j] - points[i];
    const float length = glm::length(way);
    const glm::vec3 d = way / length;
    if (!(glm::dot(d, n) > 0.02f && glm::dot(d, m) < -0.02f)) continue;
    const Ray ray = seeded(make_ray(points[i], d, length));
    shorter.push_back(ray);
    connections.rays.rays.push_back(ray);
    connections.rays.ends.push_back({sides[i], sides[j]});
  }
  connections.occluded = rig.trace(bvh, shorter).occluded;
  all.groups.push_back(connections);
  return all;
}

/// How an intersector errs, per ray.
struct WalkErrors {
  uint32_t rays = 0, missed = 0, invented = 0, far = 0, turned = 0, occlusion = 0;
  double of(uint32_t count) const { return static_cast<double>(count) / std::max(1u, rays); }
};

/// far: more than four pixels off; turned: the triangle that is hit looks elsewhere.
inline WalkErrors walk_errors(AbufferRig& rig, const abuffer::VoxelAbuffer& structure, const WalkedRays::Group& group,
                              float pixel) {
  const HostTriangles host(rig.buffers);
  const AbufferRig::Results found = rig.trace(structure, group.rays.rays, group.rays.ends);
  WalkErrors errors;
  errors.rays = static_cast<uint32_t>(group.rays.rays.size());
  for (size_t i = 0; i < group.rays.rays.size(); ++i) {
    errors.occlusion += found.occluded[i] != group.occluded[i];
    if (!group.hits.empty()) {
      const Hit &a = group.hits[i], &b = found.hits[i];
      const bool hit = a.triangle != LUCARIUM_NO_HIT, got = b.triangle != LUCARIUM_NO_HIT;
      errors.missed += hit && !got;
      errors.invented += !hit && got;
      const bool far = hit && got && !(std::fabs(a.distance - b.distance) <= 4 * pixel);
      errors.far += far;
      if (hit && got && !far) errors.turned += glm::dot(host.normal(a.triangle), host.normal(b.triangle)) < 0.9f;
    }
  }
  return errors;
}

}  // namespace lucarium::test
