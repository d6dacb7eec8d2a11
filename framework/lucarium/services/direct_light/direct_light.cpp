// SPDX-License-Identifier: Apache-2.0
#include "lucarium/services/direct_light/direct_light.h"

#include <algorithm>
#include <list>

#include "lucarium/base/error.h"
#include "lucarium/compute/program/source_library.h"
#include "lucarium/services/light_at_points/light_at_points.h"
#include "lucarium/services/ray_ends.h"
#include "lucarium/shared/path_settings.h"
#include "lucarium/shared/ray.h"

namespace lucarium {
namespace {

const char* const kFewerPoints = "use fewer points at once";
/// Schedules that are kept for each kind of points: two, for callers that fill two buffers in turn. One more costs its
/// transients, and the memory of buffers that have no other owner.
constexpr size_t kKeptSchedules = 2;

/// A recorded schedule for one pair of buffers.
struct Recorded {
  Buffer points, sums;  ///< kept alive, so that their addresses stay theirs
  Schedule schedule;
  Variable<uint32_t> sample_index, seed;
};

}  // namespace

struct DirectLight::State {
  State(Device& device_, KernelScheduler& scheduler_, const SceneBuffers& scene_, const Intersector& intersector_,
        const std::string& owner_, uint32_t kinds_)
      : device(device_),
        scheduler(scheduler_),
        scene(scene_),
        intersector(intersector_),
        owner(owner_),
        kinds(kinds_),
        program(device, SourceLibrary(),
                {"services/direct_light",
                 {"lucarium/services/direct_light/sample_direct_light.cl",
                  "lucarium/services/direct_light/add_direct_light.cl"},
                 ray_end_defines(intersector)}) {}

  Recorded& radiance_schedule(const TypedBuffer<GBufferPoint>& points, const TypedBuffer<float4>& sums);
  Recorded& irradiance_schedule(const TypedBuffer<SurfacePoint>& points, const TypedBuffer<float4>& sums);
  /// The one known for these buffers, else a new one in the place of the one that was used longest ago.
  static Recorded& find(std::list<Recorded>& known, const Buffer& points, const Buffer& sums);
  bool run(Recorded& recorded, uint32_t sample_index, uint32_t seed);
  /// One element: number of points, in the form that the intersector takes.
  TypedBuffer<uint32_t> counter(uint32_t count) const {
    return TypedBuffer<uint32_t>(device, owner, "direct light points", std::vector<uint32_t>{count});
  }

