// SPDX-License-Identifier: Apache-2.0
// What of a slot lies hidden inside other solids. A point is hidden when every ray that leaves it meets the back of a
// single-sided surface: backs neither send nor receive, so that no light ever comes to the point or goes from it.
#include "bundle_exchange/texels/slot_points.clh"
#include "lucarium/surface_atlas.clh"
#include "lucarium/warp.clh"

#define PROBE_SEED 0x70726f62u
#define STATE_BACKS 0xffu  // of a state: rays that met backs, of the first PROBE_COMMON rounds
#define STATE_SEES 0x100u  // of a state: some ray met something else, or nothing
#define PROBE_COMMON 8u    // rounds that all points of a slot take part in while one of them met nothing but backs

// A chunk of points begins: point i is point i % SLOT_POINTS of slot first + i / SLOT_POINTS.
__kernel void begin_probes(uint count, __global uint* restrict states, __global uint* restrict wanted,
                           __global uint* restrict total) {
  const uint i = get_global_id(0);
  if (i == 0u) total[0] = count;
  if (i >= count) return;
  states[i] = 0u;
  wanted[i] = 1u;
}

// One cosine-distributed ray from each listed point.
__kernel void aim_probes(LUCARIUM_SCENE_PARAMETERS AtlasInfo atlas_info,
                         __global const AtlasSample* restrict atlas_samples, uint first, uint turn,
                         __global const uint* restrict list, __global const uint* restrict active,
                         __global Ray* restrict rays) {
  const uint j = get_global_id(0);
  if (j >= active[0]) return;
  LUCARIUM_SCENE_BIND(scene);
  const uint point = first * SLOT_POINTS + list[j];
  const Surface surface = slot_surface(&scene, atlas_info, point / SLOT_POINTS, atlas_samples[point]);
  const float4 u = random_float4(PROBE_SEED, point, turn);
  const Basis basis = make_basis(surface.n_g);
  rays[j] = make_ray(&surface, to_world(&basis, sample_cosine_hemisphere(u.xy)), make_ray_seed(as_uint(u.z)));
}

__kernel void judge_probes(LUCARIUM_SCENE_PARAMETERS AtlasInfo atlas_info,
                           __global const AtlasTriangle* restrict atlas_triangles,
                           __global const uint* restrict atlas_table, uint turn, __global const uint* restrict list,
                           __global const uint* restrict active, __global const Ray* restrict rays,
                           __global const Hit* restrict hits, __global uint* restrict states) {
  const uint j = get_global_id(0);
  if (j >= active[0]) return;
  LUCARIUM_SCENE_BIND(scene);
  const Hit hit = hits[j];
  bool back = false;
  if (hit.triangle != LUCARIUM_NO_HIT) {
    const Surface surface = make_surface(&scene, hit, rays[j].direction.xyz, 0u);
    const uint texel = atlas_texel(atlas_triangles, atlas_table, hit.triangle, hit.u, hit.v);
    back = atlas_side(atlas_info, texel, surface.flags & LUCARIUM_SURFACE_FRONT) == LUCARIUM_NONE;
  }
  if (!back)
    states[list[j]] |= STATE_SEES;
  else if (turn < PROBE_COMMON)
    states[list[j]] += 1u;
}

// Which points take part in the round after `turn`: those that met nothing but backs, and in the first rounds their
// neighbours too, for what share of backs is to be expected of a point that is not hidden.
__kernel void choose_probes(uint slots, uint turn, __global const uint* restrict states,
                            __global uint* restrict wanted) {
  const uint slot = get_global_id(0);
  if (slot >= slots) return;
  uint doubtful = 0u;
  for (uint k = 0u; k < SLOT_POINTS; ++k) doubtful += !(states[slot * SLOT_POINTS + k] & STATE_SEES);
  const bool joined = doubtful > 0u && turn + 1u < PROBE_COMMON;
  for (uint k = 0u; k < SLOT_POINTS; ++k)
    wanted[slot * SLOT_POINTS + k] = joined || !(states[slot * SLOT_POINTS + k] & STATE_SEES);
}

// exposure: x share of the slot's area that is not hidden, y share of its rays that meet backs which come from there
// (1 where nothing is hidden). hidden: a bit per point.
__kernel void finish_probes(uint first, uint slots, __global const uint* restrict states,
                            __global float2* restrict exposure, __global uint* restrict hidden) {
  const uint i = get_global_id(0);
  if (i >= slots) return;
  uint bits = 0u, backs = 0u;
  for (uint k = 0u; k < SLOT_POINTS; ++k) {
    const uint state = states[i * SLOT_POINTS + k];
    if (state & STATE_SEES)
      backs += state & STATE_BACKS;
    else
      bits |= 1u << k;
  }
  const uint lost = popcount(bits);
  // Of rays from all over the slot, lost / SLOT_POINTS meet backs since they begin in hidden places, and so do others.
  const float from_exposed = (float)backs / (float)PROBE_COMMON;
  exposure[first + i] =
      (float2)(1.0f - (float)lost / (float)SLOT_POINTS, lost > 0u ? from_exposed / (from_exposed + (float)lost) : 1.0f);
  hidden[first + i] = bits;
}
