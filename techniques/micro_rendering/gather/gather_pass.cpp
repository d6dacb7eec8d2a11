// SPDX-License-Identifier: Apache-2.0
#include "micro_rendering/gather/gather_pass.h"

#include <algorithm>

#include "lucarium/base/files/embedded_files.h"
#include "lucarium/compute/device/remedies.h"

const lucarium::EmbeddedSources& micro_rendering_kernels();

namespace lucarium::micro {
namespace {

constexpr size_t kLargestBuffer = 64;           // edge of a micro-buffer
constexpr int kPixelsPerSlice = 256 * 24 * 24;  // of micro-buffers; 20 to 200 ms: how soon a cancellation is felt
const char* const kFewerPoints = "lower points_log2";

std::map<std::string, std::string> definitions(const MicroParameters& p, int edge, bool sky, bool dynamic,
                                               bool levels) {
  const auto flag = [](bool on) { return std::string(on ? "1" : "0"); };
  return {{"MICRO_SIZE", std::to_string(edge)},
          {"MICRO_CONSERVATIVE_CUT", flag(p.cut_bound == CutBound::conservative)},
          {"MICRO_SAMPLE_SPLAT", flag(p.splat == Splat::sample)},
          {"MICRO_WARP", p.warp == Warp::analytic ? "0"
                         : p.warp == Warp::table  ? "1"
                                                  : "2"},
          {"MICRO_TABLE_SIZE", std::to_string(p.table_size)},
          {"MICRO_HOLE_FILL", flag(p.hole_fill)},
          {"MICRO_RAYCAST", flag(p.raycast)},
          {"MICRO_DEPTH_BITS", p.depth_bits == DepthBits::eight ? "8" : "32"},
          {"MICRO_GATHER_ENV", flag(sky)},
          {"MICRO_DYNAMIC", flag(dynamic)},
          {"MICRO_ERROR_CUT", flag(p.cut_error > 0)},
          {"MICRO_LEVELS", flag(levels)}};
}

}  // namespace

GatherResults::GatherResults(Device& device, const std::string& owner, const std::string& what, size_t count,
                             bool specular_too, bool sky_too)
    : irradiance(device, owner, what + " irradiance", count, remedies::lower_size),
      specular(device, owner, what + " specular", specular_too ? 2 * count : 2, remedies::lower_size),
      statistics(device, owner, what + " statistics", count, remedies::lower_size),
      micro_buffer(device, owner, what + " micro-buffer", kLargestBuffer * kLargestBuffer) {
  if (sky_too) sky = TypedBuffer<float4>(device, owner, what + " environment", 3 * count, remedies::lower_size);
}

size_t GatherResults::estimate_bytes(size_t count, bool specular_too, bool sky_too) {
  return count * ((1 + (specular_too ? 2 : 0) + (sky_too ? 3 : 0)) * sizeof(float4) + sizeof(MicroStatistics)) +
         kLargestBuffer * kLargestBuffer * sizeof(float4);
}

DynamicShading::DynamicShading(Device& device, const std::string& owner, size_t leaves)
    : choices(device, owner, "leaves that nodes stand for", 2 * leaves, kFewerPoints),
      leaf_lights(device, owner, "light samples of leaves", leaves, kFewerPoints),
      leaf_lobes(device, owner, "lobes of leaves", leaves, kFewerPoints) {}

size_t DynamicShading::estimate_bytes(size_t leaves) {
  return leaves * (2 * sizeof(MicroNodeChoice) + sizeof(MicroLeafLight) + sizeof(MicroLeafLobe));
}

GatherPass::GatherPass(Device& device, const MicroParameters& parameters, GatherAt at)
    : sky_(parameters.gather_env && at == GatherAt::pixels),
      dynamic_(parameters.node_shading == NodeShading::dynamic && at == GatherAt::pixels),
      levels_(parameters.keeps_levels() && at == GatherAt::pixels) {
  const int edge = at == GatherAt::pixels ? parameters.largest_edge() : parameters.micro_size;
  gathers_per_slice_ = static_cast<size_t>(std::clamp(kPixelsPerSlice / (edge * edge), 16, 256));
  program_ = make_program(device, micro_rendering_kernels(), {"micro_rendering/gather/micro_gather"},
                          definitions(parameters, edge, sky_, dynamic_, levels_));
}

MicroSettings GatherPass::settings(const MicroParameters& parameters, uint32_t seed, uint32_t inspect,
                                   uint32_t inspect_too) {
  return {parameters.cut_kappa, parameters.splat_radius, seed, inspect, parameters.cut_error, 0, inspect_too, 0};
}

void GatherPass::record(ScheduleRecorder& recorder, const std::string& name, const SceneBuffers& scene,
                        const PointForest& forest, const BufferRef& gathers, const BufferRef& gather_count,
                        uint32_t max_count, const Variable<MicroSettings>& settings, const GatherResults& results,
                        const DynamicShading& shading) const {
  PassBuilder pass = recorder.pass(name, program_, "gather_light");
  if (sky_) {
    scene.bind(pass);
    pass.arg("sky", results.sky);
  }
  if (levels_) pass.arg("levels", results.levels);
  if (dynamic_)
    pass.arg("choices", shading.choices).arg("leaf_lights", shading.leaf_lights).arg("leaf_lobes", shading.leaf_lobes);
  if (max_count > 0)
    pass.global(max_count);
  else
    pass.global_by(gather_count);
  pass.local(1)
      .slice(gathers_per_slice_)
      .arg("trees", forest.tree_records)
      .arg("tree_count", static_cast<uint32_t>(forest.trees().size()))
      .arg("nodes", forest.nodes)
      .arg("radiance", forest.radiance)
      .arg("clips", forest.clips)
      .arg("radiance_unit", forest.radiance_unit)
      .arg("gathers", gathers)
      .arg("gather_count", gather_count)
      .arg("settings", settings)
      .arg("irradiance", results.irradiance)
      .arg("specular", results.specular)
      .arg("statistics", results.statistics)
      .arg("micro_buffer", results.micro_buffer);
}

}  // namespace lucarium::micro