  Device& device;
  KernelScheduler& scheduler;
  const SceneBuffers& scene;
  const Intersector& intersector;
  std::string owner;
  uint32_t kinds;
  Program program, point_program;
  std::list<Recorded> radiance, irradiance;  ///< the one used last first
};

Recorded& DirectLight::State::find(std::list<Recorded>& known, const Buffer& points, const Buffer& sums) {
  const auto found = std::find_if(known.begin(), known.end(), [&](const Recorded& recorded) {
    return recorded.points.handle() == points.handle() && recorded.sums.handle() == sums.handle();
  });
  if (found != known.end()) {
    known.splice(known.begin(), known, found);
    return known.front();
  }
  if (known.size() == kKeptSchedules) known.pop_back();
  Recorded& recorded = known.emplace_front();
  recorded.points = points;
  recorded.sums = sums;
  return recorded;
}

Recorded& DirectLight::State::radiance_schedule(const TypedBuffer<GBufferPoint>& points,
                                                const TypedBuffer<float4>& sums) {
  Recorded& recorded = find(radiance, points, sums);
  if (recorded.schedule) return recorded;
  const uint32_t count = static_cast<uint32_t>(points.count());
  const TypedBuffer<uint32_t> point_count = counter(count);
  ScheduleRecorder recorder = scheduler.record("direct light at pixels", owner);
  recorded.sample_index = recorder.variable("sample_index", 0u);
  recorded.seed = recorder.variable("seed", 0u);
  const BufferRef shadow_rays = recorder.transient<Ray>("shadow rays", count, kFewerPoints);
  const BufferRef shadow_light = recorder.transient<float4>("light behind the shadow rays", count, kFewerPoints);
  const BufferRef occluded = recorder.transient<uint32_t>("occluded", count, kFewerPoints);
  const BufferRef bsdf_rays = recorder.transient<Ray>("BSDF rays", count, kFewerPoints);
  const BufferRef bsdf_weights = recorder.transient<float4>("BSDF weights", count, kFewerPoints);
  const BufferRef sides = recorder.transient<uint32_t>("lit sides", count, kFewerPoints);
  const BufferRef hits = recorder.transient<Hit>("hits", count, kFewerPoints);
  const BufferRef shadow_ends = transient_ray_ends(recorder, intersector, "ends of shadow rays", count, kFewerPoints);
  const BufferRef bsdf_ends = transient_ray_ends(recorder, intersector, "ends of BSDF rays", count, kFewerPoints);
  const BufferRef numbers = recorder.transient<float>(
      "random numbers", size_t{(count + 7) / 8} * 8 * LUCARIUM_PATH_NUMBER_ROWS, kFewerPoints);
  recorder.pass("draw numbers", program, "draw_direct_numbers")
      .global((size_t{count} + 7) / 8)
      .arg("count", count)
      .arg("sample_index", recorded.sample_index)
      .arg("seed", recorded.seed)
      .arg("numbers", numbers);
  PassBuilder sample = recorder.pass("sample direct light", program, "sample_direct_radiance");
  scene.bind(sample);
  sample.global(count)
      .arg("points", points)
      .arg("count", count)
      .arg("kinds", kinds)
      .arg("numbers", numbers)
      .arg("shadow_rays", shadow_rays)
      .arg("shadow_light", shadow_light)
      .arg("bsdf_rays", bsdf_rays)
      .arg("bsdf_weights", bsdf_weights)
      .arg("sides", sides)
      .arg_if_present("shadow_ends", shadow_ends)
      .arg_if_present("bsdf_ends", bsdf_ends);
  intersector.record_any(recorder, "shadow rays", {shadow_rays, point_count, 0, count, shadow_ends}, occluded);
  intersector.record_closest(recorder, "BSDF rays", {bsdf_rays, point_count, 0, count, bsdf_ends}, hits);
  PassBuilder add = recorder.pass("add direct light", program, "add_direct_radiance");
  scene.bind(add);
  add.global(count)
      .arg("count", count)
      .arg("kinds", kinds)
      .arg("shadow_light", shadow_light)
      .arg("occluded", occluded)
      .arg("bsdf_rays", bsdf_rays)
      .arg("bsdf_weights", bsdf_weights)
      .arg("sides", sides)
      .arg("hits", hits)
      .arg("radiance", sums);
  recorded.schedule = recorder.compile();
  return recorded;
}

Recorded& DirectLight::State::irradiance_schedule(const TypedBuffer<SurfacePoint>& points,
                                                  const TypedBuffer<float4>& sums) {
  Recorded& recorded = find(irradiance, points, sums);
  if (recorded.schedule) return recorded;
  if (!point_program)
    point_program = Program(device, SourceLibrary(),
                            {"services/surface_points",
                             {"lucarium/services/light_at_points/surface_points.cl"},
                             ray_end_defines(intersector)});
  const LightAtPoints light(
      device, scene, intersector, point_program, static_cast<uint32_t>(points.count()),
      [&](PassBuilder& pass) { pass.arg("points", points); }, owner, kFewerPoints);
  ScheduleRecorder recorder = scheduler.record("direct light at points", owner);
  recorded.sample_index = recorder.variable("sample_index", 0u);
  recorded.seed = recorder.variable("seed", 0u);
  light.record_samples(
      recorder, recorded.sample_index, recorded.seed, [&](PassBuilder& pass) { pass.arg("irradiance", sums); }, kinds);
  recorded.schedule = recorder.compile();
  return recorded;
}

bool DirectLight::State::run(Recorded& recorded, uint32_t sample_index, uint32_t seed) {
  recorded.schedule.set(recorded.sample_index, sample_index);
  recorded.schedule.set(recorded.seed, seed);
  return scheduler.run(recorded.schedule) == RunResult::done;
}

DirectLight::DirectLight(Device& device, KernelScheduler& scheduler, const SceneBuffers& scene,
                         const Intersector& intersector, const std::string& owner, uint32_t kinds)
    : state_(std::make_unique<State>(device, scheduler, scene, intersector, owner, kinds)) {}

DirectLight::~DirectLight() = default;

size_t DirectLight::estimate_bytes(size_t points, bool ray_ends) {
  const size_t per_ray = sizeof(Ray) + (ray_ends ? sizeof(RayEnds) : 0);
  const size_t numbers = LUCARIUM_PATH_NUMBER_ROWS * sizeof(float);
  return points *
         (2 * per_ray + 2 * sizeof(float4) + 2 * sizeof(uint32_t) + sizeof(Hit) + numbers);  // transients, unshared
}

bool DirectLight::accumulate_radiance(const TypedBuffer<GBufferPoint>& points, const TypedBuffer<float4>& radiance,
                                      uint32_t sample_index, uint32_t seed) {
  if (radiance.count() < points.count()) throw Error(ErrorClass::internal, "DirectLight: fewer sums than points");
  return state_->run(state_->radiance_schedule(points, radiance), sample_index, seed);
}

bool DirectLight::accumulate_irradiance(const TypedBuffer<SurfacePoint>& points, const TypedBuffer<float4>& irradiance,
                                        uint32_t sample_index, uint32_t seed) {
  if (irradiance.count() < points.count()) throw Error(ErrorClass::internal, "DirectLight: fewer sums than points");
  return state_->run(state_->irradiance_schedule(points, irradiance), sample_index, seed);
}

void DirectLight::warm_up(const TypedBuffer<GBufferPoint>& points, const TypedBuffer<float4>& radiance) {
  state_->scheduler.warm_up(state_->radiance_schedule(points, radiance).schedule);
}

void DirectLight::warm_up(const TypedBuffer<SurfacePoint>& points, const TypedBuffer<float4>& irradiance) {
  state_->scheduler.warm_up(state_->irradiance_schedule(points, irradiance).schedule);
}

}  // namespace lucarium
