// SPDX-License-Identifier: Apache-2.0
// Light samples of given luminances, of which every work-item keeps one.
#include "micro_rendering/tree/micro_dynamic.clh"

__kernel void keep_samples(__global const float* restrict luminances, uint samples, uint count,
                           __global MicroLeafLight* restrict lights) {
  const uint i = get_global_id(0);
  if (i >= count) return;
  lights[i].direction = lights[i].color = (float4)(0.0f);
  // The direction says which sample it was.
  for (uint k = 0; k < samples; ++k)
    keep_light_sample(lights + i, (float3)((float)k, 0.0f, 0.0f), (float3)(luminances[k]),
                      uint_to_unit(hash_uint2(i, k)));
}
