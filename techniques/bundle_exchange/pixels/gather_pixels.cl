// SPDX-License-Identifier: Apache-2.0
// The final glossy bounce of Hermes et al. 2010, section 5.3: the last reflection towards the eye from the bundle
// itself. A pixel's point is looked up in the fragments of the bundle image, and reflects what its neighbour along the
// bundle sends. All pixels share the directions of the bundles.
#include "bundle_exchange/base/fragment_side.clh"
#include "bundle_exchange/pixels/gather_light.clh"
#include "bundle_exchange/specular/pixel_lobes.clh"
#include "lucarium/bsdf.clh"
#include "lucarium/gbuffer.clh"
#include "lucarium/shared/ray.h"

// Work-item i: pixel i. Equation 3 with the pixel's own f_r towards the eye (ω_{i+1} = ω_o). What is not found in its
// bundle pixel gets a ray. first: 1 where contributions begin at 0. shares: xyz share of the light that reaches the
// eye.
__kernel void gather_pixels(LUCARIUM_SCENE_PARAMETERS AtlasInfo atlas_info,
                            __global const AtlasTriangle* restrict atlas_triangles,
                            __global const uint* restrict atlas_table,
                            SIDE_HALVES_PARAMETERS __global const GBufferPoint* restrict points, uint count, uint whole,
                            float min_alpha, uint first, float weight, __global const LayeredView* restrict views,
                            __global const uint* restrict pixel_start,
                            __global const LayeredFragment* restrict fragments, __global const float4* restrict ends,
                            __global const float4* restrict records, __global float4* restrict contribution,
                            __global Ray* restrict rays, __global float4* restrict shares) {
  const uint i = get_global_id(0);
  if (i >= count) return;
  LUCARIUM_SCENE_BIND(scene);
  if (first) contribution[2u * i] = contribution[2u * i + 1u] = (float4)(0.0f);
  Ray ray = inactive_ray();
  const GBufferPoint point = points[i];
  if (point.state == LUCARIUM_GBUFFER_SURFACE) {
    const Surface surface = gbuffer_surface(&scene, point);
    const Bsdf full = make_bsdf(&scene, &surface, 0u), bsdf = bundle_part(full, whole, min_alpha);
    const float3 omega = views[0].row_w.xyz, in = dot(surface.n_g, omega) > 0.0f ? omega : -omega;
    // Weight what comes along the bundle by lobe, cosine and W; the cosine is explicit, as every pixel has one sample.
    const float3 share = point.throughput.xyz * eval_bsdf(&bsdf, in) * weight;
    if (!is_black(share)) {
      // Find the pixel's point among the fragments, and what faces it along the bundle.
      const FragmentList list = {views, pixel_start, fragments};
      const ListedPoint place =
          listed_point(&list, surface.position, point.triangle, surface.n_g, surface.flags & LUCARIUM_SURFACE_FRONT);
      const SeenFragment seen = seen_fragment(&list, &place, false);
      const uint side =
          seen_half(&scene, atlas_info, atlas_triangles, atlas_table, half_count, covered, &list, &place, seen);
      const float3 end = dot(in, omega) > 0.0f ? ends[1].xyz : ends[0].xyz;
      if (seen.found)
        gather_light(contribution, i, share, records, side, seen.fragment == LUCARIUM_NONE ? end : (float3)(0.0f));
      else
        ray = make_ray(&surface, in, make_ray_seed(hash_uint2(views[0].seed, i)));
      shares[i] = (float4)(share, 0.0f);
    }
  }
  rays[i] = ray;
}
