// SPDX-License-Identifier: Apache-2.0
// Inner nodes from their children: spheres that contain spheres, cones that contain cones. O(n), so that the hierarchy
// follows every deformation (Ritschel et al. 2009, section 2.1, "Deforming and Moving Geometry").
#include "micro_rendering/tree/micro_node.clh"

#define MICRO_MIN_SHOWN 64.0f  // a quarter of 255: of a convex solid, the mean over all directions (Cauchy)

// The smallest sphere about both (Ritschel et al. 2009, section 2.1).
void merge_spheres(const MicroNode* a, const MicroNode* b, MicroNode* sum) {
  const float3 between = b->center - a->center;
  const float d = length(between);
  sum->center = a->center;
  sum->radius = a->radius;
  if (d + b->radius <= a->radius) return;
  sum->center = b->center;
  sum->radius = b->radius;
  if (d + a->radius <= b->radius) return;
  sum->radius = 0.5f * (d + a->radius + b->radius);
  sum->center = a->center + between * ((sum->radius - a->radius) / d);
}

// The narrowest cone of normals about both (section 2.1).
void merge_cones(const MicroNode* a, const MicroNode* b, MicroNode* sum) {
  const float angle = angle_between(a->normal, b->normal);
  sum->normal = a->normal;
  sum->cone = a->cone;
  if (angle + b->cone <= a->cone) return;
  sum->normal = b->normal;
  sum->cone = b->cone;
  if (angle + a->cone <= b->cone) return;
  const float half_angle = 0.5f * (angle + a->cone + b->cone);
  // Opposite axes have no direction between them.
  sum->normal = a->normal;
  sum->cone = M_PI_F;
  if (half_angle >= M_PI_F || angle > 3.1414f) return;
  const float3 side = normalize(b->normal - a->normal * dot(a->normal, b->normal));
  const float turn = half_angle - a->cone;
  sum->normal = angle > 1e-5f ? normalize(cos(turn) * a->normal + sin(turn) * side) : a->normal;
  sum->cone = half_angle + (angle > 1e-5f ? 0.0f : angle);
}

// leaves: both are leaves.
uint4 merge_nodes(uint4 left, uint4 right, bool leaves) {
  const MicroNode a = unpack_node(left), b = unpack_node(right);
  MicroNode sum;
  merge_spheres(&a, &b, &sum);
  merge_cones(&a, &b, &sum);
  // Project the areas that the children show onto the common axis; leaves show all of theirs.
  const float shown_a = leaves ? 1.0f : (float)a.side / 255.0f, shown_b = leaves ? 1.0f : (float)b.side / 255.0f;
  const float shown = 0.5f * dot(shown_a * a.normal + shown_b * b.normal, sum.normal);
  sum.side = (uint)clamp(ceil(shown * 255.0f), MICRO_MIN_SHOWN, 255.0f);
  sum.flags = (a.flags & b.flags & MICRO_NODE_CULLABLE) | ((a.flags | b.flags) & MICRO_NODE_TWIN);
  return pack_node(sum);
}

// Inner nodes of levels [top, bottom) of one tree; level `bottom` is done. Work-item w owns what lies below node w of
// level `top`.
__kernel void refit_nodes(__global const MicroTree* restrict trees, uint tree, uint top, uint bottom,
                          __global uint4* restrict nodes) {
  const uint w = get_global_id(0);
  if (w >= (1u << top)) return;
  __global uint4* heap = nodes + trees[tree].first_node;
  for (uint level = bottom; level-- > top;) {
    const uint first = ((1u << top) + w) << (level - top), end = first + (1u << (level - top));
    for (uint i = first; i < end; ++i)
      heap[i] = merge_nodes(heap[2u * i], heap[2u * i + 1u], level + 1u == trees[tree].depth);
  }
}
