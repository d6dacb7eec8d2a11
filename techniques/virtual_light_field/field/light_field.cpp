// SPDX-License-Identifier: Apache-2.0
#include "virtual_light_field/field/light_field.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "lucarium/compute/program/source_library.h"
#include "lucarium/services/ray_ends.h"
#include "virtual_light_field/base/field_program.h"

namespace lucarium::vlf {
namespace {

constexpr double kWorkAtOnce = 4e6;             // pixels of films in a call of advance(), or what takes as long:
constexpr double kCellWork = 4, kSideWork = 2;  // a cell that is scattered; a texel side at the end of a sweep
constexpr uint32_t kTilesAtOnce = 1u << 12;     // in a pass
constexpr uint32_t kMaxSweeps = 256;
constexpr double kPi = 3.14159265358979323846;
constexpr double kMaxPeak = 1e5;   // of highlights, over diffuse light
constexpr float kMaxStored = 256;  // stored radiance of the brightest sender; bounces add up to 255 times as much
constexpr const char* kFewerCells = "lower dir_n or cells";
constexpr const char* kFewerTexels = "lower texels";

uint32_t divide_up(uint32_t a, uint32_t b) { return (a + b - 1) / b; }

double brightest(const glm::vec3& c) { return static_cast<double>(std::max(c.x, std::max(c.y, c.z))); }

/// Per texel side the extinction of the volume that it looks into: of backs of refracting volumes. Empty: there is
/// none.
std::vector<float4> side_extinctions(const Scene& scene, const SceneBuffers& buffers, const SurfaceAtlas& atlas) {
  const bool any = std::any_of(scene.materials.begin(), scene.materials.end(), [](const SceneMaterial& m) {
    return m.transmission > 0 && m.thickness > 0 && std::isfinite(m.attenuation_distance);
  });
  if (!any) return {};
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

/// Entries of the light mixture of the brightest punctual lights, which stand there first, without dark ones, in the
/// order of the scene.
std::vector<uint32_t> brightest_lights(const Scene& scene) {
  std::vector<double> intensities;
  for (const SceneLight& light : scene.lights)
    if (light.intensity != glm::vec3(0)) intensities.push_back(brightest(light.intensity));
  std::vector<uint32_t> order(intensities.size());
  std::iota(order.begin(), order.end(), 0u);
  std::stable_sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) { return intensities[a] > intensities[b]; });
  order.resize(std::min<size_t>(order.size(), LightField::kMaxLights));
  return order;
}

/// What texel sides reflect diffusely in propagation.
std::vector<float4> transport_albedo(const std::vector<AtlasMaterial>& materials, const Patches& patches, bool fold) {
  std::vector<float4> result;
  for (size_t side = 0; side < materials.size(); ++side) {
    glm::vec3 albedo = materials[side].diffuse.xyz();
    if (fold && patches.side_facet[side] == LUCARIUM_NONE) albedo += patches.side_albedo[side].xyz();
    result.emplace_back(albedo, 0.f);
  }
  return result;
}

}  // namespace

