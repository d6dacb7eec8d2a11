// SPDX-License-Identifier: Apache-2.0
// Light of a chunk's rays, summed over their pixels.
#include "lucarium/shared/gbuffer.h"
#include "voxel_abuffer/shared/tree_ray.h"

// Rays of one pixel stand next to each other; the first of them adds all, in their order, so that no order of
// work-items shows. ambient: radiance of constant light from everywhere [cd/m^2].
__kernel void add_tree_light(TreeRules rules, float ambient, __global const TreeRay* restrict tree_rays,
                             __global const GBufferPoint* restrict points, __global const float4* restrict lit,
                             __global float4* restrict emission, __global float4* restrict direct,
                             __global float4* restrict ambient_light, __global float4* restrict crossings) {
  const uint i = get_global_id(0);
  if (i >= rules.count) return;
  const uint pixel = tree_rays[i].pixel;
  if (i > 0u && tree_rays[i - 1u].pixel == pixel) return;
  float4 emitted = emission[pixel], reflected = direct[pixel], constant_light = ambient_light[pixel],
         crossed = crossings[pixel];
  for (uint k = i; k < rules.count && tree_rays[k].pixel == pixel; ++k) {
    const GBufferPoint point = points[k];
    emitted.xyz += point.emission.xyz;
    reflected.xyz += lit[k].xyz;
    if (point.state != LUCARIUM_GBUFFER_SURFACE) continue;
    constant_light.xyz += ambient * point.throughput.xyz * point.albedo.xyz;
    crossed.xyz += 1.0f;
  }
  emission[pixel] = emitted;
  direct[pixel] = reflected;
  ambient_light[pixel] = constant_light;
  crossings[pixel] = crossed;
}
