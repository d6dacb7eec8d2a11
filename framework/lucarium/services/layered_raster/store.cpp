// SPDX-License-Identifier: Apache-2.0
// Consumers of LayeredRaster that write buffers. Declared in layered_raster.h.
#include <algorithm>

#include "lucarium/base/error.h"
#include "lucarium/compute/program/source_library.h"
#include "lucarium/services/layered_raster/state.h"

namespace lucarium {

namespace {

constexpr uint32_t records_per_item = 64;

}  // namespace

const Program& LayeredRaster::State::consumer(const std::string& file, uint32_t keep) const {
  Program& found = consumers[{file, keep}];
  if (!found) {
    std::map<std::string, std::string> all = defines();
    all["LAYERED_DEPTH"] = "";
    if (keep > 0) {
      all["LAYERED_KEEP"] = std::to_string(keep) + "u";
      all["LAYERED_MAX_LAYERS"] = std::to_string(keep) + "u";
    }
    found = Program(scheduler.device(), SourceLibrary(),
                    {.name = "services/layered_raster/" + file,
                     .files = {"lucarium/services/layered_raster/" + file + ".cl"},
                     .defines = all});
  }
  return found;
}

LayeredRaster::Stored LayeredRaster::State::record_tile_store(ScheduleRecorder& recorder, const std::string& name,
                                                              const ViewRef& view, uint32_t keep) const {
  const LayeredBins bins = record_bins(recorder, name, view);
  const Program& store = consumer("store", keep);
  const uint32_t pixels = options.max_width * options.max_height;
  const uint32_t rows = (options.max_height + LAYERED_TILE_ROWS - 1) / LAYERED_TILE_ROWS;
  Stored stored;
  stored.pixel_start = recorder.transient<uint32_t>(name + ".pixel_start", pixels + 1, options.remedy);
  const BufferRef row_dropped = recorder.transient<uint32_t>(name + ".row_dropped", rows);
  recorder.fill_zero(name + ".clear", stored.pixel_start);  // views may be smaller than the largest image
  recorder.fill_zero(name + ".clear_dropped", row_dropped);
  record_tiles(recorder, name + ".count", view, bins, store, "layered_count_fragments",
               [&](PassBuilder& pass) { pass.arg("pixel_counts", stored.pixel_start).arg("dropped", row_dropped); });
  stored.dropped = recorder.transient<uint32_t>(name + ".dropped", 1);
  primitives.record_reduce(recorder, name + ".sum_dropped", Primitives::Reduction::sum_uint, row_dropped,
                           stored.dropped, rows);
  const BufferRef total = recorder.transient<uint32_t>(name + ".fragment_count", 1);
  primitives.record_exclusive_scan(recorder, name + ".scan", stored.pixel_start, stored.pixel_start, total, pixels + 1);
  stored.fragments = recorder.transient_sized_by<LayeredFragment>(name + ".fragments", total, 0, 1, options.remedy);
  record_tiles(recorder, name + ".store", view, bins, store, "layered_store_fragments", [&](PassBuilder& pass) {
    pass.arg("pixel_start", stored.pixel_start).arg("fragments", stored.fragments);
  });
  return stored;
}

/// Records the textbook variants of lists.cl.
class LayeredRaster::ListStore {
 public:
  ListStore(const State& state, ScheduleRecorder& recorder, const std::string& name, const ViewRef& view)
      : state_(state),
        recorder_(recorder),
        name_(name),
        view_(view),
        bins_(state.record_bins(recorder, name, view)),
        lists_(state.consumer("lists")),
        pixels_(state.options.max_width * state.options.max_height),
        dummy_(zeroed<uint32_t>("dummy", 1)) {
    stored_.pixel_start = recorder.transient<uint32_t>(name + ".pixel_start", pixels_ + 1, state_.options.remedy);
    stored_.dropped = zeroed<uint32_t>("dropped", 1);
  }

  /// Count, scan, fill.
  Stored counted() {
    const TypedBuffer<uint32_t> one = constant("one", 1);
    const BufferRef no_fragments = zeroed<LayeredFragment>("no_fragments", 1),
                    no_nodes = zeroed<uint32_t>("no_nodes", 1);
    recorder_.fill_zero(name_ + ".clear", stored_.pixel_start);
    emit("count", LAYERED_MODE_COUNT, one, stored_.pixel_start, no_nodes, no_fragments, dummy_);
    scan();
    const BufferRef places = recorder_.transient<uint32_t>(name_ + ".places", pixels_, state_.options.remedy);
    recorder_.pass(name_ + ".copy_starts", lists_, "layered_copy_starts")
        .global(pixels_)
        .arg("pixel_start", stored_.pixel_start)
        .arg("places", places)
        .arg("pixels", pixels_);
    emit("fill", LAYERED_MODE_FILL, one, places, no_nodes, stored_.fragments, dummy_);
    return sorted();
  }

