// SPDX-License-Identifier: Apache-2.0
#include "lucarium/services/texel_sides/kept_rows.h"

#include <algorithm>

#include "lucarium/compute/program/source_library.h"
#include "lucarium/services/dealt_rows/dealt_rows.h"
#include "lucarium/shared/scene_types.h"

namespace lucarium {
namespace {

constexpr uint32_t kSliceRows = 64;  // of tiles, between two checks for an interrupt

uint32_t divide_up(uint32_t a, uint32_t b) { return (a + b - 1) / b; }

}  // namespace

KeptRows::KeptRows(Device& device, KernelScheduler& scheduler, const LayeredRaster& raster, const SurfaceAtlas& atlas,
                   const TexelInterior& interior, const SideAccessibility& accessibility,
                   const TypedBuffer<LayeredView>& view, const Options& options)
    : scheduler_(&scheduler),
      rows_(divide_up(options.height, LAYERED_TILE_ROWS)),
      words_(device, options.owner, "kept fragments",
             std::min<size_t>(options.bytes / sizeof(uint32_t), LUCARIUM_NONE - 1u), options.remedy),
      starts_(device, options.owner, "rows of kept fragments", size_t{options.views} * (rows_ + 1), options.remedy),
      counts_(device, options.owner, "words of rows", rows_),
      taken_(device, options.owner, "words that are taken", 1) {
  const Program program(
      device, SourceLibrary(),
      {"services/texel_sides/keep_rows", {"lucarium/services/texel_sides/keep_rows.cl"}, raster.defines()});
  starts_.upload(std::vector<uint32_t>(starts_.count(), LUCARIUM_NONE));
  ScheduleRecorder recorder = scheduler.record("keep fragments", options.owner);
  number_ = recorder.variable("number", 0u);
  const LayeredRaster::ViewRef ref{view, recorder.variable("view index", 0u)};
  const auto bins = raster.record_bins(recorder, "bins", ref);
  const SideHalves halves = accessibility.side_halves();
  const auto bind = [&](PassBuilder& pass) -> PassBuilder& {
    atlas.bind(pass);
    return pass.arg("accessibility", accessibility.parts())
        .arg("interior", interior.shares())
        .arg("covered", halves.two() ? halves.covered : accessibility.parts())
        .arg("two_halves", halves.two() ? 1u : 0u)
        .arg("rows", rows_)
        .arg("view", number_)
        .arg("starts", starts_)
        .arg("counts", counts_)
        .arg("words", words_);
  };
  raster.record_tiles(recorder, "count", ref, *bins, program, "keep_rows",
                      [&](PassBuilder& pass) { bind(pass).arg("writes", 0u); });
  recorder.pass("place", program, "place_kept_rows")
      .global(1)
      .local(1)
      .arg("rows", rows_)
      .arg("view", number_)
      .arg("capacity", static_cast<uint32_t>(words_.count()))
      .arg("counts", counts_)
      .arg("taken", taken_)
      .arg("starts", starts_);
  raster.record_tiles(recorder, "keep", ref, *bins, program, "keep_rows",
                      [&](PassBuilder& pass) { bind(pass).arg("writes", 1u); });
  keep_ = recorder.compile();
}

void KeptRows::keep(uint32_t number) {
  keep_.set(number_, number);
  scheduler_->run_to_end(keep_);  // half a view would take its place twice
}

void KeptRows::finish() {
  scheduler_->finish();
  const std::vector<uint32_t> starts = starts_.download();
  kept_.resize(starts.size() / (rows_ + 1));
  for (size_t view = 0; view < kept_.size(); ++view) kept_[view] = starts[view * (rows_ + 1)] != LUCARIUM_NONE;
}

uint32_t KeptRows::kept_views() const { return static_cast<uint32_t>(std::count(kept_.begin(), kept_.end(), 1)); }

size_t KeptRows::used_bytes() const { return sizeof(uint32_t) * taken_.download().front(); }

void KeptRows::record_walk(ScheduleRecorder& recorder, const std::string& name, const Variable<uint32_t>& number,
                           const Program& program, std::string_view kernel,
                           const std::function<void(PassBuilder&)>& bind) const {
  for (uint32_t parity = 0; parity < std::min(2u, rows_); ++parity) {
    PassBuilder pass = recorder.pass(name + (parity ? ".odd_rows" : ".even_rows"), program, kernel);
    deal_rows(pass, divide_up(rows_ - parity, 2), scheduler_->device());
    pass.slice(kSliceRows)
        .arg("kept_words", words_)
        .arg("kept_starts", starts_)
        .arg("kept_rows", rows_)
        .arg("kept_view", number)
        .arg("layered_parity", parity);
    bind(pass);
  }
}

void KeptRows::warm_up() { scheduler_->warm_up(keep_); }

}  // namespace lucarium
