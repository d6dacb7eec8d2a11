// SPDX-License-Identifier: Apache-2.0
// What rays of trees have met: a point to be lit, what it emits, and the rays that go on from there.
//
// Straight on (ray casting, Hu et al. 2014, section 4): a surface of alpha a is seen with the share T a, and T (1 - a)
// is left behind it. Branching (Whitted 1980; reflection and refraction rays of section 4): both ideal lobes of
// a surface are followed, weighted by Fresnel's factor.
#include "lucarium/lights.clh"
#include "lucarium/medium.clh"
#include "lucarium/scene.clh"
#include "lucarium/services/gbuffer/keep_surface.clh"
#include "voxel_abuffer/shared/tree_ray.h"

GBufferPoint no_point(void) {
  GBufferPoint point;
  point.position = point.normal = point.shading = point.view = (float4)(0.0f);
  point.throughput = point.emission = point.albedo = (float4)(0.0f);
  point.u = point.v = 0.0f;
  point.triangle = LUCARIUM_NONE;
  point.state = LUCARIUM_GBUFFER_MISS;
  return point;
}

// A ray that goes on, if anything of it arrives.
typedef struct Branch {
  Ray ray;
  RayEnds ends;
  TreeRay tree_ray;
  bool exists;
} Branch;

Branch no_branch(TreeRay tree_ray) {
  Branch branch;
  branch.ray = inactive_ray();
  branch.ends = no_ray_ends();
  branch.tree_ray = tree_ray;
  branch.exists = false;
  return branch;
}

Branch branch_along(const Surface* surface, float3 direction, uint seed, float3 throughput, TreeRay tree_ray) {
  Branch branch = no_branch(tree_ray);
  if (is_black(throughput) || !all(isfinite(throughput))) return branch;
  branch.ray = make_ray(surface, direction, seed);
  branch.ends = ray_ends(surface, direction);
  branch.tree_ray.throughput.xyz = throughput;
  branch.exists = true;
  return branch;
}

// One of the two ideal lobes.
Branch branch_at_lobe(const Scene* scene, const Surface* surface, const Bsdf* bsdf, bool transmit, float3 throughput,
                      uint medium, uint seed, TreeRay tree_ray) {
  const uint lobe = transmit ? LUCARIUM_BSDF_DELTA_TRANSMISSION : LUCARIUM_BSDF_DELTA_REFLECTION;
  const float p = transmit ? bsdf->p_transmit : bsdf->p_reflect;
  if (!(bsdf->flags & lobe) || !(p > 0.0f)) return no_branch(tree_ray);
  const BsdfSample sample = sample_ideal_lobe(bsdf, transmit);
  tree_ray.medium = transmit ? medium_behind(scene, surface, medium) : medium;
  return branch_along(surface, sample.direction, seed, throughput * sample.weight * p, tree_ray);
}

// Work-item i: ray i of the chunk. points: one for each of the chunk's places, a miss where there is no ray. The rays
// that go on, if there are any, get the places 2 i and 2 i + 1.
__kernel void shade_tree_rays(LUCARIUM_SCENE_PARAMETERS TreeRules rules, uint places, __global const Ray* restrict rays,
                              __global const Hit* restrict hits, __global const TreeRay* restrict tree_rays,
                              LUCARIUM_RAY_ENDS_PARAMETER(next_ends) __global GBufferPoint* restrict points,
                              __global Ray* restrict next_rays, __global TreeRay* restrict next_tree_rays,
                              __global uint* restrict goes_on) {
  const uint i = get_global_id(0);
  if (i >= places) return;
  GBufferPoint point = no_point();
  if (i >= rules.count) {
    points[i] = point;
    return;
  }
  LUCARIUM_SCENE_BIND(scene);
  const Hit hit = hits[i];
  const TreeRay tree_ray = tree_rays[i];
  const float3 direction = rays[i].direction.xyz;
  const uint seed = as_uint(rays[i].origin.w);
  float3 throughput = tree_ray.throughput.xyz;
  Branch branches[2] = {no_branch(tree_ray), no_branch(tree_ray)};
  if (hit.triangle == LUCARIUM_NO_HIT) {
    // Behind all surfaces is the environment.
    if (scene.scene_info->environment_light != LUCARIUM_NONE)
      point.emission.xyz = throughput * environment_radiance(&scene, direction);
  } else {
    const Surface surface = make_surface(&scene, hit, direction, 0u);
    const uint medium = medium_at(&scene, &surface, tree_ray.medium);
    const Bsdf bsdf = make_bsdf(&scene, &surface, 0u);
    if (rules.straight) {
      // Ray casting: see alpha of the surface, through all before it, and leave the rest to the ray behind it.
      const float alpha = coverage_at(&scene, hit.triangle, hit.u, hit.v);
      TreeRay behind = tree_ray;
      behind.throughput.w += hit.distance;
      branches[0] = branch_along(&surface, direction, seed, throughput * (1.0f - alpha), behind);
      throughput *= alpha * medium_transmittance(&scene, medium, behind.throughput.w);
    } else {
      // Whitted: follow both ideal lobes.
      throughput *= medium_transmittance(&scene, medium, hit.distance);
      for (uint lobe = 0u; lobe < 2u && rules.level < rules.last_level; ++lobe)
        branches[lobe] =
            branch_at_lobe(&scene, &surface, &bsdf, lobe == 1u, throughput, medium,
                           make_ray_seed(hash_uint3(seed, tree_ray.pixel, 2u * rules.level + lobe)), tree_ray);
    }
    // Keep the point for direct light, with what it emits.
    point.throughput.xyz = throughput;
    point.emission.xyz = throughput * emitted_radiance(&scene, &surface);
    keep_surface(&scene, &surface, &bsdf, hit, medium, 1.0f, &point);
  }
  points[i] = point;
  // Put the rays that go on where they are compacted from.
  for (uint lobe = 0u; lobe < 2u; ++lobe) {
    const uint place = 2u * i + lobe;
    next_rays[place] = branches[lobe].ray;
    next_tree_rays[place] = branches[lobe].tree_ray;
    LUCARIUM_STORE_RAY_ENDS(next_ends, place, branches[lobe].ends);
    goes_on[place] = branches[lobe].exists;
  }
}
