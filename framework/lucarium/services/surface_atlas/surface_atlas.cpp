// SPDX-License-Identifier: Apache-2.0
#include "lucarium/services/surface_atlas/surface_atlas.h"

#include <algorithm>
#include <cmath>

#include "lucarium/base/error.h"
#include "lucarium/base/interrupt.h"
#include "lucarium/base/stopwatch.h"
#include "lucarium/base/text/byte_size.h"
#include "lucarium/compute/program/source_library.h"
#include "lucarium/services/bvh/moving_parts.h"
#include "lucarium/services/surface_atlas/estimate.h"
#include "lucarium/services/surface_atlas/geometry.h"

namespace lucarium {
namespace {

constexpr double kMissedArea = 0.01;  // of triangles without texels, above which an atlas is built again [s²]

void measure_texels(const AtlasLayout& layout, SurfaceAtlasReport& report) {
  report.sides = layout.info.texel_count;
  report.texels = layout.info.texel_count - layout.info.double_sided_count;
  report.charts = layout.charts.size();
  report.one_texel_charts = static_cast<uint64_t>(
      std::count_if(layout.charts.begin(), layout.charts.end(), [](const AtlasChart& c) { return c.width == 1; }));
  report.cells = layout.info.cell_count;
  report.texel_edge = static_cast<double>(layout.info.texel_edge);
  std::vector<double> areas;
  for (const AtlasTexel& texel : layout.texels) {
    report.area += static_cast<double>(texel.area);
    areas.push_back(static_cast<double>(texel.area) / (report.texel_edge * report.texel_edge));
  }
  std::sort(areas.begin(), areas.end());
  const auto percentile = [&](double p) {
    return areas.empty() ? 0 : areas[static_cast<size_t>(p * static_cast<double>(areas.size() - 1))];
  };
  report.area_p5 = percentile(0.05), report.area_p50 = percentile(0.5), report.area_p95 = percentile(0.95);
}

}  // namespace

struct SurfaceAtlas::State {
  State(Device& device_, KernelScheduler& scheduler_, const SceneBuffers& scene_, const SurfaceAtlasOptions& options_,
        const std::string& owner_)
      : device(device_),
        scheduler(scheduler_),
        buffers(scene_),
        options(options_),
        owner(owner_),
        program(device, SourceLibrary(),
                {"services/surface_atlas",
                 {"lucarium/services/surface_atlas/fill_surface_atlas.cl",
                  "lucarium/services/surface_atlas/draw_atlas_layer.cl"},
                 {}}) {
    if (!options.cancelled) options.cancelled = interrupt_requested;
  }

  void build(const Scene& scene);
  void refuse_if_too_large(const Scene& scene) const;
  /// Whether triangles that had no area when the atlas was built have some now, beyond what rounding gives them.
  bool misses_area() const;
  void upload(const AtlasLayout& layout);
  void record();
  void run(Schedule& schedule) { scheduler.run_to_end(schedule); }
  void bind(PassBuilder& pass) const;