LightField::LightField(Device& device, KernelScheduler& scheduler, const Scene& host_scene, const SceneBuffers& scene,
                       const Intersector& intersector, const SurfaceAtlas& atlas, const Patches& patches,
                       const LayeredRaster& raster, const TexelInterior& interior,
                       const SideAccessibility& accessibility, const TypedBuffer<float4>& light_samples,
                       const Options& options)
    : scheduler_(&scheduler),
      host_scene_(&host_scene),
      scene_(&scene),
      atlas_(&atlas),
      options_(options),
      grid_(options.dir_n, options.seed),
      maps_(device, scheduler, host_scene, scene, grid_, patches,
            {options.film.film, options.film.cell, atlas.info().texel_edge, options.seed}),
      tiled_(maps_.cells() > 0),
      sides_(atlas.info().texel_count),
      light_samples_(light_samples),
      albedo_(device, technique_name, "albedo of texel sides",
              transport_albedo(atlas.materials().download(), patches, options.fold), kFewerTexels),
      records_(device, technique_name, "records of texel sides", 2 * size_t{sides_}, kFewerTexels),
      direct_(device, technique_name, "direct light of texel sides", sides_, kFewerTexels),
      indirect_(device, technique_name, "indirect light of texel sides", sides_, kFewerTexels),
      last_(device, technique_name, "light of the last sweep", sides_, kFewerTexels),
      shown_direct_(device, technique_name, "displayed direct light", sides_, kFewerTexels),
      shown_(device, technique_name, "displayed indirect light", sides_, kFewerTexels),
      held_(device, technique_name, "light that rays look up", sides_, kFewerTexels),
      shares_(accessibility.shares()),
      cell_side_(device, technique_name, "texel sides of cells", maps_.cells(), kFewerCells),
      incoming_(device, technique_name, "light received by cells", maps_.cells(), kFewerCells),
      sent_(device, technique_name, "light sent by cells", maps_.cells(), kFewerCells),
      total_(device, technique_name, "light of cells", maps_.cells(), kFewerCells),
      direct_cells_(device, technique_name, "direct light of cells", options.split ? maps_.cells() : 0, kFewerCells),
      received_(device, technique_name, "sums of a line's cells", maps_.largest_line(), kFewerCells),
      side_norms_(device, technique_name, "norms of texel sides",
                  size_t{FIELD_NORMS} * divide_up(sides_, FIELD_NORM_CHUNK), kFewerTexels),
      tile_norms_(device, technique_name, "norms of tiles", size_t{FIELD_NORMS} * maps_.tiles(), kFewerCells),
      norms_(device, technique_name, "norms", FIELD_NORMS),
      distance_(device, technique_name, "distances of a line's cells", maps_.largest_line(), kFewerCells),
      views_(device, technique_name, "view of a line", 1),
      ends_(device, technique_name, "ends of rays", 2),
      host_lights_(brightest_lights(host_scene)),
      lights_(device, technique_name, "punctual lights",
              host_lights_.empty() ? std::vector<uint32_t>{0} : host_lights_),
      visible_(device, technique_name, "lights that texel sides see", sides_, kFewerTexels),
      side_program_(make_field_program(device, "scatter/fold_sides")) {
  const std::vector<float4> extinctions = side_extinctions(host_scene, scene, atlas);
  if (!extinctions.empty())
    extinction_ = TypedBuffer<float4>(device, technique_name, "extinction at texel sides", extinctions, kFewerTexels);
  record_sides();
  record_lines(device, raster, interior, accessibility);
  if (!tiled_) return;
  record_scatter(device);
  if (!host_lights_.empty()) record_visibility(device, intersector);
}

// ---- schedules

void LightField::record_sides() {
  ScheduleRecorder emit = scheduler_->record("begin propagation", technique_name);
  PassBuilder first = emit.pass("emit", side_program_, "emit_sides");
  atlas_->bind(first);
  maps_.bind(first);
  first.global(sides_).arg("sides", sides_).arg("records", records_);
  emit_ = emit.compile();

  const uint32_t chunks = divide_up(sides_, FIELD_NORM_CHUNK);
  ScheduleRecorder fold = scheduler_->record("end of a sweep", technique_name);
  fold_sweep_ = fold.variable("sweep", 0u);
  PassBuilder sides = fold.pass("fold texel sides", side_program_, "fold_sides");
  atlas_->bind(sides);
  sides.global(chunks)
      .arg("sides", sides_)
      .arg("sweep", fold_sweep_)
      .arg("sampled", options_.sampled ? 1u : 0u)
      .arg("albedo", albedo_)
      .arg("shares", shares_)
      .arg("light_samples", light_samples_)
      .arg("records", records_)
      .arg("direct", direct_)
      .arg("indirect", indirect_)
      .arg("last", last_)
      .arg("norms", side_norms_);
  fold.pass("sum norms", side_program_, "sum_norms")
      .global(FIELD_NORMS)
      .arg("chunks", chunks)
      .arg("partial", side_norms_)
      .arg("norms", norms_);
  fold_ = fold.compile();

  ScheduleRecorder show = scheduler_->record("show texel sides", technique_name);
  show_tail_ = show.variable("tail", float4{});
  show_hold_ = show.variable("hold", 0u);
  show.pass("show texel sides", side_program_, "show_sides")
      .global(sides_)
      .arg("sides", sides_)
      .arg("tail", show_tail_)
      .arg("hold", show_hold_)
      .arg("shares", shares_)
      .arg("direct", direct_)
      .arg("indirect", indirect_)
      .arg("last", last_)
      .arg("shown_direct", shown_direct_)
      .arg("shown", shown_)
      .arg("held", held_);
  show_ = show.compile();
}

