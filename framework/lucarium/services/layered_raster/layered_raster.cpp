// SPDX-License-Identifier: Apache-2.0
#include "lucarium/services/layered_raster/layered_raster.h"

#include <algorithm>
#include <bit>
#include <limits>
#include <span>

#include "lucarium/base/error.h"
#include "lucarium/compute/program/source_library.h"
#include "lucarium/scene/device/degenerate_triangle.h"
#include "lucarium/services/dealt_rows/dealt_rows.h"
#include "lucarium/services/layered_raster/state.h"

namespace lucarium {

namespace {

constexpr uint32_t lanes = 16;                 // pixels per row of a tile
constexpr uint32_t chunks = 16;                // runs of triangles binned in parallel
constexpr uint32_t slice_pixels = 1u << 22;    // of the image between two checks for an interrupt
constexpr uint32_t row_layers_elsewhere = 16;  // on devices that are no processors
constexpr const char* fewer_triangles = "use a scene with fewer triangles";

uint32_t divide_up(uint32_t a, uint32_t b) { return (a + b - 1) / b; }

/// Takes the triangles of `lanes_to_test` (bits) that have no area out of their block. True if there are any.
bool leave_out_of_block(std::span<float> block, uint32_t lanes_to_test) {
  bool any = false;
  for (uint32_t lane = 0; lane < 16; ++lane) {
    if (!(lanes_to_test >> lane & 1u)) continue;
    const auto corner = [&](uint32_t k) {
      return glm::vec3(block[3 * k * 16 + lane], block[(3 * k + 1) * 16 + lane], block[(3 * k + 2) * 16 + lane]);
    };
    if (!is_degenerate(corner(0), corner(1), corner(2))) continue;
    for (uint32_t word = 0; word < 9; ++word) block[word * 16 + lane] = std::numeric_limits<float>::quiet_NaN();
    block[9 * 16 + lane] = 0;
    any = true;
  }
  return any;
}

}  // namespace

LayeredRaster::State::State(KernelScheduler& scheduler_, const SceneBuffers& scene_,
                            const LayeredRasterOptions& options_, const std::string& owner_)
    : scheduler(scheduler_), scene(scene_), options(options_), owner(owner_), primitives(scheduler_.device()) {
  if (options.max_width == 0 || options.max_height == 0 || options.max_width > LAYERED_MAX_EDGE ||
      options.max_height > LAYERED_MAX_EDGE)
    throw_error(ErrorClass::usage, "layered raster: {} x {} pixels, each side must be 1 to {}", options.max_width,
                options.max_height, LAYERED_MAX_EDGE);
  if (options.row_layers == 0)
    options.row_layers = scheduler.device().info().type == DeviceType::cpu ? LAYERED_MAX_LAYERS : row_layers_elsewhere;
  if (options.row_layers < 4 || options.row_layers > LAYERED_MAX_LAYERS || !std::has_single_bit(options.row_layers))
    throw_error(ErrorClass::usage, "layered raster: {} layers in a row, must be 4, 8, 16, 32 or 64",
                options.row_layers);
  follow();
}

std::map<std::string, std::string> LayeredRaster::State::defines() const {
  std::map<std::string, std::string> result = {{"LAYERED_LANES", std::to_string(lanes)},
                                               {"LAYERED_CHUNKS", std::to_string(chunks) + "u"},
                                               {"LAYERED_MAX_LAYERS", std::to_string(options.row_layers) + "u"}};
  if (options.perspective) result["LAYERED_PERSPECTIVE"] = "";
  if (options.conservative) result["LAYERED_CONSERVATIVE"] = "";
  if (options.portable) result["LAYERED_PORTABLE"] = "";
  if (options.classes) result["LAYERED_CLASSES"] = "";
  if (alpha) result["LAYERED_ALPHA"] = "";
  return result;
}

void LayeredRaster::State::follow() {
  const uint32_t count = scene.info().triangle_count;
  const bool has_alpha = !options.keep_alpha && (scene.info().flags & LUCARIUM_SCENE_HAS_ALPHA) != 0;
  if (!program || scene.generation() != scene_generation || count != triangles || has_alpha != alpha) {
    if (count >= LAYERED_AWAY / 8)
      throw_error(ErrorClass::device, "layered raster: {} triangles are too many; {}", count, fewer_triangles);
    triangles = count;
    alpha = has_alpha;
    scene_generation = scene.generation();
    ++generation;
    program =
        Program(scheduler.device(), SourceLibrary(),
                {.name = "services/layered_raster",
                 .files = {"lucarium/services/layered_raster/setup.cl", "lucarium/services/layered_raster/bins.cl"},
                 .defines = defines()});
    consumers.clear();
    geometry = {};
    geometry =
        TypedBuffer<float>(scheduler.device(), owner, "de-indexed triangles",
                           size_t{LAYERED_BLOCK_WORDS} * divide_up(std::max(1u, triangles), 16), fewer_triangles);
    boxes = {};
    boxes = TypedBuffer<float4>(scheduler.device(), owner, "boxes of triangles",
                                size_t{2} * divide_up(std::max(1u, triangles), 16), fewer_triangles);
    unsure = {};
    unsure = TypedBuffer<uint32_t>(scheduler.device(), owner, "triangles to test",
                                   divide_up(std::max(1u, triangles), 16), fewer_triangles);
    ScheduleRecorder recorder = scheduler.record("gather triangles", owner);
    PassBuilder pass = recorder.pass("gather triangles", program, "layered_gather_triangles");
    scene.bind(pass);
    pass.global(divide_up(std::max(1u, triangles), 16))
        .local(1)
        .arg("layered_unsure", unsure)
        .arg("layered_boxes", boxes)
        .arg("layered_geometry", geometry);
    gather = recorder.compile();
  }
  scheduler.run_to_end(gather);  // cancelled, it would leave triangles of zeros that nothing would gather again
  leave_out_degenerate();
}

void LayeredRaster::State::leave_out_degenerate() {
  // Only the triangles come to the host that single precision cannot decide: in most scenes there are none.
  const std::vector<uint32_t> bits = unsure.download();
  std::vector<size_t> blocks;
  for (size_t block = 0; block < bits.size(); ++block)
    if (bits[block]) blocks.push_back(block);
  if (blocks.empty()) return;
  // Many blocks: one transfer of all from the first to the last costs less than one for each.
  constexpr size_t max_transfers = 16;
  const size_t first = blocks.front(), last = blocks.back();
  const bool whole = blocks.size() > max_transfers;
  std::vector<float> run;
  if (whole) run = geometry.download(first * LAYERED_BLOCK_WORDS, (last - first + 1) * LAYERED_BLOCK_WORDS);
  bool any = false;
  for (const size_t block : blocks) {
    if (!whole) run = geometry.download(block * LAYERED_BLOCK_WORDS, LAYERED_BLOCK_WORDS);
    const size_t start = whole ? (block - first) * LAYERED_BLOCK_WORDS : 0;
    const bool changed = leave_out_of_block(std::span(run).subspan(start, LAYERED_BLOCK_WORDS), bits[block]);
    if (changed && !whole) geometry.upload(run, block * LAYERED_BLOCK_WORDS);
    any = any || changed;
  }
  if (any && whole) geometry.upload(run, first * LAYERED_BLOCK_WORDS);
}

LayeredBins LayeredRaster::State::record_bins(ScheduleRecorder& recorder, const std::string& name,
                                              const ViewRef& view) const {
  const uint32_t blocks = divide_up(std::max(1u, triangles), 16);
  const uint32_t tiles = divide_up(options.max_width, lanes) * divide_up(options.max_height, LAYERED_TILE_ROWS);
  const uint32_t stride = divide_up(tiles + 1, 16) * 16;
  LayeredBins bins;
  bins.records = recorder.transient<LayeredRecord>(name + ".records", std::max(1u, triangles), fewer_triangles);
  bins.bounds = recorder.transient<uint32_t>(name + ".bounds", 16 * blocks, fewer_triangles);
  const BufferRef clip_counts = recorder.transient<uint32_t>(name + ".clip_counts", blocks);
  bins.clipped = recorder.transient<uint32_t>(name + ".clipped", 1);
  const auto class_pass = [&](const char* what, const char* kernel) {
    PassBuilder pass = recorder.pass(name + what, program, kernel);
    if (options.classes) pass.arg("layered_classes", view.classes);
    return pass;
  };
  const uint32_t block_runs = divide_up(blocks, LAYERED_BLOCKS_EACH);
  class_pass(".set_up", "layered_set_up")
      .global(block_runs)
      .local(1)
      .arg("layered_views", view.views)
      .arg("layered_view", view.index)
      .arg("layered_geometry", geometry)
      .arg("layered_boxes", boxes)
      .arg("triangles", triangles)
      .arg("layered_records", bins.records)
      .arg("layered_bounds", bins.bounds)
      .arg("layered_clip_counts", clip_counts)
      .discards("layered_records")
      .discards("layered_bounds")
      .discards("layered_clip_counts");
  primitives.record_exclusive_scan(recorder, name + ".clip_scan", clip_counts, clip_counts, bins.clipped, blocks);
  bins.extra = recorder.transient_sized_by<LayeredRecord>(name + ".clip_records", bins.clipped, 0, LAYERED_CLIP_PARTS,
                                                          options.remedy);
  bins.clips =
      recorder.transient_sized_by<LayeredClip>(name + ".clips", bins.clipped, 0, LAYERED_CLIP_PARTS, options.remedy);
  bins.extra_bounds =
      recorder.transient_sized_by<uint32_t>(name + ".clip_bounds", bins.clipped, 0, LAYERED_CLIP_PARTS, options.remedy);
  class_pass(".clip", "layered_clip_triangles")
      .global(block_runs)
      .local(1)
      .arg("layered_views", view.views)
      .arg("layered_view", view.index)
      .arg("layered_geometry", geometry)
      .arg("triangles", triangles)
      .arg("layered_clip_counts", clip_counts)
      .arg("layered_clipped", bins.clipped)
      .arg("layered_extra", bins.extra)
      .arg("layered_clips", bins.clips)
      .arg("layered_extra_bounds", bins.extra_bounds)
      .discards("layered_extra")
      .discards("layered_clips")
      .discards("layered_extra_bounds");
  const BufferRef histogram =
      recorder.transient<uint32_t>(name + ".histogram", size_t{chunks} * stride, options.remedy);
  bins.starts = recorder.transient<uint32_t>(name + ".starts", stride);
  const BufferRef pair_count = recorder.transient<uint32_t>(name + ".pair_count", 1);
  recorder.pass(name + ".count_bins", program, "layered_count_bins")
      .global(chunks)
      .local(1)
      .arg("layered_bounds", bins.bounds)
      .arg("layered_extra_bounds", bins.extra_bounds)
      .arg("layered_clipped", bins.clipped)
      .arg("triangles", triangles)
      .arg("layered_views", view.views)
      .arg("layered_view", view.index)
      .arg("stride", stride)
      .arg("layered_histogram", histogram)
      .discards("layered_histogram");
  recorder.pass(name + ".sum_bins", program, "layered_sum_bins")
      .global(stride / 16)
      .local(1)
      .arg("layered_histogram", histogram)
      .arg("stride", stride)
      .arg("layered_starts", bins.starts)
      .discards("layered_starts");
  primitives.record_exclusive_scan(recorder, name + ".scan_bins", bins.starts, bins.starts, pair_count, stride);
  bins.pairs = recorder.transient_sized_by<uint32_t>(name + ".pairs", pair_count, 0, 1, options.remedy);
  recorder.pass(name + ".fill_bins", program, "layered_fill_bins")
      .global(chunks)
      .local(1)
      .arg("layered_bounds", bins.bounds)
      .arg("layered_extra_bounds", bins.extra_bounds)
      .arg("layered_clipped", bins.clipped)
      .arg("triangles", triangles)
      .arg("layered_views", view.views)
      .arg("layered_view", view.index)
      .arg("stride", stride)
      .arg("layered_histogram", histogram)
      .arg("layered_starts", bins.starts)
      .arg("layered_pairs", bins.pairs)
      .discards("layered_pairs");
  return bins;
}

void LayeredRaster::State::record_tiles(ScheduleRecorder& recorder, const std::string& name, const ViewRef& view,
                                        const LayeredBins& bins, const Program& consumer, std::string_view kernel,
                                        const std::function<void(PassBuilder&)>& bind) const {
  const uint32_t rows = divide_up(options.max_height, LAYERED_TILE_ROWS);
  for (uint32_t parity = 0; parity < std::min(2u, rows); ++parity)
    record_rows(recorder, name + (parity ? ".odd_rows" : ".even_rows"), view, bins, consumer, kernel, parity,
                divide_up(rows - parity, 2), bind);
}

void LayeredRaster::State::record_each_tile(ScheduleRecorder& recorder, const std::string& name, const ViewRef& view,
                                            const LayeredBins& bins, const Program& consumer, std::string_view kernel,
                                            const std::function<void(PassBuilder&)>& bind) const {
  const uint32_t tiles = divide_up(options.max_width, lanes) * divide_up(options.max_height, LAYERED_TILE_ROWS);
  PassBuilder pass = recorder.pass(name, consumer, kernel);
  pass.global(tiles).local(1).slice(slice_pixels / (lanes * LAYERED_TILE_ROWS));
  bind_tiles(pass, view, bins, 0);
  bind(pass);
}

void LayeredRaster::State::record_rows(ScheduleRecorder& recorder, const std::string& name, const ViewRef& view,
                                       const LayeredBins& bins, const Program& consumer, std::string_view kernel,
                                       uint32_t parity, uint32_t rows,
                                       const std::function<void(PassBuilder&)>& bind) const {
  PassBuilder pass = recorder.pass(name, consumer, kernel);
  pass.global(rows).local(1).slice(std::max(1u, slice_pixels / (options.max_width * LAYERED_TILE_ROWS)));
  bind_tiles(pass, view, bins, parity);
  bind(pass);
}

void LayeredRaster::State::bind_tiles(PassBuilder& pass, const ViewRef& view, const LayeredBins& bins,
                                      uint32_t parity) const {
  if (alpha) scene.bind(pass);
  pass.arg("layered_views", view.views)
      .arg("layered_view", view.index)
      .arg("layered_records", bins.records)
      .arg("layered_extra", bins.extra)
      .arg("layered_clips", bins.clips)
      .arg("layered_triangles", triangles)
      .arg("layered_starts", bins.starts)
      .arg("layered_pairs", bins.pairs)
      .arg("layered_parity", parity)
      .arg("dealt_columns", dealt_columns(scheduler.device()));
}

LayeredRaster::LayeredRaster(KernelScheduler& scheduler, const SceneBuffers& scene, const LayeredRasterOptions& options,
                             const std::string& owner)
    : state_(std::make_unique<State>(scheduler, scene, options, owner)) {}
LayeredRaster::~LayeredRaster() = default;

size_t LayeredRaster::estimate_bytes(size_t triangles, const LayeredRasterOptions& options,
                                     const std::optional<LayeredStoreOptions>& stored, size_t schedules) {
  constexpr size_t layers = 4;
  const size_t blocks = (std::max<size_t>(1, triangles) + 15) / 16,
               pixels = size_t{options.max_width} * options.max_height;
  const size_t tiles = size_t{divide_up(options.max_width, lanes)} * divide_up(options.max_height, LAYERED_TILE_ROWS);
  const size_t geometry = blocks * (LAYERED_BLOCK_WORDS + 1 + 8) * sizeof(uint32_t),
               records = blocks * ((16 + 1) * sizeof(uint32_t) + 16 * sizeof(LayeredRecord));
  const size_t pairs = 2 * triangles + layers * tiles;  // a triangle lies in a tile, or in all that it covers
  const size_t bins = (size_t{chunks} + 1) * (tiles + 16) + pairs;
  size_t per_pixel = 0;
  if (stored) per_pixel = sizeof(uint32_t) + layers * sizeof(LayeredFragment);
  if (stored && stored->variant == LayeredVariant::exact) per_pixel += sizeof(uint32_t);  // places
  if (stored && stored->variant == LayeredVariant::linked_list)                           // heads twice, and nodes
    per_pixel += 2 * sizeof(uint32_t) + stored->list_capacity * (sizeof(uint32_t) + sizeof(LayeredFragment));
  return geometry + schedules * (records + bins * sizeof(uint32_t) + pixels * per_pixel);
}

void LayeredRaster::update() { state_->follow(); }
uint64_t LayeredRaster::generation() const { return state_->generation; }
std::map<std::string, std::string> LayeredRaster::defines() const { return state_->defines(); }

void LayeredRaster::record_tiles(ScheduleRecorder& recorder, const std::string& name, const ViewRef& view,
                                 const Program& program, std::string_view kernel,
                                 const std::function<void(PassBuilder&)>& bind) const {
  state_->record_tiles(recorder, name, view, state_->record_bins(recorder, name, view), program, kernel, bind);
}

std::shared_ptr<const LayeredBins> LayeredRaster::record_bins(ScheduleRecorder& recorder, const std::string& name,
                                                              const ViewRef& view) const {
  return std::make_shared<LayeredBins>(state_->record_bins(recorder, name, view));
}

void LayeredRaster::record_tiles(ScheduleRecorder& recorder, const std::string& name, const ViewRef& view,
                                 const LayeredBins& bins, const Program& program, std::string_view kernel,
                                 const std::function<void(PassBuilder&)>& bind) const {
  state_->record_tiles(recorder, name, view, bins, program, kernel, bind);
}

}  // namespace lucarium
