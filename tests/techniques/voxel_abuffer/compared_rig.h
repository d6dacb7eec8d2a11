// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstring>
#include <vector>

#include "abuffer_rig.h"

namespace lucarium::test {

/// Rays that know the surfaces at their ends.
struct EndedRays {
  std::vector<Ray> rays;
  std::vector<RayEnds> ends;

  void add(Ray ray, RayEnds of) {
    const auto seed = static_cast<uint32_t>(rays.size() + 1);
    std::memcpy(&ray.origin.w, &seed, sizeof(seed));
    rays.push_back(ray);
    ends.push_back(of);
  }
};

/// Points of surfaces, their sides and normals.
class SurfacePoints {
 public:
  explicit SurfacePoints(const AbufferRig& rig)
      : vertices_(rig.buffers.scene_vertices.download()),
        triangles_(rig.buffers.scene_triangles.download(0, rig.buffers.info().triangle_count)) {}

  struct Point {
    glm::vec3 position, normal;  ///< of the side
    uint32_t end;
  };
  Point draw(Random& random) const {
    const uint32_t index = random.below(static_cast<uint32_t>(triangles_.size()));
    const Triangle& t = triangles_[index];
    const glm::vec3 a = vertices_[t.v0].position.xyz(), b = vertices_[t.v1].position.xyz(),
                    c = vertices_[t.v2].position.xyz();
    const float root = std::sqrt(random.uniform()), v = random.uniform() * root;
    const glm::vec3 n = glm::normalize(glm::cross(b - a, c - a));
    const bool back = random.uniform() < 0.5f;
    return {(1 - root) * a + (root - v) * b + v * c, back ? -n : n, index | (back ? LUCARIUM_RAY_END_BACK : 0)};
  }

 private:
  std::vector<Vertex> vertices_;
  std::vector<Triangle> triangles_;
};

/// From the first camera's place to points within the scene's bounds.
inline EndedRays camera_rays(const AbufferRig& rig, uint32_t count, uint32_t seed) {
  const Bounds bounds{rig.buffers.info().bounds_min.xyz(), rig.buffers.info().bounds_max.xyz()};
  const glm::vec3 eye(rig.scene.cameras.at(0).world_from_camera[3]);
  Random random(seed);
  EndedRays result;
  for (uint32_t i = 0; i < count; ++i) {
    const glm::vec3 part(random.uniform(), random.uniform(), random.uniform());
    const glm::vec3 target = bounds.min + (bounds.max - bounds.min) * part;
    result.add(make_ray(eye, glm::normalize(target - eye)), {LUCARIUM_NONE, LUCARIUM_NONE});
  }
  return result;
}

/// From points of surfaces, cosine-distributed.
inline EndedRays bounce_rays(const AbufferRig& rig, uint32_t count, uint32_t seed) {
  const SurfacePoints points(rig);
  Random random(seed);
  EndedRays result;
  for (uint32_t i = 0; i < count; ++i) {
    const SurfacePoints::Point p = points.draw(random);
    const glm::vec3 direction = glm::normalize(1.0001f * p.normal + random.direction());
    result.add(make_ray(p.position + 1e-5f * p.normal, direction), {p.end, LUCARIUM_NONE});
  }
  return result;
}

/// Between points of surfaces that face each other.
inline EndedRays connections(const AbufferRig& rig, uint32_t count, uint32_t seed) {
  const SurfacePoints points(rig);
  Random random(seed);
  EndedRays result;
  while (result.rays.size() < count) {
    const SurfacePoints::Point p = points.draw(random), q = points.draw(random);
    const glm::vec3 from = p.position + 1e-5f * p.normal, way = q.position + 1e-5f * q.normal - from;
    if (glm::dot(way, p.normal) <= 0 || glm::dot(way, q.normal) >= 0) continue;
    result.add(make_ray(from, glm::normalize(way), glm::length(way)), {p.end, q.end});
  }
  return result;
}

inline AbufferRig::Results trace(AbufferRig& rig, const Intersector& intersector, const EndedRays& batch) {
  return rig.trace(intersector, batch.rays, batch.ends);
}

}  // namespace lucarium::test