LightField::LineSchedule LightField::begin_line(ScheduleRecorder& recorder) {
  LineSchedule line;
  line.line = recorder.variable("line", 0u);
  line.first_cell = recorder.variable("first_cell", 0u);
  line.cells = recorder.variable("count", 0u);
  return line;
}

void LightField::record_lines(Device& device, const LayeredRaster& raster, const TexelInterior& interior,
                              const SideAccessibility& accessibility) {
  const Program begin(
      device, SourceLibrary(),
      {"services/texel_sides/begin_direction", {"lucarium/services/texel_sides/begin_direction.cl"}, {}}),
      average = make_field_program(device, "exchange/average_line");
  ScheduleRecorder beginning = scheduler_->record("begin line", technique_name);
  line_view_ = beginning.variable("view", LayeredView{});
  line_omega_ = beginning.variable("omega", float4(0, 0, 1, 0));
  line_emission_ = beginning.variable("emission", 0u);
  PassBuilder first = beginning.pass("begin line", begin, "begin_direction");
  scene_->bind(first);
  first.global(1).local(1).arg("view", line_view_).arg("omega", line_omega_).arg("emission", line_emission_);
  first.arg("views", views_).arg("ends", ends_);
  begin_line_ = beginning.compile();
  std::map<std::string, std::string> defines = raster.defines();
  const auto bind_line = [&](PassBuilder& pass, const LineSchedule& line) {
    atlas_->bind(pass);
    maps_.bind(pass);
    pass.arg("line", line.line).arg("first_cell", line.first_cell).arg("shift", options_.film.shift);
  };
  if (tiled_) {
    ScheduleRecorder recorder = scheduler_->record("survey of a line", technique_name);
    LineSchedule line = begin_line(recorder);
    recorder.pass("clear distances", average, "clear_survey")
        .global(maps_.largest_line())
        .arg("count", line.cells)
        .arg("distances", distance_);
    const Program program = make_field_program(device, "exchange/survey_line", defines);
    raster.record_tiles(recorder, "survey", {views_, recorder.variable("view index", 0u)}, program, "survey_line",
                        [&](PassBuilder& pass) {
                          bind_line(pass, line);
                          pass.arg("distances", distance_).arg("cell_side", cell_side_);
                        });
    line.schedule = recorder.compile();
    survey_ = std::move(line);
  }
  ScheduleRecorder recorder = scheduler_->record("exchange along a line", technique_name);
  LineSchedule line = begin_line(recorder);
  line.weight = recorder.variable("weight", 1.f);
  line.scale = recorder.variable("scale", 1.f);
  line.inverse_scale = recorder.variable("inverse_scale", 1.f);
  if (extinction_) defines["FIELD_MEDIA"] = "";
  const Program program = make_field_program(device, "exchange/exchange_line", defines);
  raster.record_tiles(recorder, "exchange", {views_, recorder.variable("view index", 0u)}, program, "exchange_line",
                      [&](PassBuilder& pass) {
                        bind_line(pass, line);
                        pass.arg("accessibility", accessibility.parts())
                            .arg("interior", interior.shares())
                            .arg("weight", line.weight)
                            .arg("inverse_scale", line.inverse_scale)
                            .arg("ends", ends_)
                            .arg("sent", sent_)
                            .arg("records", records_)
                            .arg("received", received_);
                        if (extinction_) pass.arg("extinction", extinction_);
                      });
  if (tiled_)
    recorder.pass("average cells", average, "average_line")
        .global(maps_.largest_line())
        .arg("count", line.cells)
        .arg("first_cell", line.first_cell)
        .arg("scale", line.scale)
        .arg("received", received_)
        .arg("incoming", incoming_);
  line.schedule = recorder.compile();
  line_ = std::move(line);
}

