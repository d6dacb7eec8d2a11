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
  __global uint* glass;  // of each part, very near rays to what transmits
  uint glass_gap;        // as access_gap, below which they are
#endif
} Probe;

#define BUNDLE_PAIRS Probe
#include "lucarium/services/texel_sides/bundle_pairs.clh"

void bundle_expect(Probe* probe, uint texel) { LUCARIUM_PREFETCH(probe->counts + (size_t)texel * SIDE_PARTS); }

#define PROBE_FREE UINT_MAX  // length of the gap of a ray that meets nothing more

// See PROBE_RAYS; no more than it holds. length: of the gap, in steps of LAYERED_KEY_DEPTH, behind which the ray meets
// the side `other`; LUCARIUM_NONE: a back. After PROBE_FREE any other value will do: it is not looked at.
void count_ray(Probe* probe, FragmentSide end, uint length, uint other) {
  if (end.side == LUCARIUM_NONE) return;
  const bool back = other == LUCARIUM_NONE;
  bool near = length < probe->access_gap;
  const size_t place = (size_t)end.side * SIDE_PARTS + end.part;
  __global uint* count = probe->counts + place;
  if (PROBE_RAYS(*count) >= PROBE_MAX) return;
#ifdef SIDE_HALVES
  if (near && !back && !is_black(probe->atlas_materials[other].transmission.xyz)) {
    near = false;
    if (length < probe->glass_gap) probe->glass[place] += 1u;
  }
#endif
  *count += 1u | (uint)(near && !back) << 10u | (uint)back << 20u;
}

void layered_ray_begins(Probe* probe, uint2 pixel, uint payload, bool front) {
  count_ray(probe, fragment_side(probe, payload, front), PROBE_FREE, 0u);
}

void layered_ray_crosses(Probe* probe, LayeredGap gap) {
  const FragmentSide near = fragment_side(probe, gap.near, gap.near_front);
  const FragmentSide far = fragment_side(probe, gap.far, gap.far_front);
  count_ray(probe, near, gap.length, far.side);
  count_ray(probe, far, gap.length, near.side);
}

void layered_ray_ends(Probe* probe, uint2 pixel, uint payload, bool front) {
  count_ray(probe, fragment_side(probe, payload, front), PROBE_FREE, 0u);
}

#ifdef SIDE_HALVES
#define PROBE_GLASS_PARAMETERS __global const AtlasMaterial *atlas_materials, __global uint *glass, float glass_gap,
#else
#define PROBE_GLASS_PARAMETERS
#endif

// access_gap, glass_gap [m].
__kernel void probe_pairs(LAYERED_TILE_PARAMETERS PROBE_GLASS_PARAMETERS AtlasInfo atlas_info,
                          __global const AtlasTriangle* atlas_triangles, __global const uint* atlas_table,
                          __global const SurfacePoint* atlas_points, float access_gap, __global uint* counts) {
  Probe probe;
  probe.atlas_triangles = atlas_triangles;
  probe.atlas_table = atlas_table;
  probe.counts = counts;
  probe.double_sided = atlas_info.double_sided_count;
  probe.sheets = bundle_sheets(atlas_points, layered_views + layered_view);
  const float steps = layered_views[layered_view].depth_scale * 4194304.0f;
  probe.access_gap = (uint)(access_gap * steps);
#ifdef SIDE_HALVES
  probe.atlas_materials = atlas_materials;
  probe.glass = glass;
  probe.glass_gap = (uint)(glass_gap * steps);
#endif
  LAYERED_RUN_TILES(&probe);
}
