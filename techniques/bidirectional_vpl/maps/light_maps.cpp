// SPDX-License-Identifier: Apache-2.0
#include "bidirectional_vpl/maps/light_maps.h"

#include <algorithm>

#include "bidirectional_vpl/base/slices.h"
#include "lucarium/services/ray_ends.h"

const lucarium::EmbeddedSources& bidirectional_vpl_kernels();

namespace lucarium::bidirectional {

namespace {

constexpr uint32_t kLightFaces = 6;

std::vector<uint32_t> lights_with_a_place(const SceneBuffers& scene) {
  std::vector<uint32_t> list;
  const std::vector<Light> lights = scene.scene_lights.download();
  for (uint32_t l = 0; l < scene.info().light_count; ++l)
    if (lights[l].kind == LUCARIUM_LIGHT_POINT || lights[l].kind == LUCARIUM_LIGHT_SPOT) list.push_back(l);
  return list;
}

std::vector<uint32_t> places_of(const std::vector<uint32_t>& lights, const SceneBuffers& scene) {
  std::vector<uint32_t> places(std::max(scene.info().light_count, 1u), LUCARIUM_NONE);
  for (uint32_t place = 0; place < lights.size(); ++place) places[lights[place]] = place;
  return places;
}

}  // namespace

LightMaps::LightMaps(Device& device, KernelScheduler& scheduler, const SceneBuffers& scene, const std::string& name,
                     uint32_t side, const std::string& remedy, const std::string& owner)
    : scheduler_(scheduler),
      scene_(scene),
      name_(name),
      owner_(owner),
      side_(side),
      lights_(lights_with_a_place(scene)),
      places_(places_of(lights_, scene)),
      program_(make_program(device, bidirectional_vpl_kernels(), {"bidirectional_vpl/maps/light_maps"}, {})),
      light_list_(device, owner, "lights of " + name, lights_.empty() ? std::vector<uint32_t>{LUCARIUM_NONE} : lights_),
      place_list_(device, owner, "places of lights in " + name, places_),
      views_(device, owner, "views of " + name, kLightFaces * std::max<size_t>(lights_.size(), 1), remedy),
      triangles_(device, owner, name, std::max<size_t>(lights_.size(), 1) * kLightFaces * side * side, remedy),
      faces_(scheduler, scene, name, side, program_, "keep_cube_face", views_, triangles_, remedy, owner) {
  views_.fill_zero();
  triangles_.fill_zero();
  ScheduleRecorder recorder = scheduler.record("views of " + name, owner);
  seed_ = recorder.variable("seed", 0u);
  sample_ = recorder.variable("sample", 0u);
  PassBuilder views = recorder.pass(name + ".views", program_, "make_cube_views");
  scene.bind(views);
  views.global(std::max<size_t>(lights_.size(), 1))
      .arg("map_lights", light_list_)
      .arg("count", static_cast<uint32_t>(lights_.size()))
      .arg("side", side)
      .arg("seed", seed_)
      .arg("sample_index", sample_)
      .arg("views", views_);
  prepare_ = recorder.compile();
}

bool LightMaps::fill(uint32_t seed, uint32_t sample) {
  prepare_.set(seed_, seed);
  prepare_.set(sample_, sample);
  if (scheduler_.run(prepare_) == RunResult::cancelled) return false;
  return faces_.fill(kLightFaces * static_cast<uint32_t>(lights_.size()));
}

BufferRef LightMaps::record_light_paths(ScheduleRecorder& recorder, const Intersector& intersector,
                                        const BufferRef& states, const RayBuffers& rays, const BufferRef& hits) const {
  const BufferRef traced = recorder.transient<Ray>("rays of light paths without a map", rays.capacity);
  recorder.pass(name_ + ".rays", program_, "rays_without_map")
      .global(rays.capacity)
      .slice(kSlice)
      .arg("states", states)
      .arg("places", place_list_)
      .arg("lights", static_cast<uint32_t>(places_.size()))
      .arg("rays", rays.rays)
      .arg("count", rays.capacity)
      .arg("traced", traced);
  RayBuffers others = rays;
  others.rays = traced;
  intersector.record_closest(recorder, "trace light paths", others, hits);
  PassBuilder look_up = recorder.pass(name_ + ".look_up", program_, "look_up_light_maps");
  scene_.bind(look_up);
  look_up.global(rays.capacity)
      .slice(kSlice)
      .arg("states", states)
      .arg("places", place_list_)
      .arg("side", side_)
      .arg("views", views_)
      .arg("triangles", triangles_)
      .arg("rays", rays.rays)
      .arg("count", rays.capacity)
      .arg("hits", hits);
  return traced;
}

void LightMaps::record_test(ScheduleRecorder& recorder, const ShadowRays& rays) const {
  PassBuilder test = recorder.pass("shading.light_maps", program_, "test_light_maps");
  scene_.bind(test);
  test.global(rays.capacity)
      .slice(kSlice)
      .arg("places", place_list_)
      .arg("side", side_)
      .arg("views", views_)
      .arg("triangles", triangles_)
      .arg("light_numbers", rays.sources)
      .arg("hits", rays.hits)
      .arg("active", rays.active)
      .arg("rays", rays.rays)
      .arg("traced", rays.traced)
      .arg("light", rays.light);
}

bool LightMaps::update() { return faces_.update() && lights_with_a_place(scene_) == lights_; }

void LightMaps::warm_up() {
  scheduler_.warm_up(prepare_);
  faces_.warm_up();
}

size_t LightMaps::estimate_bytes(size_t triangles, size_t lights, uint32_t side) {
  // Where there are no lights, one stands for all.
  return std::max<size_t>(lights, 1) * kLightFaces * (size_t{side} * side * sizeof(uint32_t) + sizeof(LayeredView)) +
         FaceRaster::estimate_bytes(triangles, side);
}

}  // namespace lucarium::bidirectional