void LightField::record_scatter(Device& device) {
  const Program program = make_field_program(device, "scatter/scatter_cells");
  ScheduleRecorder recorder = scheduler_->record("scatter", technique_name);
  scatter_first_ = recorder.variable("first_tile", 0u);
  scatter_end_ = recorder.variable("tiles", 0u);
  scatter_sweep_ = recorder.variable("sweep", 0u);
  scatter_scale_ = recorder.variable("inverse_scale", 1.f);
  field_scale_ = recorder.variable("scale", 1.f);
  PassBuilder pass = recorder.pass("scatter", program, "scatter_cells");
  scene_->bind(pass);
  atlas_->bind(pass);
  maps_.bind(pass);
  pass.global(std::min(kTilesAtOnce, maps_.tiles()))
      .local(1)
      .arg("tile_list", maps_.tile_list())
      .arg("first_tile", scatter_first_)
      .arg("tiles", scatter_end_)
      .arg("sweep", scatter_sweep_)
      .arg("split", options_.split ? 1u : 0u)
      .arg("inverse_scale", scatter_scale_)
      .arg("lights", lights_)
      .arg("visible", visible_)
      .arg("scale", field_scale_)
      .arg("cell_side", cell_side_)
      .arg("incoming", incoming_)
      .arg("sent", sent_)
      .arg("total", total_)
      .arg("direct", direct_cells_)
      .arg("norms", tile_norms_);
  scatter_ = recorder.compile();

  ScheduleRecorder sums = scheduler_->record("norms of cells", technique_name);
  sums.pass("sum norms", side_program_, "sum_norms")
      .global(FIELD_NORMS)
      .arg("chunks", maps_.tiles())
      .arg("partial", tile_norms_)
      .arg("norms", norms_);
  sum_tiles_ = sums.compile();

  ScheduleRecorder totals = scheduler_->record("totals of cells", technique_name);
  cell_tail_ = totals.variable("tail", float4{});
  cell_sweep_ = totals.variable("sweep", 0u);
  totals.pass("add cells", program, "add_cells")
      .global(maps_.cells())
      .arg("count", maps_.cells())
      .arg("sweep", cell_sweep_)
      .arg("split", options_.split ? 1u : 0u)
      .arg("tail", cell_tail_)
      .arg("sent", sent_)
      .arg("direct", direct_cells_)
      .arg("total", total_);
  add_cells_ = totals.compile();
}

void LightField::record_visibility(Device& device, const Intersector& intersector) {
  const Program program = make_field_program(device, "scatter/light_visibility", ray_end_defines(intersector));
  ScheduleRecorder recorder = scheduler_->record("visibility of lights", technique_name);
  seen_light_ = recorder.variable("light", 0u);
  seen_bit_ = recorder.variable("bit", 0u);
  const BufferRef rays = recorder.transient<Ray>("rays to a light", sides_, kFewerTexels),
                  ends = transient_ray_ends(recorder, intersector, "ends of rays to a light", sides_),
                  occluded = recorder.transient<uint32_t>("occluded", sides_, kFewerTexels);
  PassBuilder aim = recorder.pass("aim at light", program, "aim_at_light");
  scene_->bind(aim);
  atlas_->bind(aim);
  maps_.bind(aim);
  aim.global(sides_)
      .arg("sides", sides_)
      .arg("light", seen_light_)
      .arg("seed", options_.line_seed)
      .arg("rays", rays)
      .arg_if_present("ends", ends);
  count_ = TypedBuffer<uint32_t>(device, technique_name, "number of texel sides", std::vector<uint32_t>{sides_});
  intersector.record_any(recorder, "shadow rays", {rays, count_, 0, sides_, ends}, occluded);
  recorder.pass("see light", program, "see_light")
      .global(sides_)
      .arg("sides", sides_)
      .arg("bit", seen_bit_)
      .arg("rays", rays)
      .arg("occluded", occluded)
      .arg("visible", visible_);
  see_ = recorder.compile();
}

// ---- propagation

