// SPDX-License-Identifier: Apache-2.0
// Writes behind the end of its buffer, for Oclgrind to find.
kernel void write_outside(global float* values, const uint count) {
  if (get_global_id(0) == 0) values[count] = 1.0f;
}
