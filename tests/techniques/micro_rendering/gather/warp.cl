// SPDX-License-Identifier: Apache-2.0
// The warps alone.
#include "micro_rendering/gather/micro_solid_angle.clh"

// Directions of B x B midpoints, with p_omega and the weights of sample_weights in `values`; back: what the inverse
// makes of the directions. view: xyz, w alpha; eta: of the refracted lobe.
__kernel void warp_square(uint lobe, uint edge, float4 view, float eta, __global float4* restrict directions,
                          __global float4* restrict values, __global float2* restrict back) {
  const uint i = get_global_id(0);
  if (i >= edge * edge) return;
  MicroWarp warp;
  make_micro_warp(lobe, edge, view.w, eta, view.xyz, 1.0f, &warp);
  const float u = ((float)(i % edge) + 0.5f) / (float)edge, v = ((float)(i / edge) + 0.5f) / (float)edge;
  const Lanes3 w = lanes_warp(&warp, (Floats)(u), (Floats)(v));
  float x[MICRO_LANES], y[MICRO_LANES], z[MICRO_LANES], us[MICRO_LANES], vs[MICRO_LANES];
  MICRO_STORE(w.x, x);
  MICRO_STORE(w.y, y);
  MICRO_STORE(w.z, z);
  const float3 direction = (float3)(x[0], y[0], z[0]);
  directions[i] = (float4)(direction, 0.0f);
  Floats bu, bv;
  lanes_unwarp(&warp, w, (Floats)(1.0f), &bu, &bv);
  MICRO_STORE(bu, us);
  MICRO_STORE(bv, vs);
  back[i] = (float2)(us[0] - u, vs[0] - v);
  const float2 weights = sample_weights(&warp, direction);
  // f cos / weight.
  values[i] = (float4)(lobe_value(&warp, direction) * direction.z / fmax(weights.x, 1e-20f), weights.x, weights.y,
                       lobe_value(&warp, direction));
}
