// SPDX-License-Identifier: Apache-2.0
#include "virtual_light_field/scatter/cell_scatter.h"

#include <algorithm>
#include <numeric>

#include "lucarium/compute/device/remedies.h"
#include "lucarium/services/ray_ends.h"
#include "virtual_light_field/base/field_program.h"

namespace lucarium::vlf {
namespace {

constexpr uint32_t kTilesAtOnce = 1u << 12;  // in a pass, whole chunks
constexpr const char* kFewerCells = "lower dir_n, cells or texels";

uint32_t chunks(uint32_t tiles) { return (tiles + FIELD_TILE_CHUNK - 1) / FIELD_TILE_CHUNK; }

/// Entries of the light mixture of the brightest punctual lights, which stand there first, without dark ones, in the
/// order of the scene.
std::vector<uint32_t> brightest_lights(const Scene& scene) {
  std::vector<float> intensities;
  for (const SceneLight& light : scene.lights)
    if (light.intensity != glm::vec3(0))
      intensities.push_back(std::max(light.intensity.x, std::max(light.intensity.y, light.intensity.z)));
  std::vector<uint32_t> order(intensities.size());
  std::iota(order.begin(), order.end(), 0u);
  std::stable_sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) { return intensities[a] > intensities[b]; });
  order.resize(std::min<size_t>(order.size(), CellScatter::kMaxLights));
  return order;
}

}  // namespace

CellScatter::CellScatter(Device& device, KernelScheduler& scheduler, const Scene& host_scene, const SceneBuffers& scene,
                         const Intersector& intersector, const SurfaceAtlas& atlas, const TileMaps& maps,
                         const CellBuffers& cells, const std::vector<FieldLine>& subfields, const Program& sums,
                         const TypedBuffer<float4>& norms, const Options& options)
    : scheduler_(&scheduler),
      maps_(&maps),
      cells_(cells),
      options_(options),
      host_lights_(brightest_lights(host_scene)),
      lights_(device, technique_name, "punctual lights",
              host_lights_.empty() ? std::vector<uint32_t>{0} : host_lights_),
      visible_(device, technique_name, "lights that texel sides see", atlas.info().texel_count, remedies::lower_texels),
      tile_norms_(device, technique_name, "norms of tiles", size_t{FIELD_NORMS} * chunks(maps.tiles()), kFewerCells) {
  const Program program = make_field_program(device, "scatter/scatter_cells");
  record_scatter(scene, atlas, program, subfields);
  ScheduleRecorder summing = scheduler.record("norms of cells", technique_name);
  summing.pass("sum norms", sums, "sum_norms")
      .global(FIELD_NORMS)
      .arg("chunks", chunks(maps.tiles()))
      .arg("partial", tile_norms_)
      .arg("norms", norms);
  sum_ = summing.compile();

  ScheduleRecorder totals = scheduler.record("totals of cells", technique_name);
  tail_ = totals.variable("tail", float4{});
  added_sweep_ = totals.variable("sweep", 0u);
  totals.pass("add cells", program, "add_cells")
      .global(maps.cells())
      .arg("count", maps.cells())
      .arg("sweep", added_sweep_)
      .arg("split", options.split ? 1u : 0u)
      .arg("tail", tail_)
      .arg("sent", cells_.sent)
      .arg("direct", cells_.direct)
      .arg("total", cells_.total);
  add_ = totals.compile();
  if (has_lights()) record_visibility(device, scene, atlas, intersector);
}

void CellScatter::record_scatter(const SceneBuffers& scene, const SurfaceAtlas& atlas, const Program& program,
                                 const std::vector<FieldLine>& subfields) {
  std::vector<float4> directions(1);
  if (options_.mode != ScatterMode::gather) {
    directions.clear();
    for (const FieldLine& subfield : subfields) directions.push_back(subfield.omega);
  }
  subfields_ =
      TypedBuffer<float4>(lights_.device(), technique_name, "directions of subfields", directions, "lower perturb");
  ScheduleRecorder recorder = scheduler_->record("scatter", technique_name);
  first_tile_ = recorder.variable("first_tile", 0u);
  end_tile_ = recorder.variable("tiles", 0u);
  sweep_ = recorder.variable("sweep", 0u);
  inverse_scale_ = recorder.variable("inverse_scale", 1.f);
  scale_ = recorder.variable("scale", 1.f);
  PassBuilder pass = recorder.pass("scatter", program, "scatter_cells");
  scene.bind(pass);
  atlas.bind(pass);
  maps_->bind(pass);
  pass.global(chunks(std::min(kTilesAtOnce, maps_->tiles())))
      .local(1)
      .arg("tile_list", maps_->tile_list())
      .arg("first_tile", first_tile_)
      .arg("tiles", end_tile_)
      .arg("sweep", sweep_)
      .arg("split", options_.split ? 1u : 0u)
      .arg("splat", static_cast<uint32_t>(options_.mode))
      .arg("subfields", subfields_)
      .arg("perturb", options_.perturb)
      .arg("inverse_scale", inverse_scale_)
      .arg("lights", lights_)
      .arg("visible", visible_)
      .arg("scale", scale_)
      .arg("cell_side", cells_.side)
      .arg("incoming", cells_.incoming)
      .arg("sent", cells_.sent)
      .arg("total", cells_.total)
      .arg("direct", cells_.direct)
      .arg("norms", tile_norms_);
  scatter_ = recorder.compile();
}

