// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <memory>
#include <vector>

#include "lucarium/compute/schedule/scheduler.h"
#include "lucarium/services/bvh/bvh.h"
#include "triangle_soups.h"

namespace lucarium::test {

inline constexpr BvhTraversal traversals[] = {BvhTraversal::wide_16, BvhTraversal::wide_8,
                                              BvhTraversal::wide_16_portable, BvhTraversal::wide_8_portable,
                                              BvhTraversal::scalar};

struct Results {
  std::vector<Hit> hits;
  std::vector<uint32_t> occluded;
};

/// Rays from within ±half: all directions, one in three of finite length, one in seven along an axis.
inline std::vector<Ray> random_rays(uint32_t count, uint32_t seed, float half = 12) {
  std::vector<Ray> rays;
  Random random(seed);
  for (uint32_t i = 0; i < count; ++i) {
    Ray ray = make_ray(random.in_cube(half), random.direction());
    if (i % 3 == 0) ray.direction.w = random.uniform(0, half);
    if (i % 7 == 0) {  // along an axis, with zeros of both signs
      const uint32_t axis = random.below(3);
      glm::vec3 d(0.f);
      d[axis] = i & 1 ? 1.f : -1.f;
      d[(axis + 1) % 3] = -0.f;
      ray.direction = float4(d, ray.direction.w);
    }
    rays.push_back(ray);
  }
  return rays;
}

/// Device, scheduler and the two passes over a ray buffer.
class Tracer {
 public:
  explicit Tracer(const DeviceOptions& options = {}) : device_(Device::open(options)), scheduler_(device_) {}
  Device& device() { return *device_; }

  /// Traces the first `count` rays of a buffer of `capacity`; the rest of the results keeps 0xee bytes. `row`: of
  /// RayBuffers.
  Results trace(const Bvh& bvh, const std::vector<Ray>& rays, uint32_t count, uint32_t capacity, uint32_t row = 0) {
    const TypedBuffer<Ray> ray_buffer(*device_, "test", "rays", rays);
    TypedBuffer<Hit> hits(*device_, "test", "hits", rays.size());
    TypedBuffer<uint32_t> occluded(*device_, "test", "occluded", rays.size());
    const std::vector<std::byte> untouched(rays.size() * sizeof(Hit), std::byte{0xee});
    hits.write(untouched.data(), rays.size() * sizeof(Hit));
    occluded.write(untouched.data(), rays.size() * sizeof(uint32_t));
    const TypedBuffer<uint32_t> counter(*device_, "test", "counter", std::vector<uint32_t>{77, count});
    ScheduleRecorder recorder = scheduler_.record("trace", "test");
    bvh.record_closest(recorder, "closest", {ray_buffer, counter, 1, capacity, {}, row}, hits);
    bvh.record_any(recorder, "any", {ray_buffer, counter, 1, capacity}, occluded);
    Schedule schedule = recorder.compile();
    scheduler_.run(schedule);
    scheduler_.finish();
    return {hits.download(), occluded.download()};
  }
  Results trace(const Bvh& bvh, const std::vector<Ray>& rays) {
    return trace(bvh, rays, static_cast<uint32_t>(rays.size()), static_cast<uint32_t>(rays.size()));
  }
  Bvh make(const Soup& soup, BvhTraversal traversal = BvhTraversal::wide) {
    return Bvh(*device_, soup.vertices, soup.triangles, traversal);
  }

 private:
  std::shared_ptr<Device> device_;
  KernelScheduler scheduler_;
};

}  // namespace lucarium::test
