// SPDX-License-Identifier: Apache-2.0
#include "voxel_abuffer/compared/voxel_pairs.h"

#include <algorithm>
#include <bit>

#include "lucarium/base/error.h"
#include "lucarium/compute/program/source_library.h"
#include "voxel_abuffer/base/name.h"

const lucarium::EmbeddedSources& voxel_abuffer_kernels();

namespace lucarium::abuffer {

namespace {

constexpr double max_pairs = 4e9;  // indices are 32 bits wide

std::map<std::string, std::string> defines(bool morton) {
  std::map<std::string, std::string> result;
  if (morton) result["COMPARED_MORTON"] = "";
  return result;
}

/// Keys are below 1 << this.
uint32_t key_bits(const AbufferGrid& grid, bool morton) {
  const uint32_t largest = std::max({grid.bricks.x, grid.bricks.y, grid.bricks.z});
  if (morton) return 3 * static_cast<uint32_t>(std::bit_width(largest - 1));
  return static_cast<uint32_t>(std::bit_width(VoxelPairs::brick_slots(grid) - 1));
}

}  // namespace

VoxelPairs::VoxelPairs(KernelScheduler& scheduler, const SceneBuffers& buffers, bool morton)
    : scheduler_(&scheduler),
      buffers_(&buffers),
      program_(make_program(scheduler.device(), voxel_abuffer_kernels(), {"voxel_abuffer/compared/voxel_pairs"},
                            defines(morton))),
      primitives_(scheduler.device()),
      morton_(morton),
      grid_(scheduler.device(), technique_name, "grid", 1),
      total_(scheduler.device(), technique_name, "number of pairs", 1),
      float_total_(scheduler.device(), technique_name, "number of pairs, rounded", 1),
      brick_counter_(scheduler.device(), technique_name, "number of bricks", 1),
      voxel_counter_(scheduler.device(), technique_name, "number of voxels", 1) {}

size_t VoxelPairs::bytes() const {
  size_t sum = 0;
  const Buffer* const all[] = {&counts_,      &float_counts_, &keys_,        &order_,       &triangles_,
                               &brick_start_, &brick_keys_,   &brick_first_, &brick_masks_, &within_};
  for (const Buffer* buffer : all) sum += buffer->bytes();
  return sum + (sort_schedule_ ? sort_schedule_.transient_bytes() : 0);
}

void VoxelPairs::count(const std::string& remedy) {
  const uint32_t triangles = layout_.triangles;
  if (!count_schedule_ || buffers_->generation() != scene_generation_) {
    scene_generation_ = buffers_->generation();
    make_compared_room(scheduler_->device(), counts_, "pairs of triangles", triangles, remedy);
    make_compared_room(scheduler_->device(), float_counts_, "pairs of triangles, rounded", triangles, remedy);
    ScheduleRecorder recorder = scheduler_->record("voxel_abuffer pairs", technique_name);
    PassBuilder pass = recorder.pass("count_pairs", program_, "compared_count_pairs");
    buffers_->bind(pass);
    pass.global(std::max(1u, triangles))
        .arg("compared_grid", grid_)
        .arg("pad", pad_)
        .arg("compared_counts", counts_)
        .arg("compared_float_counts", float_counts_);
    primitives_.record_reduce(recorder, "sum_pairs", Primitives::Reduction::sum_float, float_counts_, float_total_,
                              triangles);
    primitives_.record_exclusive_scan(recorder, "place_pairs", counts_, counts_, total_, triangles);
    count_schedule_ = recorder.compile();
    sort_schedule_ = {};
  }
  scheduler_->run_to_end(count_schedule_);
  scheduler_->finish();
  const double expected = static_cast<double>(float_total_.download()[0]);
  if (expected > max_pairs)
    throw_error(ErrorClass::device, "voxel_abuffer: {:.3g} pairs of voxels and triangles are more than {:.3g}; {}",
                expected, max_pairs, remedy);
  pair_count_ = total_.download()[0];
}

void VoxelPairs::record_sort(ScheduleRecorder& recorder) {
  const auto capacity = static_cast<uint32_t>(keys_.count());
  const uint32_t bits = key_bits(layout_, morton_);
  PassBuilder pass = recorder.pass("write_pairs", program_, "compared_write_pairs");
  buffers_->bind(pass);
  pass.global(std::max(1u, layout_.triangles))
      .arg("compared_grid", grid_)
      .arg("pad", pad_)
      .arg("compared_first", counts_)
      .arg("compared_keys", keys_)
      .arg("compared_order", order_)
      .arg("compared_within_brick", within_)
      .arg("compared_triangles", triangles_);
  recorder.pass("pad_keys", program_, "compared_pad_keys")
      .global(capacity)
      .arg("compared_total", total_)
      .arg("capacity", capacity)
      .arg("last", 1u << bits)
      .arg("compared_keys", keys_)
      .arg("compared_order", order_);
  primitives_.record_sort_pairs(recorder, "sort_pairs", keys_, order_, capacity, static_cast<int>(bits) + 1);
  const BufferRef begins = recorder.transient<uint32_t>("beginnings of bricks", capacity);
  recorder.pass("mark_runs", program_, "compared_mark_runs")
      .global(capacity)
      .arg("compared_keys", keys_)
      .arg("compared_total", total_)
      .arg("capacity", capacity)
      .arg("compared_begins", begins);
  primitives_.record_compact(recorder, "find_bricks", begins, brick_start_, brick_counter_, 0, total_, 0, capacity);
}

void VoxelPairs::record_bricks(ScheduleRecorder& recorder) {
  const auto room = static_cast<uint32_t>(brick_keys_.count());
  recorder.pass("fill_bricks", program_, "compared_fill_bricks")
      .global(room)
      .arg("compared_keys", keys_)
      .arg("compared_order", order_)
      .arg("compared_within_brick", within_)
      .arg("compared_total", total_)
      .arg("compared_brick_start", brick_start_)
      .arg("compared_brick_count", brick_counter_)
      .arg("capacity", room)
      .arg("compared_brick_keys", brick_keys_)
      .arg("compared_brick_masks", brick_masks_)
      .arg("compared_brick_voxels", brick_first_);
  primitives_.record_exclusive_scan(recorder, "place_voxels", brick_first_, brick_first_, voxel_counter_,
                                    brick_counter_, 0, room);
}

/// Number of bricks: known when the pairs are sorted.
void VoxelPairs::sort(const std::string& remedy) {
  Device& device = scheduler_->device();
  bool replaced = make_compared_room(device, within_, "voxels of pairs", pair_count_, remedy);
  for (const auto& [buffer, name] : {std::pair{&keys_, "keys of pairs"},
                                     {&order_, "order of pairs"},
                                     {&triangles_, "triangles of pairs"},
                                     {&brick_start_, "first pairs of bricks"}})
    replaced |= make_compared_room(device, *buffer, name, pair_count_, remedy);
  const uint32_t bits = key_bits(layout_, morton_);
  if (!sort_schedule_ || replaced || bits != recorded_bits_) {
    ScheduleRecorder recorder = scheduler_->record("voxel_abuffer sorted pairs", technique_name);
    record_sort(recorder);
    sort_schedule_ = recorder.compile();
    brick_schedule_ = {};
    recorded_bits_ = bits;
  }
  scheduler_->run_to_end(sort_schedule_);
  scheduler_->finish();
  brick_count_ = brick_counter_.download()[0];
}

void VoxelPairs::build(const AbufferGrid& grid, float pad, const std::string& remedy) {
  if (pad != pad_) count_schedule_ = {};
  layout_ = grid;
  pad_ = pad;
  grid_.upload({grid});
  count(remedy);
  sort(remedy);
  Device& device = scheduler_->device();
  bool replaced = make_compared_room(device, brick_masks_, "occupied voxels", brick_count_, remedy);
  replaced |= make_compared_room(device, brick_keys_, "bricks", brick_count_, remedy);
  replaced |= make_compared_room(device, brick_first_, "first voxels of bricks", brick_count_, remedy);
  generation_ += replaced;
  if (!brick_schedule_ || replaced) {
    ScheduleRecorder recorder = scheduler_->record("voxel_abuffer bricks", technique_name);
    record_bricks(recorder);
    brick_schedule_ = recorder.compile();
  }
  scheduler_->run_to_end(brick_schedule_);
  scheduler_->finish();
  voxel_count_ = voxel_counter_.download()[0];
}

PassBuilder VoxelPairs::bind_runs(PassBuilder pass) const {
  pass.global(std::max(1u, brick_count_))
      .arg("compared_brick_start", brick_start_)
      .arg("compared_total", total_)
      .arg("compared_order", order_)
      .arg("compared_within_brick", within_)
      .arg("compared_brick_masks", brick_masks_)
      .arg("compared_brick_first", brick_first_)
      .arg("count", brick_count_);
  return pass;
}

void VoxelPairs::record_leaves(ScheduleRecorder& recorder, const Program& fill, const BufferRef& leaves) const {
  bind_runs(recorder.pass("fill_leaves", fill, "compared_fill_leaves"))
      .arg("compared_triangles", triangles_)
      .arg("compared_leaves", leaves);
}

}  // namespace lucarium::abuffer