void LightField::begin() {
  find_scale();
  scheduler_->run_to_end(emit_);
  scheduler_->finish();
  if (tiled_) {
    cell_side_.upload(std::vector<uint32_t>(maps_.cells(), LUCARIUM_NONE));
    sent_.upload(std::vector<uint32_t>(maps_.cells(), FIELD_NO_CELL));
    total_.upload(std::vector<uint32_t>(maps_.cells(), FIELD_NO_CELL));
    if (options_.split) direct_cells_.upload(std::vector<uint32_t>(maps_.cells(), FIELD_NO_CELL));
    stage_ = Stage::survey;
  } else {
    stage_ = Stage::transport;
  }
  next_light_ = next_line_ = next_tile_ = sweep_ = shown_sweeps_ = 0;
  begun_ = true;
}

/// A power of two that takes the brightest sender to the middle of what cells can hold.
void LightField::find_scale() {
  scheduler_->finish();
  double largest = 0;
  const std::vector<AtlasMaterial> materials = atlas_->materials().download();
  const std::vector<float4> samples = light_samples_.download();
  for (size_t side = 0; side < materials.size(); ++side) {
    largest = std::max(largest, brightest(materials[side].emission.xyz()));
    if (!(samples[side].w > 0)) continue;
    // Of a punctual light, rough metal sends as much as its lobe is narrow, D(n) = 1 / (pi alpha^2).
    const auto alpha = static_cast<double>(materials[side].diffuse.w);
    const double peak =
        host_lights_.empty() || !tiled_ || alpha == 0 ? 1 : std::clamp(1 / (alpha * alpha), 1., kMaxPeak);
    largest = std::max(largest, peak * brightest(samples[side].xyz()) / static_cast<double>(samples[side].w) / kPi);
  }
  if (const auto& sky = host_scene_->environment) {
    double value = sky->radiance.empty() ? 1 : 0;
    for (const glm::vec3& texel : sky->radiance) value = std::max(value, brightest(texel));
    largest = std::max(largest, value * brightest(sky->factor));
  }
  scale_ = largest > 0 && std::isfinite(largest)
               ? static_cast<float>(std::exp2(std::floor(std::log2(kMaxStored / largest))))
               : 1;
  scale_ = std::clamp(scale_, 0x1p-100f, 0x1p100f);
}

bool LightField::advance() {
  if (!begun_) begin();
  for (; next_light_ < host_lights_.size() && see_; ++next_light_) {
    see_.set(seen_light_, host_lights_[next_light_]);
    see_.set(seen_bit_, next_light_);
    if (scheduler_->run(see_) == RunResult::cancelled) return false;
  }
  for (double work = kWorkAtOnce; work > 0 && !done();) {
    if (stage_ == Stage::scatter) {
      work -= kCellWork * scatter_tiles();
      continue;
    }
    // Sampled direct light needs no first sweep, unless facets reflect emitters and sky.
    const bool known = stage_ == Stage::transport && sweep_ == 0 && options_.sampled && !tiled_;
    if (!known && next_line_ < grid_.lines()) {
      if (!run_line()) return false;
      work -= std::ldexp(1., static_cast<int>(2 * options_.film.shift)) * options_.film.film * options_.film.film;
      continue;
    }
    next_line_ = 0;
    work -= kSideWork * sides_;
    if (stage_ == Stage::survey)
      stage_ = Stage::transport;
    else
      end_sweep();
  }
  return true;
}

