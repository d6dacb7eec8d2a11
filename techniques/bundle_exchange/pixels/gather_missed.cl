// SPDX-License-Identifier: Apache-2.0
// Rays for the pixels that have not found their point in the bundle image (gather_pixels.cl).
#include "bundle_exchange/pixels/gather_light.clh"
#include "lucarium/scene.clh"
#include "lucarium/services/texel_sides/side_halves.clh"
#include "lucarium/shared/layered_raster.h"
#include "lucarium/shared/ray.h"
#include "lucarium/surface.clh"

// What the rays have found.
__kernel void gather_missed(LUCARIUM_SCENE_PARAMETERS AtlasInfo atlas_info,
                            __global const AtlasTriangle* restrict atlas_triangles,
                            __global const uint* restrict atlas_table, SIDE_HALVES_PARAMETERS uint count,
                            __global const LayeredView* restrict views, __global const float4* restrict ends,
                            __global const Ray* restrict rays, __global const Hit* restrict hits,
                            __global const float4* restrict shares, __global const float4* restrict records,
                            __global float4* restrict contribution) {
  const uint i = get_global_id(0);
  if (i >= count || !ray_is_active(rays[i])) return;
  LUCARIUM_SCENE_BIND(scene);
  const Hit hit = hits[i];
  const float3 in = rays[i].direction.xyz;
  // Find the texel side that the ray met, or the end of the bundle.
  uint side = LUCARIUM_NONE;
  float3 end = (float3)(0.0f);
  if (hit.triangle == LUCARIUM_NO_HIT) {
    end = dot(in, views[0].row_w.xyz) > 0.0f ? ends[1].xyz : ends[0].xyz;
  } else {
    const Surface surface = make_surface(&scene, hit, in, 0u);
    side = atlas_side(atlas_info, atlas_texel(atlas_triangles, atlas_table, hit.triangle, hit.u, hit.v),
                      surface.flags & LUCARIUM_SURFACE_FRONT);
    side += half_at(atlas_info, half_count, covered, atlas_triangles + hit.triangle, side, hit.u, hit.v);
  }
  gather_light(contribution, i, shares[i].xyz, records, side, end);
}
