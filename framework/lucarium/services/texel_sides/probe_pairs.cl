// SPDX-License-Identifier: Apache-2.0
// Counts, for every part of every texel side, the rays of a bundle, those that meet backs, and those that soon meet
// something else; with SIDE_HALVES apart those that soon meet a surface that transmits.
#include "lucarium/math.clh"
#include "lucarium/services/texel_sides/bundle_sheets.clh"
#include "lucarium/services/texel_sides/side_parts.clh"

typedef struct Probe {
  const __global AtlasTriangle* atlas_triangles;
  const __global uint* atlas_table;
  __global uint* counts;
  uint double_sided;
  BundleSheets sheets;
  uint access_gap;  // shorter gaps are near, in steps of LAYERED_KEY_DEPTH
#ifdef SIDE_HALVES
  const __global AtlasMaterial* atlas_materials;
  __global uint* glass;  // of each part, near rays to what transmits
#endif
} Probe;

#define BUNDLE_PAIRS Probe
#include "lucarium/services/texel_sides/bundle_pairs.clh"

void bundle_expect(Probe* probe, uint texel) { LUCARIUM_PREFETCH(probe->counts + (size_t)texel * SIDE_PARTS); }

// See PROBE_RAYS; no more than it holds. near: what the ray meets within the gap is the side `other`, LUCARIUM_NONE: a
// back.
void count_ray(Probe* probe, FragmentSide end, bool near, bool back, uint other) {
  if (end.side == LUCARIUM_NONE) return;
  const size_t place = (size_t)end.side * SIDE_PARTS + end.part;
  __global uint* count = probe->counts + place;
  if (PROBE_RAYS(*count) >= PROBE_MAX) return;
#ifdef SIDE_HALVES
  if (near && !back && !is_black(probe->atlas_materials[other].transmission.xyz)) {
    near = false;
    probe->glass[place] += 1u;
  }
#endif
  *count += 1u | (uint)(near && !back) << 10u | (uint)back << 20u;
}

void layered_ray_begins(Probe* probe, uint2 pixel, uint payload, bool front) {
  count_ray(probe, fragment_side(probe, payload, front), false, false, LUCARIUM_NONE);
}

void layered_ray_crosses(Probe* probe, LayeredGap gap) {
  const FragmentSide near = fragment_side(probe, gap.near, gap.near_front);
  const FragmentSide far = fragment_side(probe, gap.far, gap.far_front);
  count_ray(probe, near, gap.length < probe->access_gap, far.side == LUCARIUM_NONE, far.side);
  count_ray(probe, far, gap.length < probe->access_gap, near.side == LUCARIUM_NONE, near.side);
}

void layered_ray_ends(Probe* probe, uint2 pixel, uint payload, bool front) {
  count_ray(probe, fragment_side(probe, payload, front), false, false, LUCARIUM_NONE);
}

#ifdef SIDE_HALVES
#define PROBE_GLASS_PARAMETERS __global const AtlasMaterial *atlas_materials, __global uint *glass,
#else
#define PROBE_GLASS_PARAMETERS
#endif

// access_gap [m].
__kernel void probe_pairs(LAYERED_TILE_PARAMETERS PROBE_GLASS_PARAMETERS AtlasInfo atlas_info,
                          __global const AtlasTriangle* atlas_triangles, __global const uint* atlas_table,
                          __global const SurfacePoint* atlas_points, float access_gap, __global uint* counts) {
  Probe probe;
  probe.atlas_triangles = atlas_triangles;
  probe.atlas_table = atlas_table;
  probe.counts = counts;
  probe.double_sided = atlas_info.double_sided_count;
  probe.sheets = bundle_sheets(atlas_points, layered_views + layered_view);
  probe.access_gap = (uint)(access_gap * layered_views[layered_view].depth_scale * 4194304.0f);
#ifdef SIDE_HALVES
  probe.atlas_materials = atlas_materials;
  probe.glass = glass;
#endif
  LAYERED_RUN_TILES(&probe);
}