bool LightField::run_line() {
  LineSchedule& line = stage_ == Stage::survey ? survey_ : line_;
  const uint32_t index = next_line_;
  const FieldLine& frame = maps_.host_lines()[index];
  const auto pixels = static_cast<float>(1u << options_.film.shift);
  const auto times = [&](const float4& row) {
    return float4(row.x * pixels, row.y * pixels, row.z * pixels, row.w * pixels);
  };
  const Bounds bounds = host_scene_->bounds();
  const double range = 2.002 * static_cast<double>(bounds.radius()) + 1e-6;
  LayeredView view{};
  view.row_x = times(frame.row_x);
  view.row_y = times(frame.row_y);
  view.row_w = frame.row_w;
  view.depth_min = static_cast<float>(-0.5 * range);
  view.depth_scale = static_cast<float>(1 / range);
  view.width = view.height = options_.film.film << options_.film.shift;
  view.seed = options_.line_seed + index * 0x9e3779b9u;
  const std::vector<uint32_t>& first = maps_.first_cells();
  begin_line_.set(line_view_, view);
  begin_line_.set(line_omega_, float4(frame.omega.xyz(), 0.f));
  begin_line_.set(line_emission_, sweep_ == 0 ? 1u : 0u);
  if (scheduler_->run(begin_line_) == RunResult::cancelled) return false;
  line.schedule.set(line.line, index);
  line.schedule.set(line.first_cell, first[2 * index]);
  line.schedule.set(line.cells, first[2 * index + 2] - first[2 * index]);
  if (stage_ == Stage::transport) {
    line.schedule.set(line.weight, frame.omega.w);
    line.schedule.set(line.scale, scale_);
    line.schedule.set(line.inverse_scale, 1 / scale_);
  }
  scheduler_->run_to_end(line.schedule);  // half a line would be counted twice
  ++next_line_;
  ++lines_drawn_;
  film_pixels_ += static_cast<double>(view.width) * view.height;
  return true;
}

bool LightField::is_last() const {
  return options_.max_bounces >= 0 && sweep_ >= static_cast<uint32_t>(options_.max_bounces);
}

void LightField::end_sweep() {
  fold_.set(fold_sweep_, sweep_);
  scheduler_->run_to_end(fold_);
  side_sums_ = take_norms();
  next_tile_ = 0;
  if (tiled_ && (!is_last() || options_.scatter_last))
    stage_ = Stage::scatter;
  else
    finish_sweep(side_sums_);
}

double LightField::scatter_tiles() {
  const uint32_t end = std::min(next_tile_ + kTilesAtOnce, maps_.tiles());
  scatter_.set(scatter_first_, next_tile_);
  scatter_.set(scatter_end_, end);
  scatter_.set(scatter_sweep_, sweep_);
  scatter_.set(scatter_scale_, 1 / scale_);
  scatter_.set(field_scale_, scale_);
  scheduler_->run_to_end(scatter_);  // norms take what was sent before
  const double cells = static_cast<double>(maps_.cells()) * (end - next_tile_) / maps_.tiles();
  cells_scattered_ += static_cast<uint64_t>(cells);
  next_tile_ = end;
  if (next_tile_ < maps_.tiles()) return cells;
  scheduler_->run_to_end(sum_tiles_);
  Norms sums = side_sums_;
  const Norms added = take_norms();
  for (size_t k = 0; k < sums.size(); ++k)
    sums[k] = float4(sums[k].x + added[k].x, sums[k].y + added[k].y, sums[k].z + added[k].z, sums[k].w + added[k].w);
  finish_sweep(sums);
  return cells;
}

Norms LightField::take_norms() const {
  scheduler_->finish();
  const std::vector<float4> values = norms_.download();
  Norms result;
  std::copy(values.begin(), values.end(), result.begin());
  return result;
}

void LightField::finish_sweep(const Norms& norms) {
  const bool unlimited = options_.max_bounces < 0;
  if (sweep_ > 0) tail_ = find_tail(norms);
  // Nothing is sent any more: all is known.
  const bool dark = !(norms[0].x > 0 || norms[0].y > 0 || norms[0].z > 0);
  const double error = options_.tail ? tail_.error : tail_.without;
  const bool accurate = sweep_ > 1 && options_.residual > 0 && error < options_.residual;
  const bool last = is_last() || (unlimited && (dark || accurate || sweep_ + 1 >= kMaxSweeps));
  if (last) {
    why_done_ = !unlimited ? fmt::format("all {} bounces are propagated", options_.max_bounces)
                : dark     ? fmt::format("no light is left after {} sweeps", sweep_ + 1)
                : accurate ? fmt::format("the relative error is below {:.2g}, residual", error)
                           : fmt::format("all {} sweeps are done", kMaxSweeps);
  }
  float4 factor{};
  if (last && unlimited && options_.tail && std::isfinite(tail_.error)) factor = tail_.factor;
  // What is missing is λ / (1 - λ) times the last sweep's irradiance, and as much of what cells send next, which is
  // known.
  show_.set(show_tail_, factor);
  show_.set(show_hold_, is_last() ? 1u : 0u);
  scheduler_->run_to_end(show_);
  if (stage_ == Stage::scatter) {
    add_cells_.set(cell_tail_, factor);
    add_cells_.set(cell_sweep_, sweep_);
    scheduler_->run_to_end(add_cells_);
  }
  ++sweep_;
  ++shown_sweeps_;
  stage_ = last ? Stage::done : Stage::transport;
}

