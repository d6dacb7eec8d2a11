// SPDX-License-Identifier: Apache-2.0
#include "lucarium/services/texel_sides/side_accessibility.h"

#include <algorithm>
#include <cmath>

#include "lucarium/base/error.h"
#include "lucarium/compute/program/source_library.h"
#include "lucarium/services/bundles/bundle_view.h"
#include "lucarium/services/layered_raster/layered_raster.h"
#include "lucarium/services/texel_sides/texel_extent.h"
#include "lucarium/shared/texel_sides.h"

namespace lucarium {
namespace {

constexpr uint32_t kMaxCells = 1u << BUNDLE_PART;
constexpr double kMinBundles = 32, kMaxBundles = 1024;
// Of light below glass, with automatic_gap(), in texel edges: farther off its edge is blurred, and covered parts take
// rays from open ones.
constexpr float kGlassGap = 2;
constexpr uint64_t kSeed = 0x6f70656e;  // not that of a run, whose directions then are others

Program make_program(Device& device, const std::string& kernel, std::map<std::string, std::string> defines) {
  return Program(
      device, SourceLibrary(),
      {"services/texel_sides/" + kernel, {"lucarium/services/texel_sides/" + kernel + ".cl"}, std::move(defines)});
}

}  // namespace

/// The bundles that measure the accessibility of parts, and their counts so far.
struct SideAccessibility::Probes {
  KernelScheduler* scheduler = nullptr;
  Bounds bounds;
  double pixel = 0;
  uint64_t count = 0;  ///< bundles
  bool only_hidden = false;
  TypedBuffer<uint32_t> hidden, counts, glass;
  TypedBuffer<LayeredView> views;
  TypedBuffer<float4> ends;
  DirectionSequence sequence{{}, kSeed};
  Schedule begin, draw, sum;
  Variable<LayeredView> view;
};

SideAccessibility::SideAccessibility(Device& device, const SceneBuffers& buffers, const SurfaceAtlas& atlas,
                                     const Options& options, const std::string& owner, const std::string& remedy)
    : options_(options),
      owner_(owner),
      remedy_(remedy),
      sides_(atlas.info().texel_count),
      halves_(options.access_gap != 0 ? options.halves : 1),
      shares_(device, owner_, "accessibility of texel sides", size_t{halves_} * sides_, remedy_),
      parts_(device, owner_, "accessibility of texel sides' parts", size_t{sides_} * SIDE_PART_WORDS, remedy_),
      covered_(device, owner_, "covered parts of texel sides",
               halves_ > 1 ? size_t{sides_} * SIDE_COVER_WORDS : SIDE_COVER_WORDS, remedy_),
      points_(device, owner_, "accessibility of texel sides' points", sides_, remedy_) {
  if (atlas.info().cell_count > kMaxCells)
    throw_error(ErrorClass::usage, "{}: the atlas has {} cells, more than {}: {}", owner, atlas.info().cell_count,
                kMaxCells, remedy);
  const double wanted = options.pixel_size * static_cast<double>(atlas.info().texel_edge);
  // Work-items that count for the same texel at a time would lose rays of it.
  safe_pixel_ = std::max(wanted, largest_texel_extent(atlas, buffers, wanted * LAYERED_TILE_ROWS) / LAYERED_TILE_ROWS);
}

SideAccessibility::~SideAccessibility() = default;

double SideAccessibility::bundles(float pixel_size, int rays) {
  return std::clamp(std::ceil(double{pixel_size} * pixel_size * rays), kMinBundles, kMaxBundles);
}

float SideAccessibility::automatic_gap(double diameter, float texel_edge) {
  return static_cast<float>(std::clamp(0.1 * diameter / std::max(double{texel_edge}, 1e-30), 2.0, 8.0));
}

void SideAccessibility::begin(Device& device, KernelScheduler& scheduler, const Scene& scene,
                              const SceneBuffers& buffers, const SurfaceAtlas& atlas, const TexelInterior& interior,
                              const LayeredRaster& raster) {
  const uint32_t sides = atlas.info().texel_count;
  probes_ = std::make_unique<Probes>();
  Probes& probes = *probes_;
  probes.scheduler = &scheduler;
  probes.bounds = scene.bounds();
  probes.pixel = safe_pixel_;
  // About two rays per part by default: of few, the mean is right too.
  probes.count = static_cast<uint64_t>(bundles(options_.pixel_size, options_.rays));
  probes.only_hidden = options_.access_gap == 0;
  probes.hidden = interior.hidden();
  probes.counts = TypedBuffer<uint32_t>(device, owner_, "probes of texel sides", size_t{sides} * SIDE_PARTS, remedy_);
  probes.counts.fill_zero();
  std::map<std::string, std::string> defines;
  if (halves_ > 1) {
    defines["SIDE_HALVES"] = "";
    probes.glass = TypedBuffer<uint32_t>(device, owner_, "probes that meet glass", size_t{sides} * SIDE_PARTS, remedy_);
    probes.glass.fill_zero();
  }
  probes.views = TypedBuffer<LayeredView>(device, owner_, "view of a probe", 1);
  probes.ends = TypedBuffer<float4>(device, owner_, "ends of rays", 2);

  const float gap = options_.access_gap < 0
                        ? automatic_gap(2.0 * static_cast<double>(probes.bounds.radius()), atlas.info().texel_edge)
                        : options_.access_gap;
  const float glass_gap = options_.access_gap < 0 ? kGlassGap : gap;

  ScheduleRecorder begin = scheduler.record("begin accessibility", owner_);
  probes.view = begin.variable("view", LayeredView{});
  const Program begin_program = make_program(device, "begin_direction", {});
  PassBuilder pass = begin.pass("begin probe", begin_program, "begin_direction");
  buffers.bind(pass);
  pass.global(1).local(1).arg("view", probes.view).arg("omega", float4(0, 0, 1, 0)).arg("emission", 0u);
  pass.arg("views", probes.views).arg("ends", probes.ends);
  probes.begin = begin.compile();

  ScheduleRecorder draw = scheduler.record("accessibility", owner_);
  std::map<std::string, std::string> probe_defines = raster.defines();
  probe_defines.insert(defines.begin(), defines.end());
  const Program probe = make_program(device, "probe_pairs", probe_defines);
  raster.record_tiles(draw, "probe", {probes.views, draw.variable("view index", 0u)}, probe, "probe_pairs",
                      [&](PassBuilder& rows) {
                        atlas.bind(rows);
                        rows.arg("access_gap", gap * atlas.info().texel_edge).arg("counts", probes.counts);
                        if (halves_ > 1)
                          rows.arg("glass", probes.glass).arg("glass_gap", glass_gap * atlas.info().texel_edge);
                      });
  probes.draw = draw.compile();

  ScheduleRecorder sum = scheduler.record("accessibility of parts", owner_);
  PassBuilder finish =
      sum.pass("finish accessibility", make_program(device, "finish_accessibility", defines), "finish_accessibility");
  atlas.bind(finish);
  finish.global(sides).arg("sides", sides).arg("counts", probes.counts);
  finish.arg("interior", interior.shares()).arg("hidden", interior.hidden());
  finish.arg("share", shares_).arg("accessibility", parts_).arg("points", points_);
  if (halves_ > 1) finish.arg("glass", probes.glass).arg("covered", covered_);
  probes.sum = sum.compile();
}

bool SideAccessibility::advance() {
  Probes& probes = *probes_;
  if (drawn_ == 0 && probes.only_hidden) {
    probes.scheduler->finish();
    const std::vector<uint32_t> hidden = probes.hidden.download();
    if (std::none_of(hidden.begin(), hidden.end(), [](uint32_t bits) { return bits != 0; }))
      drawn_ = probes.count;  // all is open
  }
  if (drawn_ < probes.count) {
    const BundleDirection direction = probes.sequence.at(drawn_);
    probes.begin.set(probes.view,
                     make_bundle_view(probes.bounds, direction, probes.pixel, static_cast<uint32_t>(drawn_ + 1)).view);
    if (probes.scheduler->run(probes.begin) == RunResult::cancelled) return false;
    probes.scheduler->run_to_end(probes.draw);  // half a bundle image would be counted twice
    ++drawn_;
  }
  if (drawn_ < probes.count) return true;
  probes.scheduler->run_to_end(probes.sum);
  probes.scheduler->finish();
  complete_ = true;
  probes_.reset();
  return true;
}

double SideAccessibility::progress() const {
  return probes_ ? static_cast<double>(drawn_) / static_cast<double>(probes_->count) : 1.0;
}

size_t SideAccessibility::estimate_bytes(size_t sides, uint32_t halves) {
  return held_bytes(sides, halves) + sides * halves * SIDE_PARTS * sizeof(uint32_t);
}

size_t SideAccessibility::held_bytes(size_t sides, uint32_t halves) {
  return sides *
         (halves * sizeof(float) + (1 + SIDE_PART_WORDS + (halves > 1 ? SIDE_COVER_WORDS : 0)) * sizeof(uint32_t));
}

}  // namespace lucarium
