// SPDX-License-Identifier: Apache-2.0
#include "micro_rendering/light/light_paths.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "lucarium/base/embedded_files.h"
#include "lucarium/base/seed.h"
#include "lucarium/compute/program/source_library.h"
#include "lucarium/shared/ray.h"

const lucarium::EmbeddedSources& micro_rendering_kernels();

namespace lucarium::micro {
namespace {

constexpr size_t kLocalSize = 64;
constexpr size_t kPathsPerSlice = 1 << 16;
constexpr size_t kEstimatesPerSlice = 1 << 12;
constexpr float kSearch =
    2;  // largest radius of a density estimate over the one that is expected to hold photon_k photons
const char* const kRemedy = "lower photons or points_log2";

Program micro_program(Device& device, const char* name, const char* file) {
  SourceLibrary library;
  library.add(micro_rendering_kernels());
  return Program(device, library, {name, {file}, {}});
}

MicroParameters at_points(MicroParameters parameters) {
  parameters.node_shading = NodeShading::stored;  // nothing is kept for lobes of leaves
  return parameters;
}

uint32_t bucket_mask(uint32_t photons) { return std::clamp(std::bit_ceil(photons / 16), 1024u, 1u << 20) - 1; }

}  // namespace

uint32_t LightPaths::paths_of(const MicroParameters& parameters) {
  return static_cast<uint32_t>(parameters.multibounce == MultiBounce::photon_map ? parameters.photons
                                                                                 : parameters.vpls);
}

/// Vertices from 0. A photon lies where light arrives, so the first stands for direct light; a virtual light is where
/// it leaves again.
uint32_t LightPaths::first_vertex() const { return virtual_lights() || parameters_.photon_direct ? 0 : 1; }

uint32_t LightPaths::kept_vertices() const {
  return static_cast<uint32_t>(
      std::max(0, (virtual_lights() ? bounces_ - 1 : bounces_) - static_cast<int>(first_vertex())));
}

LightPaths::LightPaths(Device& device, KernelScheduler& scheduler, const Scene& scene, const SceneBuffers& buffers,
                       const Intersector& intersector, const PointForest& forest, const MicroParameters& parameters,
                       int bounces, const TypedBuffer<float4>& irradiance, const DynamicShading& shading,
                       const std::string& owner, const TypedBuffer<GBufferPoint>* points)
    : device_(device),
      scheduler_(scheduler),
      scene_(scene),
      buffers_(buffers),
      intersector_(intersector),
      forest_(forest),
      parameters_(points ? at_points(parameters) : parameters),
      bounces_(bounces),
      irradiance_(irradiance),
      shading_(shading),
      owner_(owner),
      paths_(paths_of(parameters)),
      program_(micro_program(device, "micro_rendering/paths", "micro_rendering/light/micro_paths.cl")),
      light_program_(light_program(device, parameters_)),
      primitives_(device) {
  if (kept_vertices() == 0) return;
  photons_ = TypedBuffer<MicroPhoton>(device, owner, "photons", size_t{paths_} * kept_vertices(), kRemedy);
  path_count_ = TypedBuffer<uint32_t>(device, owner, "number of light paths", std::vector<uint32_t>{paths_});
  if (points) points_ = *points;
  const auto receivers = points ? static_cast<uint32_t>(points->count()) : forest.leaf_count();
  receiver_count_ = TypedBuffer<uint32_t>(device, owner, "number of receivers", std::vector<uint32_t>{receivers});
  record_paths();
  if (virtual_lights())
    record_virtual_light();
  else
    record_density();
}

void LightPaths::record_paths() {
  ScheduleRecorder recorder = scheduler_.record("light paths", owner_);
  frame_ = recorder.variable("frame", 0u);
  seed_ = recorder.variable("seed", 0u);
  const BufferRef rays = recorder.transient<Ray>("rays of light paths", paths_, kRemedy);
  const BufferRef hits = recorder.transient<Hit>("hits of light paths", paths_, kRemedy);
  const BufferRef powers = recorder.transient<float4>("power of light paths", paths_, kRemedy);
  PassBuilder emit = recorder.pass("emit light paths", program_, "mr_emit");
  buffers_.bind(emit, program_, "mr_emit");
  emit.global(paths_)
      .local(kLocalSize)
      .slice(kPathsPerSlice)
      .arg("count", paths_)
      .arg("frame", frame_)
      .arg("seed", seed_)
      .arg("rays", rays)
      .arg("powers", powers);
  const uint32_t first = first_vertex();
  for (uint32_t vertex = 0; vertex < first + kept_vertices(); ++vertex) {
    intersector_.record_closest(recorder, "trace light paths", rays, hits, path_count_, 0, paths_);
    PassBuilder pass = recorder.pass("vertices of light paths", program_, "mr_path_vertex");
    buffers_.bind(pass, program_, "mr_path_vertex");
    pass.global(paths_)
        .local(kLocalSize)
        .slice(kPathsPerSlice)
        .arg("count", paths_)
        .arg("frame", frame_)
        .arg("seed", seed_)
        .arg("vertex", vertex)
        .arg("keep", vertex >= first ? 1u : 0u)
        .arg("slot", vertex >= first ? vertex - first : 0u)
        .arg("reflected", virtual_lights() ? 1u : 0u)
        .arg("hits", hits)
        .arg("rays", rays)
        .arg("powers", powers)
        .arg("photons", photons_);
  }
  paths_schedule_ = recorder.compile();
}

/// The light of one virtual light at all leaves, or at all visible points.
void LightPaths::record_virtual_light() {
  const auto receivers = static_cast<uint32_t>(points_ ? points_.count() : forest_.leaf_count());
  const char* const kernel = points_ ? "mr_virtual_light_at_pixels" : "mr_virtual_light";
  ScheduleRecorder recorder = scheduler_.record("virtual light", owner_);
  most_ = recorder.variable("most", 0.f);
  light_ = recorder.variable("light", 0u);
  shadow_seed_ = recorder.variable("seed", 0u);
  const BufferRef rays = recorder.transient<Ray>("rays to virtual lights", receivers, kRemedy);
  const BufferRef light = recorder.transient<float4>("light of virtual lights", receivers, kRemedy);
  const BufferRef occluded = recorder.transient<uint32_t>("occluded virtual lights", receivers, kRemedy);
  PassBuilder pass = recorder.pass("virtual light", program_, kernel);
  buffers_.bind(pass, program_, kernel);
  if (points_)
    pass.arg("points", points_);
  else
    pass.arg("leaves", forest_.leaves);
  pass.global(receivers)
      .local(kLocalSize)
      .slice(kPathsPerSlice)
      .arg("count", receivers)
      .arg("photons", photons_)
      .arg("light", light_)
      .arg("seed", shadow_seed_)
      .arg("most", most_)
      .arg("shadow_rays", rays)
      .arg("shadow_light", light);
  intersector_.record_any(recorder, "rays to virtual lights", rays, occluded, receiver_count_, 0, receivers);
  PassBuilder add = recorder.pass("add virtual light", light_program_, "mr_add_light");
  add.global(receivers)
      .local(kLocalSize)
      .arg("count", receivers)
      .arg("weight", 1.f)
      .arg("shadow_light", light)
      .arg("occluded", occluded)
      .arg("irradiance", irradiance_);
  if (parameters_.node_shading == NodeShading::dynamic)
    add.arg("shadow_rays", rays).arg("number", light_).arg("leaf_lights", shading_.leaf_lights);
  light_schedule_ = recorder.compile();
}

/// Density of the photons about every leaf.
void LightPaths::record_density() {
  const uint32_t leaves = forest_.leaf_count(), count = static_cast<uint32_t>(photons_.count()),
                 mask = bucket_mask(count);
  ScheduleRecorder recorder = scheduler_.record("photon map", owner_);
  cell_ = recorder.variable("cell", 1.f);
  const BufferRef keys = recorder.transient<uint32_t>("buckets of photons", count, kRemedy);
  const BufferRef values = recorder.transient<uint32_t>("sorted photons", count, kRemedy);
  const BufferRef starts = recorder.transient<uint32_t>("first photons", size_t{mask} + 2, kRemedy);
  recorder.pass("buckets of photons", program_, "mr_photon_keys")
      .global(count)
      .local(kLocalSize)
      .arg("photons", photons_)
      .arg("count", count)
      .arg("cell", cell_)
      .arg("mask", mask)
      .arg("keys", keys)
      .arg("values", values);
  primitives_.record_sort_pairs(recorder, "sort photons", keys, values, count, std::bit_width(mask + 1));
  recorder.pass("first photons", program_, "mr_bucket_starts")
      .global(size_t{count} + 1)
      .local(kLocalSize)
      .arg("keys", keys)
      .arg("count", count)
      .arg("mask", mask)
      .arg("starts", starts);
  PassBuilder pass = recorder.pass("photon density", program_, "mr_photon_density");
  buffers_.bind(pass, program_, "mr_photon_density");
  pass.global(leaves)
      .local(1)
      .slice(kEstimatesPerSlice)
      .arg("leaves", forest_.leaves)
      .arg("count", leaves)
      .arg("photons", photons_)
      .arg("values", values)
      .arg("starts", starts)
      .arg("cell", cell_)
      .arg("mask", mask)
      .arg("most", static_cast<uint32_t>(parameters_.photon_k))
      .arg("irradiance", irradiance_);
  light_schedule_ = recorder.compile();
}

/// Edge of the cells in which photons are looked up [m].
float LightPaths::photon_cell() const {
  double area = 0;
  for (const ForestTree& tree : forest_.trees())
    area += static_cast<double>(tree.record.leaf_area) * tree.leaves() *
            std::pow(static_cast<double>(tree.record.world_step), 2);
  const auto expected = static_cast<float>(std::sqrt(parameters_.photon_k * area / (3.14159265358979 * paths_)));
  return kSearch * std::max(expected, 1e-9f);
}

bool LightPaths::trace(uint32_t frame, uint32_t seed) {
  if (!paths_schedule_) return true;
  paths_schedule_.set(frame_, frame);
  paths_schedule_.set(seed_, seed);
  frame_seed_ = indexed_seed(seed, frame);
  return scheduler_.run(paths_schedule_) == RunResult::done;
}

bool LightPaths::add(uint32_t part) {
  // Of the scene as it is now: things move.
  if (virtual_lights()) {
    const float radius = std::max(scene_.bounds().radius(), 1e-6f);
    light_schedule_.set(most_, parameters_.vpl_clamp / (radius * radius));
    light_schedule_.set(light_, part);
    light_schedule_.set(shadow_seed_, frame_seed_);
  } else {
    light_schedule_.set(cell_, photon_cell());
  }
  return scheduler_.run(light_schedule_) == RunResult::done;
}

void LightPaths::warm_up() {
  for (Schedule* schedule : {&paths_schedule_, &light_schedule_})
    if (*schedule) scheduler_.warm_up(*schedule);
}

size_t LightPaths::estimate_bytes(const MicroParameters& parameters, size_t leaves, int bounces) {
  const size_t paths = paths_of(parameters), photons = paths * static_cast<size_t>(bounces);
  return photons * (sizeof(MicroPhoton) + 4 * sizeof(uint32_t)) + paths * (sizeof(Ray) + 16 + sizeof(float4)) +
         leaves * (sizeof(Ray) + sizeof(float4) + sizeof(uint32_t)) + (size_t{5} << 20);
}

}  // namespace lucarium::micro
