// SPDX-License-Identifier: Apache-2.0
// Which voxels triangles touch (conservative, by separating axes: Akenine-Möller, "Fast 3D Triangle-Box Overlap
// Testing", 2001), and which bricks have such voxels. Fragments alone miss some (Hu et al. 2014 voxelise by them).
#include "lucarium/shared/scene_types.h"
#include "voxel_abuffer/structure/grid.clh"

#define ABUFFER_VOXEL_PAD 0.1f  // pixels: a ray that runs along a voxel's face finds what touches it from outside

// Whether the projections of a triangle (two of its corners will do, the third projects to one of them) and of a cube
// of half edge `half` around the origin are apart, along the cross product of an edge and a coordinate axis.
static bool abuffer_apart(float a, float b, float p_a, float p_b, float q_a, float q_b, float half_edge) {
  const float p = a * p_b - b * p_a, q = a * q_b - b * q_a, reach = half_edge * (fabs(a) + fabs(b));
  return fmin(p, q) > reach || fmax(p, q) < -reach;
}

static bool abuffer_touches(const float4* corners, float4 center, float half_edge) {
  const float4 p = corners[0] - center, q = corners[1] - center, r = corners[2] - center;
  const float4 pq = q - p, qr = r - q, rp = p - r;
  const float4 n = (float4)(cross(pq.xyz, qr.xyz), 0.0f), size = fabs(pq) + fabs(qr);
  const float length = size.x + size.y + size.z;
  // The normal's own rounding counts, too.
  if (fabs(dot(n.xyz, p.xyz)) > half_edge * (fabs(n.x) + fabs(n.y) + fabs(n.z)) + 1e-6f * length * length * length)
    return false;
  return !(abuffer_apart(pq.x, pq.y, p.x, p.y, r.x, r.y, half_edge) ||
           abuffer_apart(pq.y, pq.z, p.y, p.z, r.y, r.z, half_edge) ||
           abuffer_apart(pq.z, pq.x, p.z, p.x, r.z, r.x, half_edge) ||
           abuffer_apart(qr.x, qr.y, q.x, q.y, p.x, p.y, half_edge) ||
           abuffer_apart(qr.y, qr.z, q.y, q.z, p.y, p.z, half_edge) ||
           abuffer_apart(qr.z, qr.x, q.z, q.x, p.z, p.x, half_edge) ||
           abuffer_apart(rp.x, rp.y, r.x, r.y, q.x, q.y, half_edge) ||
           abuffer_apart(rp.y, rp.z, r.y, r.z, q.y, q.z, half_edge) ||
           abuffer_apart(rp.z, rp.x, r.z, r.x, q.z, q.x, half_edge));
}

static int4 abuffer_clamped_voxel(const AbufferGrid* grid, float4 position) {
  const float4 voxel = floor(position / (float)grid->voxels.w);
  return clamp(convert_int4(clamp(voxel, -1.0f, 8192.0f)), (int4)(0), convert_int4(grid->voxels) - 1);
}

__kernel void abuffer_mark_voxels(__global const AbufferGrid* abuffer_grid, __global const uchar* abuffer_classes,
                                  __global const float* abuffer_triangles, volatile __global uint* abuffer_voxels) {
  const uint i = get_global_id(0);
  const AbufferGrid grid = abuffer_grid[0];
  if (i >= grid.triangles) return;
  __global const float* words = abuffer_triangles + i * ABUFFER_TRIANGLE_WORDS;
  float4 p[3];
  for (uint k = 0u; k < 3u; ++k) p[k] = abuffer_position(&grid, (float4)(vload3(k, words), 0.0f));
  const float pad = ABUFFER_VOXEL_PAD + grid.slack, edge = (float)grid.voxels.w, half_edge = 0.5f * edge + pad;
  const float4 low = fmin(p[0], fmin(p[1], p[2])) - pad, high = fmax(p[0], fmax(p[1], p[2])) + pad;
  const float4 sum = low + high;
  if (!(fabs(sum.x) + fabs(sum.y) + fabs(sum.z) < 1e15f)) return;  // not finite, or beyond what rays can hit
  const int4 first = abuffer_clamped_voxel(&grid, low), last = abuffer_clamped_voxel(&grid, high);
  const uint bits = abuffer_classes[i];
  // Along one axis only it touches all that its bounds do.
  const int axes = (first.x != last.x) + (first.y != last.y) + (first.z != last.z);
  for (int z = first.z; z <= last.z; ++z)
    for (int y = first.y; y <= last.y; ++y)
      for (int x = first.x; x <= last.x; ++x) {
        const float4 center = ((float4)((float)x, (float)y, (float)z, 0.0f) + 0.5f) * edge;
        if (axes < 2 || abuffer_touches(p, center, half_edge))
          atomic_or(abuffer_voxels + abuffer_voxel(grid.bricks, (uint4)((uint)x, (uint)y, (uint)z, 0u)), bits);
      }
}

// A bit for each occupied voxel of a brick.
__kernel void abuffer_mark_bricks(__global const uint* abuffer_voxels, uint count, __global ulong* abuffer_bricks) {
  const uint brick = get_global_id(0);
  if (brick >= count) return;
  ulong bits = 0ul;
  for (uint i = 0u; i < 64u; ++i) bits |= (ulong)((abuffer_voxels[brick * 64u + i] & ABUFFER_OCCUPIED) != 0u) << i;
  abuffer_bricks[brick] = bits;
}
