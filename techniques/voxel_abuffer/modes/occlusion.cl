// SPDX-License-Identifier: Apache-2.0
// Ambient occlusion of what pixels see (Zhukov, Iones and Kronin 1998, with a step as falloff; Hu et al. 2014, section
// 4).
#include "lucarium/gbuffer.clh"
#include "lucarium/scene.clh"
#include "lucarium/sobol.clh"
#include "lucarium/warp.clh"

// Apart from all other uses of the same seed.
#define OCCLUSION_STREAM 0x616d6f63u

// A ray over the hemisphere of every pixel's point, its direction with density cos / pi. rays: of length `reach` [m];
// inactive where the pixel sees no surface.
__kernel void begin_occlusion_rays(LUCARIUM_SCENE_PARAMETERS __global const GBufferPoint* restrict points, uint count,
                                   uint sample_index, uint seed, float reach,
                                   LUCARIUM_RAY_ENDS_PARAMETER(ends) __global Ray* restrict rays) {
  const uint i = get_global_id(0);
  if (i >= count) return;
  rays[i] = inactive_ray();
  const GBufferPoint point = points[i];
  if (point.state != LUCARIUM_GBUFFER_SURFACE) return;
  LUCARIUM_SCENE_BIND(scene);
  const Surface surface = gbuffer_surface(&scene, point);
  const Sampler sampler = make_sampler(i, OCCLUSION_STREAM, seed, sample_index, LUCARIUM_SAMPLER_SOBOL);
  const Basis basis = make_basis(surface.n_g);
  const float3 direction =
      to_world(&basis, sample_cosine_hemisphere(sample_direction_dimensions(&sampler, 0u).direction));
  Ray ray = make_ray(&surface, direction, make_ray_seed(hash_uint2(sampler.seed, sample_index)));
  ray.direction.w = reach;
  rays[i] = ray;
  LUCARIUM_STORE_RAY_ENDS(ends, i, ray_ends(&surface, direction));
}

// pass: rays of every pixel that met nothing, xyz. A pixel that sees no surface is open.
__kernel void add_open_rays(uint count, __global const uint* restrict occluded, __global float4* restrict pass) {
  const uint i = get_global_id(0);
  if (i < count) pass[i].xyz += occluded[i] ? 0.0f : 1.0f;
}
