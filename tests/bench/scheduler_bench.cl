// SPDX-License-Identifier: Apache-2.0

// As small as a pass can be: what is left is the cost of launching it.
__kernel void tiny(__global uint* target, __global const uint* source, uint factor, uint count) {
  const uint i = get_global_id(0);
  if (i < count) target[i] = target[i] * factor + source[i];
}

// A pass of one group that keeps one core busy.
__kernel void narrow(__global uint* target, uint rounds) {
  const uint i = get_global_id(0);
  uint value = target[i];
  for (uint round = 0; round < rounds; ++round) value = value * 1664525u + (value >> 3) + round;
  target[i] = value;
}

// As many buffers as a pass that reads the whole scene.
__kernel void many_buffers(__global uint* out, __global const uint* b0, __global const uint* b1,
                           __global const uint* b2, __global const uint* b3, __global const uint* b4,
                           __global const uint* b5, __global const uint* b6, __global const uint* b7,
                           __global const uint* b8, __global const uint* b9, __global const uint* b10,
                           __global const uint* b11, __global const uint* b12) {
  const uint i = get_global_id(0);
  out[i] = b0[i] + b1[i] + b2[i] + b3[i] + b4[i] + b5[i] + b6[i] + b7[i] + b8[i] + b9[i] + b10[i] + b11[i] + b12[i];
}