  Device& device;
  KernelScheduler& scheduler;
  const SceneBuffers& buffers;
  SurfaceAtlasOptions options;
  std::string owner;
  Program program;
  AtlasInfo info{};
  SurfaceAtlasReport report;
  std::vector<AtlasChart> charts;
  std::vector<uint32_t> left_out;
  std::vector<uint8_t> two_sided;
  TypedBuffer<AtlasTriangle> triangles;
  TypedBuffer<uint32_t> table;
  TypedBuffer<uint8_t> links;
  TypedBuffer<AtlasTexel> texels;
  TypedBuffer<SurfacePoint> points;
  TypedBuffer<AtlasMaterial> materials;
  TypedBuffer<uint2> ranges;
  TypedBuffer<TexelPiece> pieces;
  TypedBuffer<AtlasSample> samples;
  Schedule place, shade;
  uint64_t generation = 0, scene_generation = 0;
};

// Before the work, from the estimate: the host would need as much while it lays the atlas out.
void SurfaceAtlas::State::refuse_if_too_large(const Scene& scene) const {
  const MemoryAccount& account = device.memory();
  const double wanted = std::min(wanted_sides(reflecting_area(scene), options), 1e14);
  const size_t bytes = estimate_bytes(scene, options, static_cast<size_t>(wanted));
  const size_t least = bytes / 5 * 4;  // the estimate is good to a fifth
  if (least <= account.total_bytes() - std::min(account.used_bytes(), account.total_bytes())) return;
  throw_error(ErrorClass::device, "surface atlas: about {} are needed, but {} of {} are in use; {}",
              format_bytes(bytes), format_bytes(account.used_bytes()), format_bytes(account.total_bytes()),
              options.remedy);
}

void SurfaceAtlas::State::build(const Scene& scene) {
  const Stopwatch watch;
  place = {}, shade = {};
  triangles = {}, table = {}, links = {}, texels = {}, points = {}, materials = {}, ranges = {}, pieces = {},
  samples = {};
  two_sided = two_sided_instances(scene);
  refuse_if_too_large(scene);
  AtlasLayout layout = make_atlas_layout(read_atlas_geometry(scene, buffers, options.use_texcoord1), options);
  report = {};
  measure_texels(layout, report);
  info = layout.info;
  charts = std::move(layout.charts);
  left_out = std::move(layout.left_out);
  upload(layout);
  ++generation;
  record();
  run(place);
  run(shade);
  scheduler.finish();
  report.bytes = triangles.bytes() + table.bytes() + links.bytes() + texels.bytes() + points.bytes() +
                 materials.bytes() + ranges.bytes() + pieces.bytes() + (options.samples > 0 ? samples.bytes() : 0);
  report.seconds = watch.seconds();
  if (options.progress) options.progress(1, "done");
}

bool SurfaceAtlas::State::misses_area() const {
  if (left_out.empty()) return false;
  WorldGeometry world;
  world.read_all(buffers);
  double area = 0;
  for (const uint32_t t : left_out) {
    const auto position = [&](uint32_t v) { return glm::dvec3(world.vertices[v].position.xyz()); };
    const glm::dvec3 a = position(world.triangles[t].v0);
    const double twice =
        glm::length(glm::cross(position(world.triangles[t].v1) - a, position(world.triangles[t].v2) - a));
    if (std::isfinite(twice)) area += 0.5 * twice;
  }
  const double edge = static_cast<double>(info.texel_edge);
  return area > kMissedArea * edge * edge;
}

void SurfaceAtlas::State::upload(const AtlasLayout& layout) {
  const auto store = [&](auto& buffer, const char* name, const auto& values) {
    buffer = std::remove_reference_t<decltype(buffer)>(device, owner, name, values, options.remedy);
  };
  store(triangles, "atlas triangles", layout.triangles);
  store(table, "atlas table", layout.table);
  store(links, "atlas links", layout.links);
  store(texels, "atlas texels", layout.texels);
  store(ranges, "atlas ranges", layout.ranges);
  store(pieces, "atlas pieces", layout.pieces);
  if (options.samples > 0) store(samples, "atlas samples", layout.samples);
  points = TypedBuffer<SurfacePoint>(device, owner, "atlas points", info.texel_count, options.remedy);
  materials = TypedBuffer<AtlasMaterial>(device, owner, "atlas materials", info.texel_count, options.remedy);
}

void SurfaceAtlas::State::record() {
  const size_t sides = std::max<size_t>(1, info.texel_count);
  ScheduleRecorder placing = scheduler.record("place atlas texel sides", owner);
  PassBuilder place_pass = placing.pass("place atlas texel sides", program, "place_atlas_sides");
  buffers.bind(place_pass);
  bind(place_pass);
  place_pass.global(sides);
  place = placing.compile();
  ScheduleRecorder shading = scheduler.record("shade atlas texel sides", owner);
  PassBuilder shade_pass = shading.pass("shade atlas texel sides", program, "shade_atlas_sides");
  buffers.bind(shade_pass);
  bind(shade_pass);
  shade_pass.global(sides);
  shade = shading.compile();
  scene_generation = buffers.generation();
}

void SurfaceAtlas::State::bind(PassBuilder& pass) const {
  pass.arg_if_present("atlas_info", info)
      .arg_if_present("atlas_triangles", triangles)
      .arg_if_present("atlas_table", table)
      .arg_if_present("atlas_links", links)
      .arg_if_present("atlas_texels", texels)
      .arg_if_present("atlas_points", points)
      .arg_if_present("atlas_materials", materials)
      .arg_if_present("atlas_ranges", ranges)
      .arg_if_present("atlas_pieces", pieces)
      .arg_if_present("atlas_samples", samples);
}

SurfaceAtlas::SurfaceAtlas(Device& device, KernelScheduler& scheduler, const Scene& scene, const SceneBuffers& buffers,
                           const SurfaceAtlasOptions& options, const std::string& owner)
    : state_(std::make_unique<State>(device, scheduler, buffers, options, owner)) {
  state_->build(scene);
}

SurfaceAtlas::~SurfaceAtlas() = default;

void SurfaceAtlas::refit(const Scene& scene, const SceneChange& change) {
  State& s = *state_;
  if (change.topology || two_sided_instances(scene) != s.two_sided) return s.build(scene);
  if (change.geometry() && s.misses_area()) return s.build(scene);
  if (!change.geometry() && change.materials.empty()) return;
  if (s.scene_generation != s.buffers.generation()) s.record();
  if (change.geometry()) s.run(s.place);
  s.run(s.shade);
}

void SurfaceAtlas::resolve(const TypedBuffer<GBufferPoint>& points, Film& film) const {
  State& s = *state_;
  const uint32_t count = static_cast<uint32_t>(points.count());
  if (count != film.pixel_count()) throw Error(ErrorClass::internal, "the film has another size than the G-buffer");
  const TypedBuffer<float4> colors(s.device, s.owner, "atlas layer", count);
  ScheduleRecorder recorder = s.scheduler.record("draw atlas layer", s.owner);
  PassBuilder pass = recorder.pass("draw atlas layer", s.program, "draw_atlas_layer");
  s.bind(pass);
  pass.global(count).arg("points", points).arg("count", count).arg("colors", colors);
  Schedule schedule = recorder.compile();
  s.run(schedule);
  s.scheduler.finish();
  FilmLayer& layer = film.layer("atlas");
  layer.pixels.clear();
  for (const float4& color : colors.download()) layer.pixels.insert(layer.pixels.end(), {color.x, color.y, color.z});
}

std::vector<float4> SurfaceAtlas::side_colors() const {
  State& s = *state_;
  if (s.info.texel_count == 0) return {};
  const TypedBuffer<float4> colors(s.device, s.owner, "atlas colors", s.info.texel_count, s.options.remedy);
  ScheduleRecorder recorder = s.scheduler.record("color atlas texel sides", s.owner);
  recorder.pass("color atlas texel sides", s.program, "color_atlas_sides")
      .global(s.info.texel_count)
      .arg("count", s.info.texel_count)
      .arg("colors", colors);
  Schedule schedule = recorder.compile();
  s.run(schedule);
  s.scheduler.finish();
  return colors.download();
}

double SurfaceAtlas::estimate_edge(const Scene& scene, const AtlasLayoutOptions& options) {
  if (options.texel_edge > 0) return options.texel_edge;
  const double area = reflecting_area(scene);
  return std::sqrt(area / wanted_sides(area, options));
}

size_t SurfaceAtlas::estimate_sides(const Scene& scene, const AtlasLayoutOptions& options) {
  return static_cast<size_t>(std::min(count_sides(scene, options), 1e14));
}

size_t SurfaceAtlas::expected_sides(const Scene& scene, const AtlasLayoutOptions& options) {
  return static_cast<size_t>(std::min(count_sides(scene, options, false), 1e14));
}

double SurfaceAtlas::side_area(const Scene& scene) { return reflecting_area(scene); }

size_t SurfaceAtlas::estimate_bytes(const Scene& scene, const AtlasLayoutOptions& options, size_t sides) {
  // Cells are about twice the texels with their rings; pieces one and a half times the texels and two per triangle.
  const size_t triangles = static_cast<size_t>(scene.triangle_count());
  const size_t per_side = sizeof(AtlasTexel) + sizeof(SurfacePoint) + sizeof(AtlasMaterial) + sizeof(uint2) +
                          options.samples * sizeof(AtlasSample);
  return sides * (per_side + 2 * (sizeof(uint32_t) + 1) + 3 * sizeof(TexelPiece) / 2) +
         triangles * (sizeof(AtlasTriangle) + 2 * sizeof(TexelPiece));
}

void SurfaceAtlas::warm_up() {
  state_->scheduler.warm_up(state_->place);
  state_->scheduler.warm_up(state_->shade);
}

void SurfaceAtlas::bind(PassBuilder& pass) const { state_->bind(pass); }

uint64_t SurfaceAtlas::generation() const { return state_->generation; }
const AtlasInfo& SurfaceAtlas::info() const { return state_->info; }
const SurfaceAtlasReport& SurfaceAtlas::report() const { return state_->report; }
const TypedBuffer<AtlasTriangle>& SurfaceAtlas::triangles() const { return state_->triangles; }
const TypedBuffer<uint32_t>& SurfaceAtlas::table() const { return state_->table; }
const TypedBuffer<uint8_t>& SurfaceAtlas::links() const { return state_->links; }
const TypedBuffer<AtlasTexel>& SurfaceAtlas::texels() const { return state_->texels; }
const TypedBuffer<SurfacePoint>& SurfaceAtlas::surface_points() const { return state_->points; }
const TypedBuffer<AtlasMaterial>& SurfaceAtlas::materials() const { return state_->materials; }
const TypedBuffer<uint2>& SurfaceAtlas::ranges() const { return state_->ranges; }
const TypedBuffer<TexelPiece>& SurfaceAtlas::pieces() const { return state_->pieces; }
const TypedBuffer<AtlasSample>& SurfaceAtlas::samples() const { return state_->samples; }
const std::vector<AtlasChart>& SurfaceAtlas::charts() const { return state_->charts; }

}  // namespace lucarium