  /// Lists of `nodes_per_pixel` nodes on average; when they do not suffice, once more with as many as were asked for.
  Stored linked(uint32_t nodes_per_pixel) {
    const auto capacity =
        static_cast<uint32_t>(std::min<uint64_t>(uint64_t{pixels_} * std::max(1u, nodes_per_pixel), LAYERED_AWAY));
    const BufferRef heads = zeroed<uint32_t>("heads", pixels_), node_count = zeroed<uint32_t>("node_count", 1);
    const BufferRef next = recorder_.transient<uint32_t>(name_ + ".next", capacity, state_.options.remedy);
    const BufferRef nodes = recorder_.transient<LayeredFragment>(name_ + ".nodes", capacity, state_.options.remedy);
    emit("link", LAYERED_MODE_LINK, constant("capacity", capacity), heads, node_count, nodes, next);
    const BufferRef needed = recorder_.transient<uint32_t>(name_ + ".needed", 1);
    recorder_.pass(name_ + ".shortage", lists_, "layered_list_shortage")
        .global(1)
        .local(1)
        .arg("node_count", node_count)
        .arg("capacity", capacity)
        .arg("needed", needed);
    const BufferRef more_heads = zeroed<uint32_t>("more_heads", pixels_);
    const BufferRef more_count = zeroed<uint32_t>("more_node_count", 1);
    const BufferRef more_next =
        recorder_.transient_sized_by<uint32_t>(name_ + ".more_next", needed, 0, 1, state_.options.remedy);
    const BufferRef more_nodes =
        recorder_.transient_sized_by<LayeredFragment>(name_ + ".more_nodes", needed, 0, 1, state_.options.remedy);
    emit("link_again", LAYERED_MODE_LINK, needed, more_heads, more_count, more_nodes, more_next);
    recorder_.pass(name_ + ".lengths", lists_, "layered_list_lengths")
        .global(pixels_ + 1)
        .arg("heads", heads)
        .arg("next", next)
        .arg("needed", needed)
        .arg("more_heads", more_heads)
        .arg("more_next", more_next)
        .arg("pixels", pixels_)
        .arg("pixel_counts", stored_.pixel_start)
        .discards("pixel_counts");
    scan();
    recorder_.pass(name_ + ".collect", lists_, "layered_list_collect")
        .global(pixels_)
        .arg("heads", heads)
        .arg("next", next)
        .arg("nodes", nodes)
        .arg("needed", needed)
        .arg("more_heads", more_heads)
        .arg("more_next", more_next)
        .arg("more_nodes", more_nodes)
        .arg("pixels", pixels_)
        .arg("pixel_start", stored_.pixel_start)
        .arg("fragments", stored_.fragments);
    return sorted();
  }

 private:
  template <class T>
  BufferRef zeroed(const std::string& what, size_t count) {
    const BufferRef buffer = recorder_.transient<T>(name_ + "." + what, count, state_.options.remedy);
    recorder_.fill_zero(name_ + ".clear_" + what, buffer);
    return buffer;
  }
  TypedBuffer<uint32_t> constant(const std::string& what, uint32_t value) const {
    return {state_.scheduler.device(), state_.owner, what, std::vector<uint32_t>{value}};
  }

  void emit(const std::string& what, uint32_t mode, const BufferRef& capacity, const BufferRef& counts,
            const BufferRef& node_count, const BufferRef& fragments, const BufferRef& next) {
    PassBuilder pass = recorder_.pass(name_ + "." + what, lists_, "layered_list_fragments");
    state_.bind_tiles(pass, view_, bins_, 0);
    pass.global((std::max(1u, state_.triangles) + records_per_item - 1) / records_per_item)
        .local(1)
        .arg("layered_bounds", bins_.bounds)
        .arg("layered_extra_bounds", bins_.extra_bounds)
        .arg("layered_clipped", bins_.clipped)
        .arg("mode", mode)
        .arg("capacity_counter", capacity)
        .arg("counts", counts)
        .arg("node_count", node_count)
        .arg("fragments", fragments)
        .arg("next", next);
  }

  void scan() {
    const BufferRef total = recorder_.transient<uint32_t>(name_ + ".fragment_count", 1);
    state_.primitives.record_exclusive_scan(recorder_, name_ + ".scan", stored_.pixel_start, stored_.pixel_start, total,
                                            pixels_ + 1);
    stored_.fragments =
        recorder_.transient_sized_by<LayeredFragment>(name_ + ".fragments", total, 0, 1, state_.options.remedy);
  }

  Stored sorted() {
    recorder_.pass(name_ + ".sort", lists_, "layered_sort_pixels")
        .global(pixels_)
        .arg("layered_views", view_.views)
        .arg("layered_view", view_.index)
        .arg("pixels", pixels_)
        .arg("pixel_start", stored_.pixel_start)
        .arg("fragments", stored_.fragments);
    return stored_;
  }

  const State& state_;
  ScheduleRecorder& recorder_;
  std::string name_;
  ViewRef view_;
  LayeredBins bins_;
  const Program& lists_;
  uint32_t pixels_;
  BufferRef dummy_;
  Stored stored_;
};

void LayeredRaster::State::record_nearest(ScheduleRecorder& recorder, const std::string& name, const ViewRef& view,
                                          const BufferRef& depth, const BufferRef& triangle) const {
  const LayeredBins bins = record_bins(recorder, name, view);
  const Program& nearest = consumer("nearest", 1);
  record_each_tile(recorder, name + ".nearest", view, bins, nearest, "layered_store_nearest",
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
  ListStore lists(*state_, recorder, name, view);
  return options.variant == LayeredVariant::exact ? lists.counted() : lists.linked(options.list_capacity);
}

void LayeredRaster::record_nearest(ScheduleRecorder& recorder, const std::string& name, const ViewRef& view,
                                   const BufferRef& depth, const BufferRef& triangle) const {
  state_->record_nearest(recorder, name, view, depth, triangle);
}

}  // namespace lucarium
