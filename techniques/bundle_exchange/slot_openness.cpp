// SPDX-License-Identifier: Apache-2.0
#include "slot_openness.h"

#include <algorithm>
#include <cmath>

#include "bundle_program.h"
#include "bundle_view.h"
#include "lucarium/base/error.h"
#include "lucarium/services/layered_raster.h"
#include "texel_extent.h"

namespace lucarium::bundle {
namespace {

constexpr size_t kLocalSize = 64;
constexpr uint32_t kParts = 64, kPartWords = 4;  // SLOT_PARTS, SLOT_PART_WORDS
constexpr uint32_t kMostCells = 1u << 26;        // BUNDLE_PART of bundle_rows.clh
constexpr double kRaysPerTexel = 256;  // if it faced all directions: about two per part, of few of which the mean is right too
constexpr uint64_t kSeed = 0x6f70656e;  // not that of a run, whose directions then are others
const char* const kOwner = "bundle_exchange";
const char* const kFewerTexels = "lower texels";

}  // namespace

SlotOpenness::SlotOpenness(Device& device, KernelScheduler& scheduler, const Program& program, const Scene& scene,
                           const SceneBuffers& buffers, const SurfaceAtlas& atlas, const SlotExposure& exposure,
                           const Options& options)
    : shares_(device, kOwner, "openness of slots", atlas.info().texel_count, kFewerTexels),
      parts_(device, kOwner, "openness of slots' parts", size_t{atlas.info().texel_count} * kPartWords, kFewerTexels),
      points_(device, kOwner, "openness of slots' points", atlas.info().texel_count, kFewerTexels) {
  const uint32_t slots = atlas.info().texel_count;
  if (atlas.info().cell_count > kMostCells)
    throw_error(ErrorClass::usage, "bundle_exchange: the atlas has {} cells, more than {}: lower texels", atlas.info().cell_count, kMostCells);
  const Bounds bounds = scene.bounds();
  const double texel = static_cast<double>(atlas.info().texel_edge), wanted = options.pixel_size * texel;
  // Work-items that count for the same texel at a time would lose rays of it.
  const double pixel = safe_pixel_ = std::max(wanted, largest_texel_extent(atlas, buffers, wanted * LAYERED_TILE_ROWS) / LAYERED_TILE_ROWS);
  LayeredRasterOptions films;
  films.max_width = films.max_height = film_side(bounds, pixel);
  const LayeredRaster raster(scheduler, buffers, films, kOwner);
  const TypedBuffer<LayeredView> views(device, kOwner, "view of a probe", 1);
  TypedBuffer<uint32_t> counts(device, kOwner, "probes of slots", size_t{slots} * kParts, kFewerTexels);
  counts.fill_zero();

  ScheduleRecorder recorder = scheduler.record("openness", kOwner);
  const Variable<LayeredView> view = recorder.variable("view", LayeredView{});
  const Program begin = make_bundle_program(device, "begin_direction", {}), probe = make_bundle_program(device, "probe_rows", raster.defines());
  const BufferRef ends = recorder.transient<float4>("ends of rays", 2);
  PassBuilder pass = recorder.pass("begin probe", begin, "begin_direction");
  buffers.bind(pass, begin, "begin_direction");
  pass.global(1).local(1).arg("view", view).arg("omega", float4(0, 0, 1, 0)).arg("emission", 0u).arg("views", views).arg("ends", ends);
  raster.record_tiles(recorder, "probe", {views, recorder.variable("view index", 0u)}, probe, "probe_rows", [&](PassBuilder& rows) {
    atlas.bind(rows, probe, "probe_rows");
    rows.arg("open_gap", static_cast<float>(options.open_gap * texel)).arg("counts", counts);
  });
  Schedule draw = recorder.compile();

  const int directions = static_cast<int>(std::clamp(std::ceil(kRaysPerTexel * options.pixel_size * options.pixel_size), 32.0, 1024.0));
  const DirectionSequence sequence(Parameters{}, kSeed, nullptr);
  for (int i = 0; i < directions; ++i) {
    draw.set(view, make_bundle_view(bounds, sequence.at(static_cast<uint64_t>(i)), pixel, static_cast<uint32_t>(i + 1)).view);
    if (scheduler.run(draw) == RunResult::cancelled)
      throw Error(ErrorClass::interrupted, "bundle_exchange: stopped while it looked how open surfaces are");
  }

  ScheduleRecorder finish = scheduler.record("openness of parts", kOwner);
  PassBuilder finish_pass = finish.pass("finish openness", program, "finish_openness");
  atlas.bind(finish_pass, program, "finish_openness");
  finish_pass.global(slots).local(kLocalSize).arg("slots", slots).arg("counts", counts);
  finish_pass.arg("exposure", exposure.shares()).arg("hidden", exposure.hidden());
  finish_pass.arg("share", shares_).arg("openness", parts_).arg("points", points_);
  Schedule sum = finish.compile();
  scheduler.run_to_end(sum);
  scheduler.finish();
}

size_t SlotOpenness::estimate_bytes(size_t slots) {
  return slots * (sizeof(float) + (1 + kPartWords) * sizeof(uint32_t) + kParts * sizeof(uint32_t));
}

}  // namespace lucarium::bundle
