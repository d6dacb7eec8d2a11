// SPDX-License-Identifier: Apache-2.0

// What a pass of `samples` samples has found becomes part of the image (Hu et al. 2014, algorithm 1: adds FB_curr to
// FB_comp).
__kernel void add_pass(uint pixels, uint samples, __global const float4* restrict pass,
                       __global float4* restrict sums) {
  const uint i = get_global_id(0);
  if (i >= pixels) return;
  sums[i] += (float4)(pass[i].xyz, (float)samples);
}
