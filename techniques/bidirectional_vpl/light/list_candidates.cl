// SPDX-License-Identifier: Apache-2.0
// Fills the table of candidates from the vertices that are there.
#include "bidirectional_vpl/light/candidates.clh"
#include "lucarium/scene.clh"

// Entry j: vertex list[j]; `count` is behind the list. Entries beyond the last block repeat the first ones.
__kernel void list_candidates(__global const PathVertex* restrict vertices, __global const uint* restrict list,
                              __global const uint* restrict count, uint capacity, __global float* restrict table,
                              uint slice_base) {
  const uint j = slice_base + (uint)get_global_id(0);
  const uint present = count[0], entries = candidate_entries(present);
  if (present == 0u || j >= entries + CANDIDATES_MAX + 8u || j >= capacity) return;
  const uint source = j % entries;
  if (source >= present) {
    for (uint row = 0u; row < CANDIDATE_ROWS; ++row) table[candidate_place(j, row)] = 0.0f;
    return;
  }
  const PathVertex vertex = vertices[list[source]];
  const Bsdf bsdf = path_vertex_bsdf(&vertex);
  const PathMis mis = path_vertex_mis(&vertex);
  const float cosine = fabs(dot(bsdf.n_s, bsdf.view));
  const float power = luminance(vertex.flux.xyz) * cosine * bsdf_reflected_share(&bsdf);
  table[candidate_place(j, CANDIDATE_X)] = vertex.position.x;
  table[candidate_place(j, CANDIDATE_Y)] = vertex.position.y;
  table[candidate_place(j, CANDIDATE_Z)] = vertex.position.z;
  table[candidate_place(j, CANDIDATE_NX)] = bsdf.n_g.x;
  table[candidate_place(j, CANDIDATE_NY)] = bsdf.n_g.y;
  table[candidate_place(j, CANDIDATE_NZ)] = bsdf.n_g.z;
  table[candidate_place(j, CANDIDATE_POWER)] = bsdf.p_transmit > 0.0f ? -power : power;
  table[candidate_place(j, CANDIDATE_MIS)] = mis.fixed + path_mis_power(cosine * M_1_PI_F) * mis.turning;
}
