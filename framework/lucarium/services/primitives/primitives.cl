// SPDX-License-Identifier: Apache-2.0
// Scan, compact, reduce and radix sort, chunk by chunk: a work-item walks CHUNK consecutive elements, so that nothing
// needs barriers or atomics and every result is independent of how work-items are scheduled (local size 1).
#ifndef CHUNK
#define CHUNK 4096
#define SORT_CHUNK 8192
#endif
#define RADIX 256u

// Scan and compact ----------------------------------------------------------------------------------------------------
// chunk_sums[chunks] keeps the element count, because the total may overwrite the counter that it came from.

__kernel void sum_chunks(__global const uint* in, __global uint* chunk_sums, uint chunks, __global const uint* counter,
                         uint counter_index, uint capacity) {
  const uint count = min(counter[counter_index], capacity);
  const uint chunk = get_global_id(0), first = chunk * CHUNK, end = min(first + CHUNK, count);
  uint sum = 0u;
  for (uint i = first; i < end; ++i) sum += in[i];
  chunk_sums[chunk] = sum;
  if (chunk == 0u) chunk_sums[chunks] = count;
}

__kernel void count_flags(__global const uint* flags, __global uint* chunk_sums, uint chunks,
                          __global const uint* counter, uint counter_index, uint capacity) {
  const uint count = min(counter[counter_index], capacity);
  const uint chunk = get_global_id(0), first = chunk * CHUNK, end = min(first + CHUNK, count);
  uint sum = 0u;
  for (uint i = first; i < end; ++i) sum += flags[i] != 0u;
  chunk_sums[chunk] = sum;
  if (chunk == 0u) chunk_sums[chunks] = count;
}

// One work-item.
__kernel void scan_chunk_sums(__global uint* chunk_sums, uint chunks, __global uint* total, uint total_index) {
  uint sum = 0u;
  for (uint chunk = 0u; chunk < chunks; ++chunk) {
    const uint value = chunk_sums[chunk];
    chunk_sums[chunk] = sum;
    sum += value;
  }
  total[total_index] = sum;
}

// The sums of what is before each of eight numbers.
static uint8 sums_before(uint8 numbers) {
  uint8 sums = numbers + (uint8)(0u, numbers.s0, numbers.s12, numbers.s3456);
  sums += (uint8)((uint2)(0u), sums.s01, sums.s2345);
  sums += (uint8)((uint4)(0u), sums.lo);
  return sums - numbers;
}

// `in` is not const because it may be `out`.
__kernel void scan_chunks(__global uint* in, __global uint* out, __global const uint* chunk_sums, uint chunks) {
  const uint chunk = get_global_id(0), first = chunk * CHUNK;
  const uint end = min(first + CHUNK, chunk_sums[chunks]);
  uint sum = chunk_sums[chunk];
  uint i = first;
  for (; i + 8u <= end; i += 8u) {
    const uint8 numbers = vload8(0, in + i), before = sums_before(numbers) + sum;
    vstore8(before, 0, out + i);
    sum = before.s7 + numbers.s7;
  }
  for (; i < end; ++i) {
    const uint value = in[i];
    out[i] = sum;
    sum += value;
  }
}

__kernel void compact_chunks(__global const uint* flags, __global uint* out, __global const uint* chunk_sums,
                             uint chunks) {
  const uint chunk = get_global_id(0), first = chunk * CHUNK;
  const uint end = min(first + CHUNK, chunk_sums[chunks]);
  uint target = chunk_sums[chunk];
  for (uint i = first; i < end; ++i)
    if (flags[i] != 0u) out[target++] = i;
}

// Reduce --------------------------------------------------------------------------------------------------------------

__kernel void reduce_sum_uint(__global const uint* in, __global uint* out, uint count, uint chunk_size) {
  const uint chunk = get_global_id(0), first = chunk * chunk_size, end = min(first + chunk_size, count);
  uint sum = 0u;
  for (uint i = first; i < end; ++i) sum += in[i];
  out[chunk] = sum;
}

__kernel void reduce_min_float(__global const float* in, __global float* out, uint count, uint chunk_size) {
  const uint chunk = get_global_id(0), first = chunk * chunk_size, end = min(first + chunk_size, count);
  float least = INFINITY;
  for (uint i = first; i < end; ++i) least = fmin(least, in[i]);
  out[chunk] = least;
}

__kernel void reduce_max_float(__global const float* in, __global float* out, uint count, uint chunk_size) {
  const uint chunk = get_global_id(0), first = chunk * chunk_size, end = min(first + chunk_size, count);
  float largest = -INFINITY;
  for (uint i = first; i < end; ++i) largest = fmax(largest, in[i]);
  out[chunk] = largest;
}

// Neumaier's compensated sum ("Rundungsfehleranalyse einiger Verfahren zur Summation endlicher Summen", 1974).
__kernel void reduce_sum_float(__global const float* in, __global float* out, uint count, uint chunk_size) {
  const uint chunk = get_global_id(0), first = chunk * chunk_size, end = min(first + chunk_size, count);
  float sum = 0.0f, lost = 0.0f;
  for (uint i = first; i < end; ++i) {
    const float value = in[i], next = sum + value;
    if (isfinite(next)) lost += fabs(sum) >= fabs(value) ? (sum - next) + value : (value - next) + sum;
    sum = next;
  }
  out[chunk] = sum + lost;
}

// Radix sort, 8 bits per round ----------------------------------------------------------------------------------------

// histograms[digit · chunks + chunk], so that their exclusive scan is where each chunk's keys of a digit go.
__kernel void count_digits(__global const uint* keys, __global uint* histograms, uint count, uint chunks, uint shift,
                           uint mask) {
  const uint chunk = get_global_id(0), first = chunk * SORT_CHUNK, end = min(first + SORT_CHUNK, count);
  if (chunk >= chunks) return;
  uint counts[RADIX];
  for (uint digit = 0u; digit < RADIX; ++digit) counts[digit] = 0u;
  for (uint i = first; i < end; ++i) ++counts[(keys[i] >> shift) & mask];
  for (uint digit = 0u; digit < RADIX; ++digit) histograms[digit * chunks + chunk] = counts[digit];
}

__kernel void scatter_pairs(__global const uint* keys, __global const uint* values, __global const uint* histograms,
                            __global uint* keys_out, __global uint* values_out, uint count, uint chunks, uint shift,
                            uint mask) {
  const uint chunk = get_global_id(0), first = chunk * SORT_CHUNK, end = min(first + SORT_CHUNK, count);
  if (chunk >= chunks) return;
  uint targets[RADIX];
  for (uint digit = 0u; digit < RADIX; ++digit) targets[digit] = histograms[digit * chunks + chunk];
  for (uint i = first; i < end; ++i) {
    const uint key = keys[i], target = targets[(key >> shift) & mask]++;
    keys_out[target] = key;
    values_out[target] = values[i];
  }
}

__kernel void copy_pairs(__global const uint* keys, __global const uint* values, __global uint* keys_out,
                         __global uint* values_out, uint count) {
  const uint first = get_global_id(0) * SORT_CHUNK, end = min(first + SORT_CHUNK, count);
  for (uint i = first; i < end; ++i) {
    keys_out[i] = keys[i];
    values_out[i] = values[i];
  }
}
