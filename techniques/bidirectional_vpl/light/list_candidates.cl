// SPDX-License-Identifier: Apache-2.0
// Fills the table of candidates from the vertices that are there.
#include "bidirectional_vpl/light/candidates.clh"
#include "lucarium/scene.clh"

// Entry j: vertex list[j mod count]; `count` is behind the list. Entries beyond the last vertex repeat the first ones.
__kernel void list_candidates(__global const PathVertex* restrict vertices, __global const uint* restrict list,
                              __global const uint* restrict count, uint capacity, __global float* restrict table,
                              uint slice_base) {
  const uint j = slice_base + (uint)get_global_id(0);
  const uint present = count[0];
  if (present == 0u || j >= present + CANDIDATES_MAX || j >= capacity) return;
  const PathVertex vertex = vertices[list[j % present]];
  const Bsdf bsdf = path_vertex_bsdf(&vertex);
  const PathMis mis = path_vertex_mis(&vertex);
  const float cosine = fabs(dot(bsdf.n_s, bsdf.view));
  const float power = luminance(vertex.flux.xyz) * cosine * bsdf_reflected_share(&bsdf);
  table[CANDIDATE_X * capacity + j] = vertex.position.x;
  table[CANDIDATE_Y * capacity + j] = vertex.position.y;
  table[CANDIDATE_Z * capacity + j] = vertex.position.z;
  table[CANDIDATE_NX * capacity + j] = bsdf.n_g.x;
  table[CANDIDATE_NY * capacity + j] = bsdf.n_g.y;
  table[CANDIDATE_NZ * capacity + j] = bsdf.n_g.z;
  table[CANDIDATE_POWER * capacity + j] = bsdf.p_transmit > 0.0f ? -power : power;
  table[CANDIDATE_MIS * capacity + j] = mis.fixed + path_mis_power(cosine * M_1_PI_F) * mis.turning;
}
