// SPDX-License-Identifier: Apache-2.0
// Collects the light vertices that ideal surfaces have lit, and puts them into the order in which they are looked up
// (Jensen 1995, "Importance Driven Path Tracing using the Photon Map").
#include "bidirectional_vpl/guide/guide_key.clh"
#include "lucarium/path_vertex.clh"

// Of lobes: narrower ones would be spikes, wider ones no better than the BSDF.
#define GUIDE_MIN_WIDTH 1e-3f
#define GUIDE_MAX_WIDTH 0.5f
#define GUIDE_NARROW 0.15f  // a fiftieth of what a diffuse surface sends out goes there

// Marks caustics. What ideal surfaces pass on of light that others have scattered comes from so many directions that
// camera paths find it without a guide.
__kernel void mark_guide_vertices(__global const PathVertex* restrict vertices, uint count,
                                  __global uint* restrict present, uint slice_base) {
  const uint i = slice_base + (uint)get_global_id(0);
  if (i >= count) return;
  const PathVertex vertex = vertices[i];
  present[i] = path_vertex_number(&vertex) != 0u && (as_uint(vertex.view.w) & PATH_VERTEX_CAUSTIC) != 0u;
}

// Appends those of the list to the photons, in its order. stored[0]: how many there are.
__kernel void take_guide_photons(__global const PathVertex* restrict vertices, __global const uint* restrict list,
                                 __global const uint* restrict listed, __global const uint* restrict stored,
                                 __global GuidePhoton* restrict photons, uint slice_base) {
  const uint i = slice_base + (uint)get_global_id(0), place = stored[0] + i;
  if (i >= listed[0] || place >= BIDIRECTIONAL_GUIDE_PHOTONS) return;
  const PathVertex vertex = vertices[list[i]];
  photons[place].position = (float4)(vertex.position.xyz, 0.0f);
  photons[place].direction = (float4)(vertex.view.xyz, 0.0f);
}

// The first work-item, alone.
__kernel void count_guide_photons(__global const uint* restrict listed, __global uint* restrict stored) {
  if (get_global_id(0) == 0u) stored[0] = min(stored[0] + listed[0], BIDIRECTIONAL_GUIDE_PHOTONS);
}

// Keys to sort by, behind which places without a photon come.
__kernel void key_guide_photons(LUCARIUM_SCENE_PARAMETERS __global const GuidePhoton* restrict photons,
                                __global const uint* restrict stored, __global uint* restrict keys,
                                __global uint* restrict values, uint slice_base) {
  const uint i = slice_base + (uint)get_global_id(0);
  if (i >= BIDIRECTIONAL_GUIDE_PHOTONS) return;
  LUCARIUM_SCENE_BIND(scene);
  keys[i] = i < stored[0] ? guide_key(&scene, photons[i].position.xyz) : BIDIRECTIONAL_GUIDE_NO_KEY;
  values[i] = i;
}

// The third smallest so far.
void keep_third(float* least, float x) {
  if (x < least[0]) {
    least[2] = least[1];
    least[1] = least[0];
    least[0] = x;
  } else if (x < least[1]) {
    least[2] = least[1];
    least[1] = x;
  } else if (x < least[2]) {
    least[2] = x;
  }
}

// Puts photons into their order, with their lobes: as wide as directions differ among neighbours, so that lobes cover a
// lamp's image between photons. ordered_count[0]: how many there are; none where they fill no window. narrow[0] counts
// those of lobes so narrow that camera paths hardly find their light by chance.
__kernel void order_guide_photons(__global const GuidePhoton* restrict photons, __global const uint* restrict stored,
                                  __global const uint* restrict values, __global GuidePhoton* restrict ordered,
                                  __global uint* restrict ordered_count, __global uint* restrict narrow,
                                  uint slice_base) {
  const uint i = slice_base + (uint)get_global_id(0);
  const uint count = stored[0];
  if (i == 0u) ordered_count[0] = count >= BIDIRECTIONAL_GUIDE_WINDOW ? count : 0u;
  if (i >= count || count < BIDIRECTIONAL_GUIDE_WINDOW) return;
  const GuidePhoton own = photons[values[i]];
  const uint first = guide_window_first(i, count);
  float nearest[3] = {INFINITY, INFINITY, INFINITY}, likest[3] = {INFINITY, INFINITY, INFINITY};
  for (uint k = first; k < first + BIDIRECTIONAL_GUIDE_WINDOW; ++k) {
    if (k == i) continue;
    const GuidePhoton other = photons[values[k]];
    const float3 apart = other.position.xyz - own.position.xyz, turned = other.direction.xyz - own.direction.xyz;
    keep_third(nearest, dot(apart, apart));
    keep_third(likest, dot(turned, turned));
  }
  const float width = clamp(sqrt(likest[2]), GUIDE_MIN_WIDTH, GUIDE_MAX_WIDTH);
  ordered[i].position = (float4)(own.position.xyz, sqrt(nearest[2]));
  ordered[i].direction = (float4)(own.direction.xyz, width);
  if (width < GUIDE_NARROW) atomic_inc(narrow);
}
