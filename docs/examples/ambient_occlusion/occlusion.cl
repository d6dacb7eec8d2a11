// SPDX-License-Identifier: Apache-2.0
// One ray per pixel over the hemisphere of what the pixel sees, and the sum of those that met nothing.
#include "lucarium/gbuffer.clh"
#include "lucarium/scene.clh"
#include "lucarium/services/layer_sums/layer_sums.clh"
#include "lucarium/sobol.clh"
#include "lucarium/warp.clh"

// Apart from all other uses of the same seed.
#define OCCLUSION_STREAM 0x616f6363u

// rays: of length `reach` [m]; inactive where the pixel sees no surface.
__kernel void generate_occlusion_rays(LUCARIUM_SCENE_PARAMETERS __global const GBufferPoint* restrict points,
                                      uint count, uint sample_index, uint seed, float reach,
                                      __global Ray* restrict rays) {
  const uint i = (uint)get_global_id(0);
  if (i >= count) return;
  rays[i] = inactive_ray();
  const GBufferPoint point = points[i];
  if (point.state != LUCARIUM_GBUFFER_SURFACE) return;

  // Choose a direction with density cos/pi about the geometric normal.
  const Sampler sampler = make_sampler(i, OCCLUSION_STREAM, seed, sample_index, LUCARIUM_SAMPLER_SOBOL);
  const Basis basis = make_basis(point.normal.xyz);
  const float3 direction =
      to_world(&basis, sample_cosine_hemisphere(sample_direction_dimensions(&sampler, 0u).direction));

  // Leave the triangle without meeting it again.
  LUCARIUM_SCENE_BIND(scene);
  const Surface surface = gbuffer_surface(&scene, point);
  rays[i] = make_ray(&surface, direction, make_ray_seed(hash_uint2(sampler.seed, sample_index)));
  rays[i].direction.w = reach;
}

// open: sums per pixel; xyz rays that met nothing, w all rays. A pixel without a surface is open.
__kernel void add_open_rays(uint count, __global const uint* restrict occluded, __global float4* restrict open) {
  const uint i = (uint)get_global_id(0);
  if (i < count) open[i] = add_sample(open[i], (float3)(occluded[i] ? 0.0f : 1.0f));
}
