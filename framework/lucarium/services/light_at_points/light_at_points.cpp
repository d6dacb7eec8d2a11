// SPDX-License-Identifier: Apache-2.0
#include "lucarium/services/light_at_points/light_at_points.h"

#include <algorithm>
#include <bit>
#include <utility>

#include "lucarium/base/error.h"
#include "lucarium/compute/program/source_library.h"
#include "lucarium/services/primitives/primitives.h"
#include "lucarium/services/ray_ends.h"
#include "lucarium/shared/ray.h"

namespace lucarium {
namespace {

constexpr size_t kPointsPerSlice = 1 << 16;
constexpr size_t kEstimatesPerSlice = 1 << 12;

/// Number of the last bucket of a hash grid over photons.
uint32_t bucket_mask(uint32_t photons) { return std::clamp(std::bit_ceil(photons / 16), 1024u, 1u << 20) - 1; }

}  // namespace

LightAtPoints::LightAtPoints(Device& device, const SceneBuffers& scene, const Intersector& intersector,
                             const Program& program, uint32_t points, Bind bind_points, const std::string& owner,
                             const std::string& remedy)
    : device_(device),
      scene_(scene),
      intersector_(intersector),
      program_(program),
      points_(points),
      bind_points_(std::move(bind_points)),
      remedy_(remedy),
      count_(device, owner, "number of points to light", std::vector<uint32_t>{points}) {}

LightAtPoints::Shadows LightAtPoints::shadows(ScheduleRecorder& recorder) const {
  return {recorder.transient<Ray>("shadow rays of points", points_, remedy_),
          transient_ray_ends(recorder, intersector_, "ends of shadow rays of points", points_, remedy_),
          recorder.transient<float4>("light behind the shadow rays", points_, remedy_),
          recorder.transient<uint32_t>("occluded points", points_, remedy_)};
}

PassBuilder LightAtPoints::point_pass(ScheduleRecorder& recorder, const std::string& name, const char* kernel) const {
  PassBuilder pass = recorder.pass(name, program_, kernel);
  scene_.bind(pass);
  bind_points_(pass);
  pass.global(points_).arg("count", points_);
  return pass;
}

PassBuilder LightAtPoints::add_pass(ScheduleRecorder& recorder, const char* kernel, const Shadows& shadows,
                                    const Variable<uint32_t>& number, const Variable<uint32_t>& seed,
                                    const Bind& bind_sums) const {
  PassBuilder add = recorder.pass("add light at points", program_, kernel);
  scene_.bind(add);
  bind_sums(add);
  add.global(points_)
      .arg("count", points_)
      .arg("number", number)
      .arg("seed", seed)
      .arg("shadow_rays", shadows.rays)
      .arg("shadow_light", shadows.light)
      .arg("occluded", shadows.occluded);
  return add;
}

void LightAtPoints::record_samples(ScheduleRecorder& recorder, const Variable<uint32_t>& sample_index,
                                   const Variable<uint32_t>& seed, const Bind& bind_sums, uint32_t kinds) const {
  const Shadows found = shadows(recorder);
  const BufferRef lamp_rays = recorder.transient<Ray>("rays to lamps", points_, remedy_);
  const BufferRef lamp_ends = transient_ray_ends(recorder, intersector_, "ends of rays to lamps", points_, remedy_);
  const BufferRef lamps = recorder.transient<Hit>("hits of lamps", points_, remedy_);
  point_pass(recorder, "sample light at points", "sample_light_at_points")
      .slice(kPointsPerSlice)
      .arg("sample_index", sample_index)
      .arg("seed", seed)
      .arg("kinds", kinds)
      .arg("shadow_rays", found.rays)
      .arg("shadow_light", found.light)
      .arg("lamp_rays", lamp_rays)
      .arg_if_present("shadow_ends", found.ends)
      .arg_if_present("lamp_ends", lamp_ends);
  intersector_.record_any(recorder, "shadow rays of points", {found.rays, count_, 0, points_, found.ends},
                          found.occluded);
  intersector_.record_closest(recorder, "rays to lamps", {lamp_rays, count_, 0, points_, lamp_ends}, lamps);
  PassBuilder add = add_pass(recorder, "add_light_at_points", found, sample_index, seed, bind_sums);
  bind_points_(add);
  add.arg("lamp_rays", lamp_rays).arg("lamps", lamps);
}

void LightAtPoints::record_virtual_light(ScheduleRecorder& recorder, const BufferRef& virtual_lights,
                                         const Variable<uint32_t>& light, const Variable<uint32_t>& seed,
                                         const Variable<float>& max_geometry, const Bind& bind_sums) const {
  const Shadows found = shadows(recorder);
  point_pass(recorder, "virtual light at points", "virtual_light_at_points")
      .slice(kPointsPerSlice)
      .arg("virtual_lights", virtual_lights)
      .arg("light", light)
      .arg("seed", seed)
      .arg("max_geometry", max_geometry)
      .arg("shadow_rays", found.rays)
      .arg("shadow_light", found.light)
      .arg_if_present("shadow_ends", found.ends);
  intersector_.record_any(recorder, "rays to virtual lights", {found.rays, count_, 0, points_, found.ends},
                          found.occluded);
  add_pass(recorder, "add_virtual_light_at_points", found, light, seed, bind_sums);
}

void LightAtPoints::record_photon_density(ScheduleRecorder& recorder, const TypedBuffer<VirtualLight>& photons,
                                          const Variable<float>& cell, uint32_t nearest, const Bind& bind_sums) const {
  if (nearest < 2 || nearest > LIGHT_MAX_PHOTONS)
    throw_error(ErrorClass::internal, "LightAtPoints: nearest is {}; a density is estimated from 2 to {} photons",
                nearest, LIGHT_MAX_PHOTONS);
  const Program sorting(device_, SourceLibrary(),
                        {"services/photons", {"lucarium/services/light_at_points/sort_photons.cl"}, {}});
  const auto count = static_cast<uint32_t>(photons.count());
  const uint32_t mask = bucket_mask(count);
  const BufferRef keys = recorder.transient<uint32_t>("buckets of photons", count, remedy_);
  const BufferRef sorted = recorder.transient<uint32_t>("sorted photons", count, remedy_);
  const BufferRef starts = recorder.transient<uint32_t>("first photons", size_t{mask} + 2, remedy_);
  recorder.pass("buckets of photons", sorting, "photon_keys")
      .global(count)
      .arg("photons", photons)
      .arg("count", count)
      .arg("cell", cell)
      .arg("mask", mask)
      .arg("keys", keys)
      .arg("values", sorted);
  Primitives(device_).record_sort_pairs(recorder, "sort photons", keys, sorted, count, std::bit_width(mask + 1));
  recorder.pass("first photons", sorting, "photon_bucket_starts")
      .global(size_t{count} + 1)
      .arg("keys", keys)
      .arg("count", count)
      .arg("mask", mask)
      .arg("starts", starts);
  PassBuilder pass = point_pass(recorder, "photon density", "photon_density_at_points");
  bind_sums(pass);
  pass.local(1)
      .slice(kEstimatesPerSlice)
      .arg("photons", photons)
      .arg("sorted", sorted)
      .arg("starts", starts)
      .arg("cell", cell)
      .arg("mask", mask)
      .arg("nearest", nearest);
}

size_t LightAtPoints::estimate_bytes(size_t points) {
  return points * (2 * sizeof(Ray) + sizeof(float4) + sizeof(uint32_t) + sizeof(Hit));
}

}  // namespace lucarium