void CellScatter::record_visibility(Device& device, const SceneBuffers& scene, const SurfaceAtlas& atlas,
                                    const Intersector& intersector) {
  const uint32_t sides = atlas.info().texel_count;
  const Program program = make_field_program(device, "scatter/light_visibility", ray_end_defines(intersector));
  ScheduleRecorder recorder = scheduler_->record("visibility of lights", technique_name);
  light_ = recorder.variable("light", 0u);
  bit_ = recorder.variable("bit", 0u);
  const BufferRef rays = recorder.transient<Ray>("rays to a light", sides, remedies::lower_texels),
                  ends = transient_ray_ends(recorder, intersector, "ends of rays to a light", sides),
                  occluded = recorder.transient<uint32_t>("occluded", sides, remedies::lower_texels);
  PassBuilder aim = recorder.pass("aim at light", program, "aim_at_light");
  scene.bind(aim);
  atlas.bind(aim);
  maps_->bind(aim);
  aim.global(sides)
      .arg("sides", sides)
      .arg("light", light_)
      .arg("seed", options_.seed)
      .arg("rays", rays)
      .arg_if_present("ends", ends);
  count_ = TypedBuffer<uint32_t>(device, technique_name, "number of texel sides", std::vector<uint32_t>{sides});
  intersector.record_any(recorder, "shadow rays", {rays, count_, 0, sides, ends}, occluded);
  recorder.pass("see light", program, "see_light")
      .global(sides)
      .arg("sides", sides)
      .arg("bit", bit_)
      .arg("rays", rays)
      .arg("occluded", occluded)
      .arg("visible", visible_);
  see_ = recorder.compile();
}

void CellScatter::begin() {
  cells_.side.upload(std::vector<uint32_t>(maps_->cells(), LUCARIUM_NONE));
  const std::vector<uint32_t> none(maps_->cells(), FIELD_NO_CELL);
  cells_.sent.upload(none);
  cells_.total.upload(none);
  if (options_.split) cells_.direct.upload(none);
  next_tile_ = next_light_ = 0;
}

bool CellScatter::see_light() {
  see_.set(light_, host_lights_[next_light_]);
  see_.set(bit_, next_light_);
  if (scheduler_->run(see_) == RunResult::cancelled) return false;
  ++next_light_;
  return true;
}

double CellScatter::scatter(uint32_t sweep, float scale) {
  if (complete()) next_tile_ = 0;
  const uint32_t end = std::min(next_tile_ + kTilesAtOnce, maps_->tiles());
  scatter_.set(first_tile_, next_tile_);
  scatter_.set(end_tile_, end);
  scatter_.set(sweep_, sweep);
  scatter_.set(inverse_scale_, 1 / scale);
  scatter_.set(scale_, scale);
  scheduler_->run_to_end(scatter_);  // norms take what was sent before
  const double cells = static_cast<double>(maps_->cells()) * (end - next_tile_) / maps_->tiles();
  cells_scattered_ += static_cast<uint64_t>(cells);
  next_tile_ = end;
  if (complete()) scheduler_->run_to_end(sum_);
  return cells;
}

void CellScatter::add(uint32_t sweep, const float4& tail) {
  add_.set(tail_, tail);
  add_.set(added_sweep_, sweep);
  scheduler_->run_to_end(add_);
}

size_t CellScatter::estimate_bytes(size_t sides, bool lights) {
  return sides * (sizeof(uint32_t) + (lights ? sizeof(Ray) + sizeof(uint32_t) : 0));
}

void CellScatter::warm_up() {
  if (see_) scheduler_->warm_up(see_);
  scheduler_->warm_up(scatter_);
  scheduler_->warm_up(sum_);
  scheduler_->warm_up(add_);
}

}  // namespace lucarium::vlf
