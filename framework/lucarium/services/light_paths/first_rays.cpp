// SPDX-License-Identifier: Apache-2.0
#include "lucarium/services/light_paths/first_rays.h"

#include "lucarium/compute/program/source_library.h"
#include "lucarium/shared/light_path.h"

namespace lucarium {
namespace {

constexpr size_t kSlice = 1 << 16;

}  // namespace

FirstRays::FirstRays(Device& device)
    : primitives_(device),
      program_(device, SourceLibrary(),
               {.name = "services/first_rays", .files = {"lucarium/services/light_paths/first_rays.cl"}}) {}

bool FirstRays::pays(const SceneBuffers& scene, const Intersector& intersector, uint32_t paths, uint32_t kinds) {
  if (paths < kFewest || intersector.wants_ends()) return false;
  const uint32_t count = scene.info().light_count;
  double all = 0, places = 0;
  for (const Light& light : scene.scene_lights.download(0, count)) {
    if (!(kinds >> light.kind & 1u)) continue;
    all += double{light.intensity.w};
    if (light.kind == LUCARIUM_LIGHT_POINT || light.kind == LUCARIUM_LIGHT_SPOT) places += double{light.intensity.w};
  }
  return places > 0.5 * all;
}

FirstRays::Keys FirstRays::keys(ScheduleRecorder& recorder, uint32_t rays, const std::string& remedy) {
  return {recorder.transient<uint32_t>("keys of first rays", rays, remedy),
          recorder.transient<uint32_t>("order of first rays", rays, remedy)};
}

void FirstRays::record(ScheduleRecorder& recorder, const std::string& pass_name, const Intersector& intersector,
                       const RayBuffers& rays, const Keys& keys, const BufferRef& hits,
                       const std::string& remedy) const {
  const uint32_t count = rays.capacity;
  const BufferRef ordered = recorder.transient<Ray>("first rays in order", count, remedy);
  const BufferRef ordered_hits = recorder.transient<Hit>("hits of first rays in order", count, remedy);
  const auto move = [&](const char* step, const char* kernel, const char* from_name, const BufferRef& from,
                        const char* to_name, const BufferRef& to) {
    recorder.pass(pass_name + step, program_, kernel)
        .global(count)
        .local(64)
        .slice(kSlice)
        .arg("order", keys.order)
        .arg("count", count)
        .arg(from_name, from)
        .arg(to_name, to);
  };
  primitives_.record_sort_pairs(recorder, pass_name + ".sort", keys.keys, keys.order, count, LIGHT_FIRST_KEY_BITS);
  move(".order", "order_first_rays", "rays", rays.rays, "ordered", ordered);
  intersector.record_closest(recorder, pass_name + ".trace", {ordered, rays.counter, rays.counter_index, count, {}},
                             ordered_hits);
  move(".hits", "return_first_hits", "ordered", ordered_hits, "hits", hits);
}

size_t FirstRays::estimate_bytes(uint32_t paths) {
  return size_t{paths} * (sizeof(Ray) + sizeof(Hit) + 4 * sizeof(uint32_t));  // sorting takes keys and order again
}

}  // namespace lucarium
