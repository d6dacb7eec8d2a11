// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "lucarium/compute/schedule/schedule.h"

namespace lucarium {

/// Parallel building blocks over device buffers, recorded as passes. Chunked (one work-item per chunk) rather than
/// barrier-based: ten times faster on CPU devices and no local memory needed. All are deterministic and stable.
/// Counters are uint buffers; a count above `capacity` is taken as `capacity`. A counter may share its buffer with the
/// outputs `total` and `out_count`.
class Primitives {
 public:
  explicit Primitives(Device& device);

  /// out[i] = Σ_{j<i} in[j]; total (1 uint) = Σ all. `in` and `out` may be the same buffer. uint elements.
  void record_exclusive_scan(ScheduleRecorder& recorder, const std::string& name, const BufferRef& in,
                             const BufferRef& out, const BufferRef& total, uint32_t count) const;
  /// The same with the element count read from a device counter.
  void record_exclusive_scan(ScheduleRecorder& recorder, const std::string& name, const BufferRef& in,
                             const BufferRef& out, const BufferRef& total, const BufferRef& counter,
                             uint32_t counter_index, uint32_t capacity) const;
  /// out[0..m) = indices i with flags[i] != 0, ascending; out_count[out_index] = m.
  void record_compact(ScheduleRecorder& recorder, const std::string& name, const BufferRef& flags, const BufferRef& out,
                      const BufferRef& out_count, uint32_t out_index, const BufferRef& counter, uint32_t counter_index,
                      uint32_t capacity) const;
  enum class Reduction { sum_uint, min_float, max_float, sum_float };
  /// result[0] of all elements; float sums are compensated within chunks and combined in a fixed order. Nothing reduces
  /// to 0, +INFINITY (minimum) or -INFINITY (maximum); minimum and maximum ignore NaN.
  void record_reduce(ScheduleRecorder& recorder, const std::string& name, Reduction operation, const BufferRef& in,
                     const BufferRef& result, uint32_t count) const;
  /// Stable ascending radix sort of (key, value) uint pairs by the lowest `bits` of the key, in place.
  void record_sort_pairs(ScheduleRecorder& recorder, const std::string& name, const BufferRef& keys,
                         const BufferRef& values, uint32_t count, int bits = 32) const;

 private:
  void record_chunk_sums(ScheduleRecorder& recorder, const std::string& name, const BufferRef& sums, uint32_t chunks,
                         const BufferRef& total, uint32_t total_index) const;
  Device* device_;
  Program program_;
};

}  // namespace lucarium
