// SPDX-License-Identifier: Apache-2.0
// Small kernels whose results depend on the order in which they run.

__kernel void mix_in(__global uint* target, __global const uint* source, uint factor, uint count) {
  const uint i = get_global_id(0);
  if (i < count) target[i] = target[i] * factor + source[(i + 1) % count];
}

__kernel void overwrite(__global uint* target, __global const uint* source, uint salt, uint count) {
  const uint i = get_global_id(0);
  if (i < count) target[i] = (source[i] ^ salt) * 2654435761u + i;
}

__kernel void write_pattern(__global uint* target, uint salt, uint count) {
  const uint i = get_global_id(0);
  if (i < count) target[i] = i * 7u + salt;
}

// One work-item does everything: a narrow pass that takes a while.
__kernel void scramble_alone(__global uint* target, uint rounds, uint count) {
  if (get_global_id(0) > 0) return;
  uint carry = 1;
  for (uint round = 0; round < rounds; ++round)
    for (uint i = 0; i < count; ++i) target[i] = carry = (target[i] ^ carry) * 1664525u + round;
}

__kernel void count_multiples(__global const uint* values, __global uint* counter, uint divisor, uint count) {
  const uint i = get_global_id(0);
  if (i < count && values[i] % divisor == 0) atomic_inc(counter);
}

// Writes out[i] = i * salt for all i below the counter; with an index behind it nothing is touched.
__kernel void fill_counted(__global uint* out, __global const uint* counter, uint salt) {
  const uint i = get_global_id(0);
  if (i < *counter) out[i] = i * salt;
}

__kernel void sum_counted(__global const uint* values, __global const uint* counter, __global uint* sum) {
  if (get_global_id(0) > 0) return;
  uint total = 0;
  for (uint i = 0; i < *counter; ++i) total += values[i];
  *sum = total;
}

__kernel void add_index(__global uint* out, uint count, uint slice_base) {
  const uint i = slice_base + get_global_id(0);
  if (i < count) out[i] = out[i] * 3u + i;
}

// The same, but the first items take long.
__kernel void add_index_late(__global uint* out, uint rounds, uint count, uint slice_base) {
  const uint i = slice_base + get_global_id(0);
  if (i >= count) return;
  uint value = out[i];
  if (i < 16)
    for (uint round = 0; round < rounds; ++round) value = value * 1664525u + (value >> 5) + round;
  out[i] = value * 3u + i;
}

__kernel void add_to_counter(__global uint* counter, uint amount) {
  if (get_global_id(0) == 0) *counter += amount;
}

__kernel void poke(__global uint* out, int index, uint value) {
  if (get_global_id(0) == 0) out[index] = value;
}

__kernel void use_local(__local uint* scratch, __global uint* out) {
  scratch[get_local_id(0)] = get_local_id(0);
  barrier(CLK_LOCAL_MEM_FENCE);
  out[get_global_id(0)] = scratch[get_local_size(0) - 1 - get_local_id(0)];
}

__kernel __attribute__((reqd_work_group_size(32, 1, 1))) void needs_32(__global uint* out) {
  out[get_global_id(0)] = (uint)get_local_size(0);
}
