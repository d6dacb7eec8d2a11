// SPDX-License-Identifier: Apache-2.0
// Which point, spot and directional lights the texel sides of facets see: what their rough lobes reflect of them is
// added to the first scattering (scatter_cells.cl). A bit for each light.
#include "lucarium/atlas_surface.clh"
#include "lucarium/random.clh"
#include "lucarium/scene.clh"
#include "lucarium/shared/surface_point.h"
#include "virtual_light_field/scatter/punctual_light.clh"

// Work-item: a texel side; a ray to light `light`, inactive where the side has no facet.
__kernel void aim_at_light(LUCARIUM_SCENE_PARAMETERS AtlasInfo atlas_info,
                           __global const SurfacePoint* restrict atlas_points, __global const uint* restrict side_facet,
                           uint sides, uint light, uint seed,
                           LUCARIUM_RAY_ENDS_PARAMETER(ends) __global Ray* restrict rays) {
  const uint side = get_global_id(0);
  if (side >= sides) return;
  Ray ray = inactive_ray();
  RayEnds own_ends = no_ray_ends();
  if (side_facet[side] != LUCARIUM_NONE) {
    LUCARIUM_SCENE_BIND(scene);
    const SurfacePoint point = atlas_points[side];
    const Surface surface = atlas_surface(&scene, atlas_info, side, point.triangle, point.u, point.v);
    const LightSample sample = punctual_light(&scene, light, surface.position);
    if (sample.pdf > 0.0f && !is_black(sample.radiance)) {
      ray = make_shadow_ray(&surface, &sample, make_ray_seed(hash_uint3(seed, side, light)));
      own_ends = shadow_ray_ends(&surface, &sample);
    }
  }
  rays[side] = ray;
  LUCARIUM_STORE_RAY_ENDS(ends, side, own_ends);
  (void)own_ends;  // where intersectors want no ends
}

// bit: of the light in `visible`.
__kernel void see_light(uint sides, uint bit, __global const Ray* restrict rays, __global const uint* restrict occluded,
                        __global uint* restrict visible) {
  const uint side = get_global_id(0);
  if (side >= sides) return;
  const bool seen = ray_is_active(rays[side]) && !occluded[side];
  visible[side] = (visible[side] & ~(1u << bit)) | (uint)seen << bit;
}