double LightField::progress() const {
  if (done()) return 1;
  if (!begun_) return 0;
  const double lines = static_cast<double>(next_line_) / grid_.lines();
  if (options_.max_bounces >= 0) {
    const double all = options_.max_bounces + (tiled_ ? 2. : 1.);
    return std::min((sweep_ + lines + (tiled_ && stage_ != Stage::survey ? 1. : 0.)) / all, 0.99);
  }
  // The error falls by a factor per sweep: on a logarithmic scale it comes evenly.
  const double error = options_.tail ? tail_.error : tail_.without;
  if (sweep_ < 3 || !(error > 0) || !std::isfinite(error) || !(options_.residual > 0))
    return std::min(0.05 * sweep_, 0.2);
  return std::clamp(std::log(error) / std::log(options_.residual), 0.2, 0.99);
}

std::string LightField::phase() const {
  switch (stage_) {
    case Stage::survey: return "survey";
    case Stage::transport: return fmt::format("sweep {}", sweep_);
    case Stage::scatter: return fmt::format("scatter {}", sweep_);
    case Stage::done: break;
  }
  return "walk";
}

void LightField::warm_up() {
  scheduler_->warm_up(emit_);
  scheduler_->warm_up(begin_line_);
  if (survey_.schedule) scheduler_->warm_up(survey_.schedule);
  scheduler_->warm_up(line_.schedule);
  scheduler_->warm_up(fold_);
  scheduler_->warm_up(show_);
  if (!tiled_) return;
  if (see_) scheduler_->warm_up(see_);
  scheduler_->warm_up(scatter_);
  scheduler_->warm_up(sum_tiles_);
  scheduler_->warm_up(add_cells_);
}

// ---- what is saved

namespace {

struct SavedField {
  float scale;
  uint32_t shown_sweeps, sweeps, cells;
};

}  // namespace

void LightField::save(StateWriter& chunks) const {
  scheduler_->finish();
  chunks.put_value("field", SavedField{scale_, shown_sweeps_, sweep_, maps_.cells()});
  chunks.put("why_done", std::vector<char>(why_done_.begin(), why_done_.end()));
  chunks.put("sides.direct", shown_direct_);
  chunks.put("sides.indirect", shown_);
  chunks.put("sides.held", held_);
  if (!tiled_) return;
  chunks.put("cells.total", total_);
  if (options_.split) chunks.put("cells.direct", direct_cells_);
}

void LightField::load(const StateReader& chunks) {
  const auto saved = chunks.get_value<SavedField>("field");
  if (saved.cells != maps_.cells())
    chunks.fail("field", fmt::format("{} cells, and the scene has {}", saved.cells, maps_.cells()));
  if (!(saved.scale > 0) || !std::isfinite(saved.scale)) chunks.fail("field", fmt::format("the scale {}", saved.scale));
  chunks.get_finite_buffer("sides.direct", shown_direct_);
  chunks.get_finite_buffer("sides.indirect", shown_);
  chunks.get_finite_buffer("sides.held", held_);
  if (tiled_) {
    chunks.get_buffer("cells.total", total_);
    if (options_.split) chunks.get_buffer("cells.direct", direct_cells_);
  }
  const std::vector<char> why = chunks.get<char>("why_done");
  why_done_.assign(why.begin(), why.end());
  scale_ = saved.scale;
  shown_sweeps_ = saved.shown_sweeps;
  sweep_ = saved.sweeps;
  begun_ = true;
}

size_t LightField::estimate_bytes(size_t sides) { return sides * (10 * sizeof(float4) + 2 * sizeof(uint32_t)); }

}  // namespace lucarium::vlf
