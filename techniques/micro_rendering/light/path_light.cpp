// SPDX-License-Identifier: Apache-2.0
#include "micro_rendering/light/path_light.h"

#include <algorithm>
#include <cmath>

#include "lucarium/base/files/embedded_files.h"
#include "lucarium/base/numbers.h"
#include "lucarium/base/seed.h"

const lucarium::EmbeddedSources& micro_rendering_kernels();

namespace lucarium::micro {
namespace {

/// Largest radius of a density estimate over the one that is expected to hold photon_k photons.
constexpr float kSearch = 2;
const char* const kFewerPhotons = "lower photons or points_log2";

bool keeps_samples(const MicroParameters& parameters) { return parameters.node_shading == NodeShading::dynamic; }

MicroParameters at_points(MicroParameters parameters) {
  parameters.node_shading = NodeShading::stored;  // nothing is kept for lobes of leaves
  return parameters;
}

uint32_t paths_of(const MicroParameters& parameters) {
  return static_cast<uint32_t>(parameters.multibounce == MultiBounce::photon_map ? parameters.photons
                                                                                 : parameters.vpls);
}

/// Vertices from 0. A photon lies where light arrives, so the first stands for direct light; a virtual light is where
/// it leaves again.
uint32_t first_vertex(const MicroParameters& parameters) {
  return parameters.multibounce == MultiBounce::instant_radiosity || parameters.photon_direct ? 0 : 1;
}

/// All vertices of a path, kept or not; none are kept where this is first_vertex().
uint32_t vertices_of(const MicroParameters& parameters, int bounces) {
  const int last = parameters.multibounce == MultiBounce::instant_radiosity ? bounces - 1 : bounces;
  return std::max(static_cast<uint32_t>(std::max(last, 0)), first_vertex(parameters));
}

LightPathOptions path_options(const MicroParameters& parameters, int bounces) {
  LightPathOptions options;
  options.paths = paths_of(parameters);
  options.vertices = vertices_of(parameters, bounces);
  options.diffuse_only = true;
  options.remedy = kFewerPhotons;
  return options;
}

}  // namespace

LightAtPoints light_at_points(Device& device, const SceneBuffers& scene, const Intersector& intersector,
                              const PointForest& forest, const TypedBuffer<GBufferPoint>& points,
                              const MicroParameters& parameters, const std::string& owner) {
  const Program program =
      make_program(device, micro_rendering_kernels(), {"micro_rendering/light/light_points"},
                   {{"MICRO_PIXELS", points ? "1" : "0"}, {"MICRO_DYNAMIC", keeps_samples(parameters) ? "1" : "0"}});
  const auto count = static_cast<uint32_t>(points ? points.count() : forest.leaf_count());
  const auto bind = [points, leaves = forest.leaves](PassBuilder& pass) {
    if (points)
      pass.arg("points", points);
    else
      pass.arg("leaves", leaves);
  };
  return LightAtPoints(device, scene, intersector, program, count, bind, owner, kFewerPhotons);
}

LightAtPoints::Bind bind_light_sums(const MicroParameters& parameters, float weight,
                                    const TypedBuffer<float4>& irradiance,
                                    const TypedBuffer<MicroLeafLight>& leaf_lights) {
  return [keeps = keeps_samples(parameters), weight, irradiance, lights = leaf_lights](PassBuilder& pass) {
    pass.arg("weight", weight).arg("irradiance", irradiance);
    if (keeps) pass.arg("leaf_lights", lights);
  };
}

PathLight::PathLight(Device& device, KernelScheduler& scheduler, const Scene& scene, const SceneBuffers& buffers,
                     const Intersector& intersector, const PointForest& forest, const MicroParameters& parameters,
                     int bounces, const TypedBuffer<float4>& irradiance, const TypedBuffer<MicroLeafLight>& leaf_lights,
                     const std::string& owner, const TypedBuffer<GBufferPoint>* points)
    : device_(device),
      scheduler_(scheduler),
      scene_(scene),
      buffers_(buffers),
      intersector_(intersector),
      forest_(forest),
      parameters_(points ? at_points(parameters) : parameters),
      owner_(owner),
      paths_(device, buffers, intersector, path_options(parameters, bounces), owner) {
  const uint32_t first = first_vertex(parameters);
  if (paths_.virtual_lights(first) == 0) return;
  lights_ = TypedBuffer<VirtualLight>(device, owner, "photons", paths_.virtual_lights(first), kFewerPhotons);
  ScheduleRecorder recorder = scheduler_.record("light paths", owner_);
  frame_ = recorder.variable("frame", 0u);
  seed_ = recorder.variable("seed", 0u);
  paths_.record_virtual_lights(recorder, frame_, seed_, lights_, first, virtual_lights());
  paths_schedule_ = recorder.compile();
  if (virtual_lights())
    record_virtual_light(points ? *points : TypedBuffer<GBufferPoint>(), irradiance, leaf_lights);
  else
    record_density(irradiance, leaf_lights);
}

/// The light of one virtual light at all leaves, or at all visible points.
void PathLight::record_virtual_light(const TypedBuffer<GBufferPoint>& points, const TypedBuffer<float4>& irradiance,
                                     const TypedBuffer<MicroLeafLight>& leaf_lights) {
  ScheduleRecorder recorder = scheduler_.record("virtual light", owner_);
  max_geometry_ = recorder.variable("max_geometry", 0.f);
  light_ = recorder.variable("light", 0u);
  shadow_seed_ = recorder.variable("seed", 0u);
  light_at_points(device_, buffers_, intersector_, forest_, points, parameters_, owner_)
      .record_virtual_light(recorder, lights_, light_, shadow_seed_, max_geometry_,
                            bind_light_sums(parameters_, 1, irradiance, leaf_lights));
  light_schedule_ = recorder.compile();
}

/// Density of the photons about every leaf.
void PathLight::record_density(const TypedBuffer<float4>& irradiance, const TypedBuffer<MicroLeafLight>& leaf_lights) {
  ScheduleRecorder recorder = scheduler_.record("photon map", owner_);
  cell_ = recorder.variable("cell", 1.f);
  light_at_points(device_, buffers_, intersector_, forest_, {}, parameters_, owner_)
      .record_photon_density(recorder, lights_, cell_, static_cast<uint32_t>(parameters_.photon_k),
                             bind_light_sums(parameters_, 1, irradiance, leaf_lights));
  light_schedule_ = recorder.compile();
}

/// Edge of the cells in which photons are looked up [m].
float PathLight::photon_cell() const {
  double area = 0;
  for (const ForestTree& tree : forest_.trees())
    area += static_cast<double>(tree.record.leaf_area) * tree.leaves() *
            std::pow(static_cast<double>(tree.record.world_step), 2);
  const auto expected = static_cast<float>(std::sqrt(parameters_.photon_k * area / (pi * paths_of(parameters_))));
  return kSearch * std::max(expected, 1e-9f);
}

bool PathLight::trace(uint32_t frame, uint32_t seed) {
  if (!paths_schedule_) return true;
  paths_schedule_.set(frame_, frame);
  paths_schedule_.set(seed_, seed);
  frame_seed_ = indexed_seed(seed, frame);
  return scheduler_.run(paths_schedule_) == RunResult::done;
}

bool PathLight::add(uint32_t part) {
  // Of the scene as it is now: things move.
  if (virtual_lights()) {
    const float radius = std::max(scene_.bounds().radius(), 1e-6f);
    light_schedule_.set(max_geometry_, parameters_.vpl_clamp / (radius * radius));
    light_schedule_.set(light_, part);
    light_schedule_.set(shadow_seed_, frame_seed_);
  } else {
    light_schedule_.set(cell_, photon_cell());
  }
  return scheduler_.run(light_schedule_) == RunResult::done;
}

void PathLight::warm_up() {
  for (Schedule* schedule : {&paths_schedule_, &light_schedule_})
    if (*schedule) scheduler_.warm_up(*schedule);
}

size_t PathLight::estimate_bytes(const MicroParameters& parameters, size_t leaves, int bounces) {
  const size_t paths = paths_of(parameters), photons = paths * static_cast<size_t>(bounces);
  return photons * (sizeof(VirtualLight) + 4 * sizeof(uint32_t)) + LightPaths::estimate_bytes(paths_of(parameters)) +
         LightAtPoints::estimate_bytes(leaves) + (size_t{5} << 20);
}

}  // namespace lucarium::micro
