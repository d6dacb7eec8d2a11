// SPDX-License-Identifier: Apache-2.0
// Rays of a chunk: from the camera, or from a level's queue.
#include "lucarium/camera.clh"
#include "lucarium/ray_ends.clh"
#include "lucarium/services/gbuffer/gbuffer_sampler.clh"
#include "voxel_abuffer/shared/tree_ray.h"

// counts: rays, and places for those that go on.
__kernel void begin_camera_rays(Frame frame, TreeRules rules,
                                LUCARIUM_RAY_ENDS_PARAMETER(ends) __global Ray* restrict rays,
                                __global TreeRay* restrict tree_rays, __global uint* restrict counts) {
  const uint i = get_global_id(0);
  if (i == 0u) {
    counts[0] = rules.count;
    counts[1] = 2u * rules.count;
  }
  if (i >= rules.count) return;
  const uint pixel = rules.first + i;
  const Sampler sampler = make_pixel_sampler(frame.seed, pixel, rules.sample_index);
  const CameraSample u = sample_camera_dimensions(&sampler);
  // Rays that go straight on meet every BLEND surface, and weigh it by its alpha.
  const uint seed = rules.straight ? LUCARIUM_SEED_OPAQUE
                                   : make_ray_seed(hash_uint3(sampler.seed, rules.sample_index, LUCARIUM_NONE));
  rays[i] = primary_ray(&frame, pixel % frame.width, pixel / frame.width, rules.sample_index, u.film, seed);
  LUCARIUM_STORE_RAY_ENDS(ends, i, no_ray_ends());
  TreeRay tree_ray;
  tree_ray.throughput = (float4)(1.0f, 1.0f, 1.0f, 0.0f);
  tree_ray.pixel = pixel;
  tree_ray.medium = LUCARIUM_NONE;
  tree_ray.pad0 = tree_ray.pad1 = 0u;
  tree_rays[i] = tree_ray;
}

__kernel void load_rays(TreeRules rules, __global const Ray* restrict queued_rays,
                        __global const TreeRay* restrict queued_tree_rays,
                        LUCARIUM_CONST_RAY_ENDS_PARAMETER(queued_ends) LUCARIUM_RAY_ENDS_PARAMETER(ends)
                            __global Ray* restrict rays,
                        __global TreeRay* restrict tree_rays, __global uint* restrict counts) {
  const uint i = get_global_id(0);
  if (i == 0u) {
    counts[0] = rules.count;
    counts[1] = 2u * rules.count;
  }
  if (i >= rules.count) return;
  const uint place = rules.first + i;
  rays[i] = queued_rays[place];
  tree_rays[i] = queued_tree_rays[place];
  LUCARIUM_STORE_RAY_ENDS(ends, i, queued_ends[place]);
}

// The rays that go on, in their order, at the place of the next level's queue.
__kernel void queue_rays(TreeRules rules, __global const uint* restrict survivors,
                         __global const uint* restrict survivor_count, __global const Ray* restrict next_rays,
                         __global const TreeRay* restrict next_tree_rays,
                         LUCARIUM_CONST_RAY_ENDS_PARAMETER(next_ends) LUCARIUM_RAY_ENDS_PARAMETER(queued_ends)
                             __global Ray* restrict queued_rays,
                         __global TreeRay* restrict queued_tree_rays) {
  const uint i = get_global_id(0);
  if (i >= survivor_count[0]) return;
  const uint from = survivors[i], place = rules.target + i;
  queued_rays[place] = next_rays[from];
  queued_tree_rays[place] = next_tree_rays[from];
  LUCARIUM_STORE_RAY_ENDS(queued_ends, place, next_ends[from]);
}
