// SPDX-License-Identifier: Apache-2.0
#include "lucarium/services/primitives/primitives.h"

#include <algorithm>

#include "lucarium/base/error.h"
#include "lucarium/compute/program/source_library.h"

namespace lucarium {

namespace {

constexpr uint32_t chunk_size = 4096;       // elements per work-item: few enough chunks for a serial scan of their sums
constexpr uint32_t sort_chunk_size = 8192;  // large beside the 256 counters that a chunk costs
constexpr uint32_t radix = 256;

uint32_t chunk_count(uint32_t elements, uint32_t size) { return std::max(1u, (elements + size - 1) / size); }

/// A counter that always holds `count`, for the variants without a device counter.
TypedBuffer<uint32_t> constant_counter(Device& device, uint32_t count) {
  return TypedBuffer<uint32_t>(device, "primitives", "count", std::vector<uint32_t>{count});
}

const char* kernel_name(Primitives::Reduction operation) {
  switch (operation) {
    case Primitives::Reduction::sum_uint: return "reduce_sum_uint";
    case Primitives::Reduction::min_float: return "reduce_min_float";
    case Primitives::Reduction::max_float: return "reduce_max_float";
    case Primitives::Reduction::sum_float: return "reduce_sum_float";
  }
  throw Error(ErrorClass::internal, "unknown reduction");
}

}  // namespace

Primitives::Primitives(Device& device)
    : device_(&device),
      program_(device, SourceLibrary(),
               {.name = "services/primitives",
                .files = {"lucarium/services/primitives/primitives.cl"},
                .defines = {{"CHUNK", std::to_string(chunk_size)}, {"SORT_CHUNK", std::to_string(sort_chunk_size)}},
                .mad_enable = false}) {}

void Primitives::record_exclusive_scan(ScheduleRecorder& recorder, const std::string& name, const BufferRef& in,
                                       const BufferRef& out, const BufferRef& total, uint32_t count) const {
  record_exclusive_scan(recorder, name, in, out, total, constant_counter(*device_, count), 0, count);
}

void Primitives::record_exclusive_scan(ScheduleRecorder& recorder, const std::string& name, const BufferRef& in,
                                       const BufferRef& out, const BufferRef& total, const BufferRef& counter,
                                       uint32_t counter_index, uint32_t capacity) const {
  const uint32_t chunks = chunk_count(capacity, chunk_size);
  const BufferRef sums = recorder.transient<uint32_t>(name + ".chunk_sums", chunks + 1);
  recorder.pass(name + ".sum_chunks", program_, "sum_chunks")
      .global(chunks)
      .local(1)
      .arg("in", in)
      .arg("chunk_sums", sums)
      .arg("chunks", chunks)
      .arg("counter", counter)
      .arg("counter_index", counter_index)
      .arg("capacity", capacity);
  record_chunk_sums(recorder, name, sums, chunks, total, 0);
  recorder.pass(name + ".scan_chunks", program_, "scan_chunks")
      .global(chunks)
      .local(1)
      .arg("in", in)
      .arg("out", out)
      .arg("chunk_sums", sums)
      .arg("chunks", chunks);
}

void Primitives::record_chunk_sums(ScheduleRecorder& recorder, const std::string& name, const BufferRef& sums,
                                   uint32_t chunks, const BufferRef& total, uint32_t total_index) const {
  recorder.pass(name + ".scan_chunk_sums", program_, "scan_chunk_sums")
      .global(1)
      .local(1)
      .arg("chunk_sums", sums)
      .arg("chunks", chunks)
      .arg("total", total)
      .arg("total_index", total_index);
}

void Primitives::record_compact(ScheduleRecorder& recorder, const std::string& name, const BufferRef& flags,
                                const BufferRef& out, const BufferRef& out_count, uint32_t out_index,
                                const BufferRef& counter, uint32_t counter_index, uint32_t capacity) const {
  const uint32_t chunks = chunk_count(capacity, chunk_size);
  const BufferRef sums = recorder.transient<uint32_t>(name + ".chunk_sums", chunks + 1);
  recorder.pass(name + ".count_flags", program_, "count_flags")
      .global(chunks)
      .local(1)
      .arg("flags", flags)
      .arg("chunk_sums", sums)
      .arg("chunks", chunks)
      .arg("counter", counter)
      .arg("counter_index", counter_index)
      .arg("capacity", capacity);
  record_chunk_sums(recorder, name, sums, chunks, out_count, out_index);
  recorder.pass(name + ".compact_chunks", program_, "compact_chunks")
      .global(chunks)
      .local(1)
      .arg("flags", flags)
      .arg("out", out)
      .arg("chunk_sums", sums)
      .arg("chunks", chunks);
}

void Primitives::record_reduce(ScheduleRecorder& recorder, const std::string& name, Reduction operation,
                               const BufferRef& in, const BufferRef& result, uint32_t count) const {
  const uint32_t chunks = chunk_count(count, chunk_size);
  const BufferRef partial = recorder.transient<uint32_t>(name + ".partial", chunks);
  recorder.pass(name + ".reduce_chunks", program_, kernel_name(operation))
      .global(chunks)
      .local(1)
      .arg("in", in)
      .arg("out", partial)
      .arg("count", count)
      .arg("chunk_size", chunk_size);
  recorder.pass(name + ".combine", program_, kernel_name(operation))
      .global(1)
      .local(1)
      .arg("in", partial)
      .arg("out", result)
      .arg("count", chunks)
      .arg("chunk_size", chunks);
}

void Primitives::record_sort_pairs(ScheduleRecorder& recorder, const std::string& name, const BufferRef& keys,
                                   const BufferRef& values, uint32_t count, int bits) const {
  if (bits < 0 || bits > 32) throw_error(ErrorClass::internal, "sort '{}': {} key bits, must be 0 to 32", name, bits);
  if (bits == 0 || count < 2) return;
  const uint32_t chunks = chunk_count(count, sort_chunk_size);
  const BufferRef histograms = recorder.transient<uint32_t>(name + ".histograms", radix * chunks);
  const BufferRef unused_total = recorder.transient<uint32_t>(name + ".total", 1);
  const BufferRef other_keys = recorder.transient<uint32_t>(name + ".keys", count);
  const BufferRef other_values = recorder.transient<uint32_t>(name + ".values", count);
  const BufferRef key_buffers[2] = {keys, other_keys}, value_buffers[2] = {values, other_values};
  int from = 0;
  for (int shift = 0; shift < bits; shift += 8, from ^= 1) {
    const uint32_t mask = bits - shift < 8 ? (1u << (bits - shift)) - 1u : radix - 1u;
    const std::string round = name + ".bits_" + std::to_string(shift);
    recorder.pass(round + ".count_digits", program_, "count_digits")
        .global(chunks)
        .local(1)
        .arg("keys", key_buffers[from])
        .arg("histograms", histograms)
        .arg("count", count)
        .arg("chunks", chunks)
        .arg("shift", static_cast<uint32_t>(shift))
        .arg("mask", mask);
    record_exclusive_scan(recorder, round + ".scan", histograms, histograms, unused_total, radix * chunks);
    recorder.pass(round + ".scatter_pairs", program_, "scatter_pairs")
        .global(chunks)
        .local(1)
        .arg("keys", key_buffers[from])
        .arg("values", value_buffers[from])
        .arg("histograms", histograms)
        .arg("keys_out", key_buffers[from ^ 1])
        .arg("values_out", value_buffers[from ^ 1])
        .arg("count", count)
        .arg("chunks", chunks)
        .arg("shift", static_cast<uint32_t>(shift))
        .arg("mask", mask);
  }
  if (from == 1)
    recorder.pass(name + ".copy_pairs", program_, "copy_pairs")
        .global(chunks)
        .local(1)
        .arg("keys", other_keys)
        .arg("values", other_values)
        .arg("keys_out", keys)
        .arg("values_out", values)
        .arg("count", count);
}

}  // namespace lucarium
