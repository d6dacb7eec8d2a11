// SPDX-License-Identifier: Apache-2.0
// Adds light samples and connections that nothing blocks to their pixels' sample.
#include "bidirectional_vpl/eye/eye_path.clh"

__kernel void add_eye_light_samples(const BidirectionalSettings settings, __global const uint* restrict queue,
                                    __global const uint* restrict active, __global const Ray* restrict rays,
                                    __global const float4* restrict light, __global const uint* restrict occluded,
                                    __global float4* restrict sample) {
  const uint i = (uint)get_global_id(0);
  if (i >= active[0] || !ray_is_active(rays[i]) || occluded[i]) return;
  add_to_sample(settings, queue[i], as_uint(light[i].w), 0, light[i].xyz, sample);
}

__kernel void add_connections(const BidirectionalSettings settings, __global const uint* restrict queue,
                              __global const uint* restrict active, __global const Ray* restrict rays,
                              __global const float4* restrict light, __global const uint* restrict occluded,
                              __global float4* restrict sample) {
  const uint i = (uint)get_global_id(0);
  if (i >= active[0] || !ray_is_active(rays[i]) || occluded[i]) return;
  const uint path = as_uint(light[i].w);
  add_to_sample(settings, queue[i], path & 0xffffu, (int)(path >> 16), light[i].xyz, sample);
}
