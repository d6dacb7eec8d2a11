// SPDX-License-Identifier: Apache-2.0
// Consumers of LayeredRaster that write buffers.
#include <algorithm>

#include "lucarium/base/error.h"
#include "lucarium/services/layered_raster_state.h"

namespace lucarium {

namespace {

constexpr const char* smaller_film = "lower the film's resolution";
constexpr uint32_t records_per_item = 64;

}  // namespace

const Program& LayeredRaster::State::consumer(const std::string& file, uint32_t keep) const {
  Program& found = consumers[{file, keep}];
  if (!found) {
    std::map<std::string, std::string> all = defines();
    all["LAYERED_DEPTH"] = "";
    if (keep > 0) all["LAYERED_KEEP"] = std::to_string(keep) + "u";
    found = Program(scheduler.device(), SourceLibrary(),
                    {.name = "services/" + file, .files = {"lucarium/services/" + file + ".cl"}, .defines = all});
  }
  return found;
}

LayeredRaster::Stored LayeredRaster::State::record_tile_store(ScheduleRecorder& recorder, const std::string& name,
                                                              const ViewRef& view, uint32_t keep) const {
  const LayeredBins bins = record_bins(recorder, name, view);
  const Program& store = consumer("layered_raster_store", keep);
  const uint32_t pixels = options.max_width * options.max_height;
  const uint32_t rows = (options.max_height + LAYERED_TILE_ROWS - 1) / LAYERED_TILE_ROWS;
  Stored stored;
  stored.pixel_start = recorder.transient<uint32_t>(name + ".pixel_start", pixels + 1, smaller_film);
  const BufferRef row_dropped = recorder.transient<uint32_t>(name + ".row_dropped", rows);
  recorder.fill_zero(name + ".clear", stored.pixel_start);  // views may be smaller than the largest film
  recorder.fill_zero(name + ".clear_dropped", row_dropped);
  record_tiles(recorder, name + ".count", view, bins, store, "layered_count_fragments", [&](PassBuilder& pass) {
    pass.arg("pixel_counts", stored.pixel_start).arg("dropped", row_dropped);
  });
  stored.dropped = recorder.transient<uint32_t>(name + ".dropped", 1);
  primitives.record_reduce(recorder, name + ".sum_dropped", Primitives::Reduction::sum_uint, row_dropped, stored.dropped, rows);
  const BufferRef total = recorder.transient<uint32_t>(name + ".fragment_count", 1);
  primitives.record_exclusive_scan(recorder, name + ".scan", stored.pixel_start, stored.pixel_start, total, pixels + 1);
  stored.fragments = recorder.transient_sized_by<LayeredFragment>(name + ".fragments", total, 0, 1, smaller_film);
  record_tiles(recorder, name + ".store", view, bins, store, "layered_store_fragments", [&](PassBuilder& pass) {
    pass.arg("pixel_start", stored.pixel_start).arg("fragments", stored.fragments);
  });
  return stored;
}

LayeredRaster::Stored LayeredRaster::State::record_list_store(ScheduleRecorder& recorder, const std::string& name,
                                                              const ViewRef& view,
                                                              const LayeredStoreOptions& chosen) const {
  const LayeredBins bins = record_bins(recorder, name, view);
  const Program& lists = consumer("layered_raster_lists");
  const uint32_t pixels = options.max_width * options.max_height;
  const size_t items = (std::max(1u, triangles) + records_per_item - 1) / records_per_item;
  const BufferRef unused = recorder.transient<LayeredFragment>(name + ".unused", 1);
  recorder.fill_zero(name + ".clear_unused", unused);
  const auto emit = [&](const std::string& pass_name, uint32_t mode, const BufferRef& capacity, const BufferRef& counts,
                        const BufferRef& node_count, const BufferRef& fragments, const BufferRef& next) {
    PassBuilder pass = recorder.pass(name + pass_name, lists, "layered_list_fragments");
    bind_tiles(pass, view, bins, lists, "layered_list_fragments", 0);
    pass.global(items).local(1).arg("layered_bounds", bins.bounds).arg("layered_extra_bounds", bins.extra_bounds)
        .arg("layered_clipped", bins.clipped).arg("mode", mode).arg("capacity_counter", capacity)
        .arg("counts", counts).arg("node_count", node_count).arg("fragments", fragments).arg("next", next);
  };
  Stored stored;
  stored.dropped = recorder.transient<uint32_t>(name + ".dropped", 1);
  recorder.fill_zero(name + ".clear_dropped", stored.dropped);
  stored.pixel_start = recorder.transient<uint32_t>(name + ".pixel_start", pixels + 1, smaller_film);
  const BufferRef total = recorder.transient<uint32_t>(name + ".fragment_count", 1);
  const auto scan = [&] {
    primitives.record_exclusive_scan(recorder, name + ".scan", stored.pixel_start, stored.pixel_start, total, pixels + 1);
    stored.fragments = recorder.transient_sized_by<LayeredFragment>(name + ".fragments", total, 0, 1, smaller_film);
  };
  if (chosen.variant == LayeredVariant::exact) {
    const TypedBuffer<uint32_t> one(scheduler.device(), owner, "one", std::vector<uint32_t>{1});
    const BufferRef spare = recorder.transient<uint32_t>(name + ".spare", 2);
    recorder.fill_zero(name + ".clear_spare", spare);
    recorder.fill_zero(name + ".clear", stored.pixel_start);
    const BufferRef spare_next = recorder.transient<uint32_t>(name + ".spare_next", 1);
    recorder.fill_zero(name + ".clear_spare_next", spare_next);
    emit(".count", LAYERED_MODE_COUNT, one, stored.pixel_start, spare, unused, spare_next);
    scan();
    const BufferRef places = recorder.transient<uint32_t>(name + ".places", pixels, smaller_film);
    recorder.pass(name + ".copy_starts", lists, "layered_copy_starts").global(pixels).local(64)
        .arg("pixel_start", stored.pixel_start).arg("places", places).arg("pixels", pixels);
    emit(".fill", LAYERED_MODE_FILL, one, places, spare, stored.fragments, spare_next);
  } else {
    // Twice at most: when the nodes do not suffice, once more with as many as were asked for.
    const uint32_t capacity = static_cast<uint32_t>(
        std::min<uint64_t>(uint64_t{pixels} * std::max(1u, chosen.list_capacity), LAYERED_AWAY));
    const TypedBuffer<uint32_t> capacity_counter(scheduler.device(), owner, "capacity", std::vector<uint32_t>{capacity});
    BufferRef heads[2], next[2], nodes[2], node_count[2];
    const BufferRef needed = recorder.transient<uint32_t>(name + ".needed", 1);
    for (int attempt = 0; attempt < 2; ++attempt) {
      const std::string which = attempt ? ".again" : "";
      heads[attempt] = recorder.transient<uint32_t>(name + which + ".heads", pixels, smaller_film);
      node_count[attempt] = recorder.transient<uint32_t>(name + which + ".node_count", 1);
      recorder.fill_zero(name + which + ".clear_heads", heads[attempt]);
      recorder.fill_zero(name + which + ".clear_nodes", node_count[attempt]);
      if (attempt == 0) {
        next[0] = recorder.transient<uint32_t>(name + ".next", capacity, smaller_film);
        nodes[0] = recorder.transient<LayeredFragment>(name + ".nodes", capacity, smaller_film);
        emit(".link", LAYERED_MODE_LINK, capacity_counter, heads[0], node_count[0], nodes[0], next[0]);
        recorder.pass(name + ".shortage", lists, "layered_list_shortage").global(1).local(1)
            .arg("node_count", node_count[0]).arg("capacity", capacity).arg("needed", needed);
      } else {
        next[1] = recorder.transient_sized_by<uint32_t>(name + ".more_next", needed, 0, 1, smaller_film);
        nodes[1] = recorder.transient_sized_by<LayeredFragment>(name + ".more_nodes", needed, 0, 1, smaller_film);
        emit(".link_again", LAYERED_MODE_LINK, needed, heads[1], node_count[1], nodes[1], next[1]);
      }
    }
    recorder.pass(name + ".lengths", lists, "layered_list_lengths").global(pixels + 1).local(64)
        .arg("heads", heads[0]).arg("next", next[0]).arg("needed", needed).arg("more_heads", heads[1])
        .arg("more_next", next[1]).arg("pixels", pixels).arg("pixel_counts", stored.pixel_start)
        .discards("pixel_counts");
    scan();
    recorder.pass(name + ".collect", lists, "layered_list_collect").global(pixels).local(64)
        .arg("heads", heads[0]).arg("next", next[0]).arg("nodes", nodes[0]).arg("needed", needed)
        .arg("more_heads", heads[1]).arg("more_next", next[1]).arg("more_nodes", nodes[1]).arg("pixels", pixels)
        .arg("pixel_start", stored.pixel_start).arg("fragments", stored.fragments);
  }
  recorder.pass(name + ".sort", lists, "layered_sort_pixels").global(pixels).local(64)
      .arg("layered_views", view.views).arg("layered_view", view.index).arg("pixels", pixels)
      .arg("pixel_start", stored.pixel_start).arg("fragments", stored.fragments);
  return stored;
}

void LayeredRaster::State::record_nearest(ScheduleRecorder& recorder, const std::string& name, const ViewRef& view,
                                          const BufferRef& depth, const BufferRef& triangle) const {
  const LayeredBins bins = record_bins(recorder, name, view);
  const Program& nearest = consumer("layered_raster_nearest", 1);
  const uint32_t pixels = options.max_width * options.max_height;
  recorder.pass(name + ".clear", nearest, "layered_clear_nearest").global(pixels).local(64)
      .arg("depth", depth).arg("triangle", triangle).arg("pixels", pixels);
  record_tiles(recorder, name + ".nearest", view, bins, nearest, "layered_store_nearest",
               [&](PassBuilder& pass) { pass.arg("depth", depth).arg("triangle", triangle); });
}

LayeredRaster::Stored LayeredRaster::record_stored(ScheduleRecorder& recorder, const std::string& name,
                                                   const ViewRef& view, const LayeredStoreOptions& options) const {
  const bool limited = options.variant == LayeredVariant::k_buffer;
  if (limited && (options.keep < 1 || options.keep > LAYERED_MAX_LAYERS))
    throw_error(ErrorClass::usage, "layered raster: k-buffer of {} fragments, must be 1 to {}", options.keep,
                LAYERED_MAX_LAYERS);
  if (limited || options.variant == LayeredVariant::tiles)
    return state_->record_tile_store(recorder, name, view, limited ? options.keep : 0);
  return state_->record_list_store(recorder, name, view, options);
}

void LayeredRaster::record_nearest(ScheduleRecorder& recorder, const std::string& name, const ViewRef& view,
                                   const BufferRef& depth, const BufferRef& triangle) const {
  state_->record_nearest(recorder, name, view, depth, triangle);
}

}  // namespace lucarium
