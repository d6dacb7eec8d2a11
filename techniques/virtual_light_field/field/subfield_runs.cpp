// SPDX-License-Identifier: Apache-2.0
#include "virtual_light_field/field/subfield_runs.h"

#include <algorithm>
#include <cmath>

#include "lucarium/base/seed.h"
#include "lucarium/compute/device/remedies.h"
#include "lucarium/compute/program/source_library.h"
#include "virtual_light_field/base/field_program.h"

namespace lucarium::vlf {
namespace {

constexpr const char* kFewerCells = "lower dir_n, cells or texels";

/// Per texel side the extinction of the volume that it looks into: of backs of refracting volumes. Empty: there is
/// none.
std::vector<float4> side_extinctions(const Scene& scene, const SceneBuffers& buffers, const SurfaceAtlas& atlas) {
  if (SubfieldRuns::can_keep(scene)) return {};
  const std::vector<Material> materials = buffers.scene_materials.download();
  const std::vector<Instance> instances = buffers.scene_instances.download();
  const std::vector<Triangle> triangles = buffers.scene_triangles.download();
  const std::vector<AtlasTexel> texels = atlas.texels().download();
  const uint32_t backs = atlas.info().double_sided_count;
  std::vector<float4> result(texels.size());
  for (uint32_t side = backs; side < 2 * backs; ++side) {
    const Material& m = materials[instances[triangles[texels[side].triangle].instance].material];
    if ((m.flags & LUCARIUM_MATERIAL_TRANSMISSIVE) && !(m.flags & LUCARIUM_MATERIAL_THIN))
      result[side] = float4(m.attenuation.xyz(), 0);
  }
  return result;
}

}  // namespace

SubfieldRuns::SubfieldRuns(Device& device, KernelScheduler& scheduler, const Scene& host_scene,
                           const SceneBuffers& scene, const DirectionGrid& grid, const TileMaps& maps,
                           const SurfaceAtlas& atlas, const LayeredRaster& raster, const TexelInterior& interior,
                           const SideAccessibility& accessibility, const CellBuffers& cells,
                           const TypedBuffer<float4>& records, const Options& options)
    : scheduler_(&scheduler),
      depth_range_(2.002 * static_cast<double>(host_scene.bounds().radius()) + 1e-6),
      maps_(&maps),
      options_(options),
      views_(device, technique_name, "view of a subfield", 1),
      ends_(device, technique_name, "ends of rays", 2),
      distance_(device, technique_name, "distances of a line's cells", maps.largest_survey(), kFewerCells) {
  if (options.perturb > 1)
    perturbed_ = make_perturbed_lines(grid, options.perturb, host_scene.bounds(), options.subfield.cells,
                                      options.subfield.cell, options.seed);
  const size_t sums = maps.largest_line();
  if (options.perturb > 1)
    fixed_ =
        TypedBuffer<uint32_t>(device, technique_name, "sums of a line's cells", FIELD_FIXED_WORDS * sums, kFewerCells);
  else
    received_ = TypedBuffer<float4>(device, technique_name, "sums of a line's cells", sums, kFewerCells);
  coarse_ = TypedBuffer<uint32_t>(device, technique_name, "sums of coarse cells",
                                  FIELD_FIXED_WORDS * std::max<size_t>(maps.coarse_cells(), 1), kFewerCells);
  coarse_.fill_zero();
  const std::vector<float4> extinctions = side_extinctions(host_scene, scene, atlas);
  if (!extinctions.empty())
    extinction_ =
        TypedBuffer<float4>(device, technique_name, "extinction at texel sides", extinctions, remedies::lower_texels);
  record_begin(device, scene);
  const Program average = make_field_program(device, "exchange/average_line");
  if (maps.cells() > 0) {
    record_survey(raster, atlas, cells, average, false, &survey_);
    if (maps.info().first_coarse > 0) record_average(cells, average);
    if (maps.coarse_cells() > 0) record_coarse_average(cells, average);
  }
  record_exchange(device, raster, atlas, interior, accessibility, cells, records, false, &exchange_);
  if (options.cache == 0 || !can_keep(host_scene) || accessibility.side_halves().count > KeptRows::kMaxHalves) return;
  KeptRows::Options keeping;
  keeping.views = subfields();
  keeping.height = options.subfield.cells << options.subfield.shift;
  keeping.bytes = options.cache;
  keeping.owner = technique_name;
  keeping.remedy = "lower cache_visibility";
  kept_ = std::make_unique<KeptRows>(device, scheduler, raster, atlas, interior, accessibility, views_, keeping);
  record_exchange(device, raster, atlas, interior, accessibility, cells, records, true, &exchange_kept_);
  if (maps.cells() > 0 && options.perturb == 1) record_survey(raster, atlas, cells, average, true, &survey_kept_);
}

void SubfieldRuns::record_begin(Device& device, const SceneBuffers& scene) {
  const Program program(
      device, SourceLibrary(),
      {"services/texel_sides/begin_direction", {"lucarium/services/texel_sides/begin_direction.cl"}, {}});
  ScheduleRecorder recorder = scheduler_->record("begin subfield", technique_name);
  view_ = recorder.variable("view", LayeredView{});
  omega_ = recorder.variable("omega", float4(0, 0, 1, 0));
  emission_ = recorder.variable("emission", 0u);
  PassBuilder pass = recorder.pass("begin subfield", program, "begin_direction");
  scene.bind(pass);
  pass.global(1).local(1).arg("view", view_).arg("omega", omega_).arg("emission", emission_);
  pass.arg("views", views_).arg("ends", ends_);
  begin_ = recorder.compile();
}

void SubfieldRuns::record_survey(const LayeredRaster& raster, const SurfaceAtlas& atlas, const CellBuffers& cells,
                                 const Program& average, bool kept, Run* target) {
  ScheduleRecorder recorder = scheduler_->record(kept ? "survey of a kept line" : "survey of a line", technique_name);
  Run run;
  run.line = recorder.variable("line", 0u);
  run.first_cell = recorder.variable("first_cell", 0u);
  run.coarse_base = recorder.variable("coarse_base", 0u);
  run.cells = recorder.variable("count", 0u);
  recorder.pass("clear distances", average, "clear_survey")
      .global(maps_->largest_survey())
      .arg("count", run.cells)
      .arg("distances", distance_);
  const Program program = make_field_program(views_.device(), "exchange/survey_line", raster.defines());
  const auto bind = [&](PassBuilder& pass) {
    atlas.bind(pass);
    maps_->bind(pass);
    pass.arg("line", run.line)
        .arg("first_cell", run.first_cell)
        .arg("coarse_base", run.coarse_base)
        .arg("shift", options_.subfield.shift)
        .arg("distances", distance_)
        .arg("cell_side", cells.side);
  };
  if (kept)
    kept_->record_walk(recorder, "survey", run.line, program, "survey_kept_line", bind);
  else
    raster.record_tiles(recorder, "survey", {views_, recorder.variable("view index", 0u)}, program, "survey_line",
                        bind);
  run.schedule = recorder.compile();
  *target = std::move(run);
}

void SubfieldRuns::record_exchange(Device& device, const LayeredRaster& raster, const SurfaceAtlas& atlas,
                                   const TexelInterior& interior, const SideAccessibility& accessibility,
                                   const CellBuffers& cells, const TypedBuffer<float4>& records, bool kept, Run* run) {
  std::map<std::string, std::string> defines = raster.defines();
  if (extinction_) defines["FIELD_MEDIA"] = "";
  if (options_.perturb > 1) defines["FIELD_PERTURBED"] = "";
  const SideHalves halves = accessibility.side_halves();
  defines.merge(halves.defines());
  const bool levels = maps_->coarse_cells() > 0;
  if (levels) defines["FIELD_LEVELS"] = "";
  const Program program = make_field_program(device, "exchange/exchange_line", defines);
  ScheduleRecorder recorder =
      scheduler_->record(kept ? "exchange along a kept subfield" : "exchange along a subfield", technique_name);
  run->line = recorder.variable("line", 0u);
  run->first_cell = recorder.variable("first_cell", 0u);
  run->subfield = recorder.variable("subfield", 0u);
  run->weight = recorder.variable("weight", 1.f);
  run->inverse_scale = recorder.variable("inverse_scale", 1.f);
  const auto bind = [&](PassBuilder& pass) {
    atlas.bind(pass);
    maps_->bind(pass);
    pass.arg("line", run->line)
        .arg("first_cell", run->first_cell)
        .arg("shift", options_.subfield.shift)
        .arg("accessibility", accessibility.parts())
        .arg("interior", interior.shares())
        .arg("weight", run->weight)
        .arg("inverse_scale", run->inverse_scale)
        .arg("ends", ends_)
        .arg("sent", cells.sent)
        .arg("records", records);
    if (fixed_ || levels) pass.arg("cellwise", options_.cellwise ? 1u : 0u).arg("coarse", coarse_);
    if (fixed_)
      pass.arg("received", fixed_);
    else
      pass.arg("received", received_);
    if (extinction_) pass.arg("extinction", extinction_);
    if (halves.two()) pass.arg("covered", halves.covered).arg("sides", halves.sides);
    if (kept) pass.arg("layered_views", views_);
  };
  if (kept)
    kept_->record_walk(recorder, "exchange", run->subfield, program, "exchange_kept_line", bind);
  else
    raster.record_tiles(recorder, "exchange", {views_, recorder.variable("view index", 0u)}, program, "exchange_line",
                        bind);
  run->schedule = recorder.compile();
}

void SubfieldRuns::record_average(const CellBuffers& cells, const Program& average) {
  ScheduleRecorder recorder = scheduler_->record("average cells", technique_name);
  average_.first_cell = recorder.variable("first_cell", 0u);
  average_.cells = recorder.variable("count", 0u);
  average_.scale = recorder.variable("scale", 1.f);
  PassBuilder pass = recorder.pass("average cells", average, fixed_ ? "average_perturbed" : "average_line");
  pass.global(maps_->largest_line())
      .arg("count", average_.cells)
      .arg("first_cell", average_.first_cell)
      .arg("incoming", cells.incoming);
  if (fixed_)
    pass.arg("received", fixed_);
  else
    pass.arg("scale", average_.scale).arg("received", received_);
  average_.schedule = recorder.compile();
}

void SubfieldRuns::record_coarse_average(const CellBuffers& cells, const Program& average) {
  ScheduleRecorder recorder = scheduler_->record("average coarse cells", technique_name);
  recorder.pass("average coarse cells", average, "average_perturbed")
      .global(maps_->coarse_cells())
      .arg("count", maps_->coarse_cells())
      .arg("first_cell", maps_->info().first_coarse)
      .arg("incoming", cells.incoming)
      .arg("received", coarse_);
  average_coarse_ = recorder.compile();
}

void SubfieldRuns::average_coarse() {
  if (average_coarse_) scheduler_->run_to_end(average_coarse_);
}

bool SubfieldRuns::can_keep(const Scene& scene) {
  return std::none_of(scene.materials.begin(), scene.materials.end(), [](const SceneMaterial& m) {
    return m.transmission > 0 && m.thickness > 0 && std::isfinite(m.attenuation_distance);
  });
}

double SubfieldRuns::pixels() const {
  return std::ldexp(1., static_cast<int>(2 * options_.subfield.shift)) * options_.subfield.cells *
         options_.subfield.cells;
}

bool SubfieldRuns::begin(const FieldLine& subfield, uint32_t number, bool emission) {
  const auto pixels = static_cast<float>(1u << options_.subfield.shift);
  const auto times = [&](const float4& row) {
    return float4(row.x * pixels, row.y * pixels, row.z * pixels, row.w * pixels);
  };
  LayeredView view{};
  view.row_x = times(subfield.row_x);
  view.row_y = times(subfield.row_y);
  view.row_w = subfield.row_w;
  view.depth_min = static_cast<float>(-0.5 * depth_range_);
  view.depth_scale = static_cast<float>(1 / depth_range_);
  view.width = view.height = options_.subfield.cells << options_.subfield.shift;
  view.seed = indexed_seed(options_.blend_seed, number);
  begin_.set(view_, view);
  begin_.set(omega_, float4(subfield.omega.xyz(), 0.f));
  begin_.set(emission_, emission ? 1u : 0u);
  return scheduler_->run(begin_) == RunResult::done;
}

bool SubfieldRuns::survey(uint32_t line) {
  if (!begin(maps_->host_lines()[line], line, false)) return false;
  const std::vector<uint32_t>& first = maps_->first_cells();
  Run& run = survey_kept_.schedule && kept_->has(line) ? survey_kept_ : survey_;
  run.schedule.set(run.line, line);
  const std::vector<uint32_t>& coarse = maps_->first_coarse_cells();
  const uint32_t fine = first[2 * line + 2] - first[2 * line];
  run.schedule.set(run.first_cell, first[2 * line]);
  run.schedule.set(run.coarse_base, coarse[2 * line] - fine);
  run.schedule.set(run.cells, fine + coarse[2 * line + 2] - coarse[2 * line]);
  scheduler_->run_to_end(run.schedule);
  return true;
}

bool SubfieldRuns::keep(uint32_t subfield) {
  if (!begin(host_subfields()[subfield], subfield, false)) return false;
  kept_->keep(subfield);
  return true;
}

bool SubfieldRuns::exchange(uint32_t subfield, bool emission, float scale) {
  const FieldLine& frame = host_subfields()[subfield];
  if (!begin(frame, subfield, emission)) return false;
  const uint32_t line = subfield / options_.perturb;
  const std::vector<uint32_t>& first = maps_->first_cells();
  Run& run = kept_ && kept_->has(subfield) ? exchange_kept_ : exchange_;
  run.schedule.set(run.line, line);
  run.schedule.set(run.first_cell, first[2 * line]);
  run.schedule.set(run.subfield, subfield);
  run.schedule.set(run.weight, frame.omega.w);
  run.schedule.set(run.inverse_scale, 1 / scale);
  scheduler_->run_to_end(run.schedule);
  ++drawn_;
  if (!average_.schedule || subfield % options_.perturb + 1 < options_.perturb) return true;
  average_.schedule.set(average_.first_cell, first[2 * line]);
  average_.schedule.set(average_.cells, first[2 * line + 2] - first[2 * line]);
  average_.schedule.set(average_.scale, scale);
  scheduler_->run_to_end(average_.schedule);
  return true;
}

void SubfieldRuns::warm_up() {
  scheduler_->warm_up(begin_);
  if (survey_.schedule) scheduler_->warm_up(survey_.schedule);
  if (kept_) {
    kept_->warm_up();
    scheduler_->warm_up(exchange_kept_.schedule);
    if (survey_kept_.schedule) scheduler_->warm_up(survey_kept_.schedule);
  }
  scheduler_->warm_up(exchange_.schedule);
  if (average_.schedule) scheduler_->warm_up(average_.schedule);
  if (average_coarse_) scheduler_->warm_up(average_coarse_);
}

}  // namespace lucarium::vlf
