// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cmath>
#include <cstring>
#include <memory>
#include <string>
#include <vector>

#include "../../framework/services/bvh/triangle_soups.h"
#include "lucarium/compute/schedule/scheduler.h"
#include "lucarium/scene/device/scene_buffers.h"
#include "lucarium/services/bvh/bvh.h"
#include "voxel_abuffer/structure/voxel_abuffer.h"

namespace lucarium::test {

/// A scene on a device.
struct AbufferRig {
  explicit AbufferRig(Scene scene_, const DeviceOptions& options = {})
      : scene(std::move(scene_)), scheduler(Device::open(options)), buffers(scheduler.device(), scene) {}

  abuffer::VoxelAbuffer make(const abuffer::VoxelAbufferOptions& options = {}) {
    return abuffer::VoxelAbuffer(scheduler, scene, buffers, options);
  }

  struct Results {
    std::vector<Hit> hits;
    std::vector<uint32_t> occluded;
  };
  Results trace(const Intersector& intersector, const std::vector<Ray>& rays, std::vector<RayEnds> ends = {}) {
    const auto count = static_cast<uint32_t>(rays.size());
    ends.resize(rays.size(), {LUCARIUM_NONE, LUCARIUM_NONE});
    const TypedBuffer<RayEnds> end_buffer(scheduler.device(), "test", "ends", ends);
    const TypedBuffer<Ray> ray_buffer(scheduler.device(), "test", "rays", rays);
    const TypedBuffer<Hit> hits(scheduler.device(), "test", "hits", rays.size());
    const TypedBuffer<uint32_t> occluded(scheduler.device(), "test", "occluded", rays.size());
    const TypedBuffer<uint32_t> counter(scheduler.device(), "test", "counter", std::vector<uint32_t>{count});
    ScheduleRecorder recorder = scheduler.record("trace", "test");
    intersector.record_closest(recorder, "closest", {ray_buffer, counter, 0, count, end_buffer}, hits);
    intersector.record_any(recorder, "any", {ray_buffer, counter, 0, count, end_buffer}, occluded);
    Schedule schedule = recorder.compile();
    scheduler.run(schedule);
    scheduler.finish();
    return {hits.download(), occluded.download()};
  }

  Scene scene;
  KernelScheduler scheduler;
  SceneBuffers buffers;
};

/// Rays whose hits, or whether they are blocked, differ in any bit.
inline size_t differences(const AbufferRig::Results& x, const AbufferRig::Results& y) {
  size_t count = 0;
  for (size_t i = 0; i < x.hits.size(); ++i)
    count += std::memcmp(&x.hits[i], &y.hits[i], sizeof(Hit)) != 0 || x.occluded[i] != y.occluded[i];
  return count;
}

/// What lets rays pass by chance (BLEND) or by its cutoff of 0.5 (MASK).
inline SceneMaterial veil(float alpha, AlphaMode mode = AlphaMode::blend) {
  SceneMaterial material;
  material.alpha_mode = mode;
  material.base_color.a = alpha;
  return material;
}

/// Rays as rendering makes them: a third from around the first camera's place, the others from points of surfaces (both
/// sides), half of these cosine-distributed and half to points within the scene's bounds. Seeds are 1, 2, …
struct TestRays {
  std::vector<Ray> rays;
  std::vector<RayEnds> ends;
};
inline TestRays scene_rays(const AbufferRig& rig, uint32_t count, uint32_t seed) {
  const std::vector<Vertex> vertices = rig.buffers.scene_vertices.download();
  const std::vector<Triangle> triangles = rig.buffers.scene_triangles.download(0, rig.buffers.info().triangle_count);
  const Bounds bounds{rig.buffers.info().bounds_min.xyz(), rig.buffers.info().bounds_max.xyz()};
  const glm::vec3 eye =
      rig.scene.cameras.empty() ? bounds.min - glm::vec3(1) : glm::vec3(rig.scene.cameras[0].world_from_camera[3]);
  Random random(seed);
  const auto inside = [&] {
    return bounds.min + (bounds.max - bounds.min) * glm::vec3(random.uniform(), random.uniform(), random.uniform());
  };
  TestRays result;
  for (uint32_t i = 0; i < count; ++i) {
    Ray ray;
    RayEnds ends{LUCARIUM_NONE, LUCARIUM_NONE};
    if (i % 3 == 0 || triangles.empty()) {
      ray = make_ray(eye, glm::normalize(inside() - eye));
    } else {
      ends.start = random.below(static_cast<uint32_t>(triangles.size()));
      const Triangle& t = triangles[ends.start];
      const glm::vec3 a = vertices[t.v0].position.xyz(), b = vertices[t.v1].position.xyz(),
                      c = vertices[t.v2].position.xyz();
      const float root = std::sqrt(random.uniform()), v = random.uniform() * root;
      const glm::vec3 point = (1 - root) * a + (root - v) * b + v * c;
      glm::vec3 n = glm::cross(b - a, c - a);
      n = glm::dot(n, n) > 0 ? glm::normalize(n) : glm::vec3(0, 1, 0);
      const glm::vec3 target = inside();
      const bool bounces = i % 3 == 1;
      // Rays leave on the side to which they go.
      if (bounces ? random.uniform() < 0.5f : glm::dot(target - point, n) < 0) {
        n = -n;
        ends.start |= LUCARIUM_RAY_END_BACK;
      }
      const glm::vec3 origin = point + 1e-4f * bounds.radius() * n;
      if (bounces)
        ray = make_ray(origin, glm::normalize(1.0001f * n + random.direction()));
      else
        ray = make_ray(origin, glm::normalize(target - origin), glm::length(target - origin));
    }
    const uint32_t bits = i + 1;
    std::memcpy(&ray.origin.w, &bits, sizeof(bits));
    result.rays.push_back(ray);
    result.ends.push_back(ends);
  }
  return result;
}

}  // namespace lucarium::test
