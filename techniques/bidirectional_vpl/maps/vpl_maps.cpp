// SPDX-License-Identifier: Apache-2.0
#include "bidirectional_vpl/maps/vpl_maps.h"

#include <cmath>
#include <map>
#include <string>

#include "bidirectional_vpl/base/slices.h"

const lucarium::EmbeddedSources& bidirectional_vpl_kernels();

namespace lucarium::bidirectional {

namespace {

const char* const kSmallerMaps = "lower map_res, light_paths or light_vertices, or set vpl_visibility=rays";
constexpr uint32_t kVplFaces = 5;

/// Of one map.
size_t texels(uint32_t side) { return size_t{3} * side * side; }

/// `alone`: maps answer all connections; `of_one`: those of a launch lead to one virtual light.
std::map<std::string, std::string> map_defines(bool alone, bool of_one) {
  std::map<std::string, std::string> defines;
  if (alone) defines["VPL_MAPS_ALONE"] = "";
  if (of_one) defines["VPL_MAPS_OF_ONE"] = "";
  return defines;
}

}  // namespace

uint32_t VplMaps::side(uint32_t map_res) {
  // S² + 4 S · S/2 texels, S even.
  return 2 * static_cast<uint32_t>(static_cast<double>(map_res) / std::sqrt(3.0) / 2);
}

VplMaps::VplMaps(Device& device, KernelScheduler& scheduler, const SceneBuffers& scene, const Plan& plan,
                 const LightVertices& vertices, const std::string& owner)
    : scheduler_(scheduler),
      scene_(scene),
      vertices_(vertices),
      side_(side(plan.map_res)),
      vertices_per_path_(plan.light_vertices),
      alone_(!transmits(scene)),
      of_one_(plan.connects_to_all()),
      program_(make_program(device, bidirectional_vpl_kernels(), {"bidirectional_vpl/maps/vpl_maps"},
                            map_defines(alone_, of_one_))),
      views_(device, owner, "views of VPL maps", kVplFaces * plan.vertex_slots(), kSmallerMaps),
      places_(device, owner, "places of VPL maps", plan.vertex_slots(), kSmallerMaps),
      triangles_(device, owner, "VPL maps", plan.vertex_slots() * texels(side_), kSmallerMaps),
      faces_(scheduler, scene, "VPL maps", side_, program_, "keep_vpl_face", views_, triangles_, kSmallerMaps, owner) {
  ScheduleRecorder recorder = scheduler.record("views of VPL maps", owner);
  seed_ = recorder.variable("seed", 0u);
  sample_ = recorder.variable("sample", 0u);
  PassBuilder views = recorder.pass("VPL maps.views", program_, "make_vpl_views");
  scene.bind(views);
  views.global(plan.vertex_slots())
      .arg("vertices", vertices.vertices())
      .arg("list", vertices.list())
      .arg("count", vertices.count())
      .arg("side", side_)
      .arg("seed", seed_)
      .arg("sample_index", sample_)
      .arg("views", views_)
      .arg("places", places_);
  prepare_ = recorder.compile();
}

bool VplMaps::fill(uint32_t seed, uint32_t sample) {
  prepare_.set(seed_, seed);
  prepare_.set(sample_, sample);
  if (scheduler_.run(prepare_) == RunResult::cancelled) return false;
  return faces_.fill(kVplFaces * vertices_.vertex_count());
}

void VplMaps::record_test(ScheduleRecorder& recorder, const ShadowRays& rays) const {
  PassBuilder test = recorder.pass("shading.vpl_maps", program_, "test_vpl_maps");
  scene_.bind(test);
  test.global((rays.capacity + 7) / 8)
      .slice(kSlice / 8)
      .arg("vertices", vertices_.vertices())
      .arg("places", places_)
      .arg("side", side_)
      .arg("views", views_)
      .arg("triangles", triangles_)
      .arg("hits", rays.hits)
      .arg("active", rays.active)
      .arg("rays", rays.rays)
      .arg("connections", rays.light);
  if (alone_)
    test.arg("hidden", rays.hidden);
  else
    test.arg("traced", rays.traced);
  if (of_one_)
    test.arg("list", vertices_.list()).arg("number", *rays.number);
  else
    test.arg("vertices_per_path", vertices_per_path_).arg("connection_paths", rays.sources);
}

void VplMaps::warm_up() {
  scheduler_.warm_up(prepare_);
  faces_.warm_up();
}

size_t VplMaps::estimate_bytes(const Plan& plan, size_t triangles) {
  const uint32_t edge = side(plan.map_res);
  return plan.vertex_slots() * (texels(edge) * sizeof(uint32_t) + kVplFaces * sizeof(LayeredView) + sizeof(uint32_t)) +
         FaceRaster::estimate_bytes(triangles, edge);
}

}  // namespace lucarium::bidirectional
