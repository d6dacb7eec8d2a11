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

// ---- lines

#define MICRO_LINE_CONE 0.5f   // half angle of normals [rad]; a line bounds the disc of a node that is flat
#define MICRO_LINE_REACH 0.8f  // how far a node's surface reaches at least, in radii of a disc of the area it shows

// The plane at which the surface of both ends, by the line of `a`: xyz normal, w its distance from the origin.
// INFINITY: there is none, or the surface of b, of that area and no such line, goes on beyond it.
float4 shared_line(const MicroNode* a, const MicroNode* b, float area_b) {
  const float3 m = a->line.xyz;
  const float end = dot(m, a->center) + a->line.w, size = sqrt(area_b * M_1_PI_F);
  if (dot(m, m) == 0.0f) return (float4)(0.0f, 0.0f, 0.0f, INFINITY);
  // Of lines that hardly differ the outer one bounds both.
  if (dot(m, b->line.xyz) > 0.98f) return (float4)(m, fmax(end, dot(m, b->center + b->line.w * b->line.xyz)));
  const float tilt = fmin(acos(clamp(fabs(dot(m, b->normal)), 0.0f, 1.0f)) + b->cone, 0.5f * M_PI_F);
  const float end_b = dot(m, b->center) + MICRO_LINE_REACH * size * sin(tilt);
  return (float4)(m, end_b > end + 0.1f * size ? INFINITY : fmax(end, end_b));
}

// Areas are those that the children show.
void merge_lines(const MicroNode* a, const MicroNode* b, float area_a, float area_b, MicroNode* sum) {
  const float4 line_a = shared_line(a, b, area_b), line_b = shared_line(b, a, area_a);
  const float reach_a = line_a.w - dot(line_a.xyz, sum->center), reach_b = line_b.w - dot(line_b.xyz, sum->center);
  sum->line = (float4)(0.0f);
  if (sum->cone > MICRO_LINE_CONE) return;
  if (reach_a < sum->radius) sum->line = (float4)(line_a.xyz, reach_a);
  if (reach_b < sum->radius && reach_b < reach_a) sum->line = (float4)(line_b.xyz, reach_b);
}

// leaves: both are leaves; area: of the surface of each.
uint4 merge_nodes(uint4 left, uint4 right, bool leaves, float area) {
  const MicroNode a = unpack_node(left), b = unpack_node(right);
  MicroNode sum;
  merge_spheres(&a, &b, &sum);
  merge_cones(&a, &b, &sum);
  // Project the areas that the children show onto the common axis; leaves show all of theirs.
  const float shown_a = leaves ? 1.0f : (float)a.side / 255.0f, shown_b = leaves ? 1.0f : (float)b.side / 255.0f;
  const float shown = 0.5f * dot(shown_a * a.normal + shown_b * b.normal, sum.normal);
  sum.side = (uint)clamp(ceil(shown * 255.0f), MICRO_MIN_SHOWN, 255.0f);
  sum.flags = (a.flags & b.flags & MICRO_NODE_CULLABLE) | ((a.flags | b.flags) & MICRO_NODE_TWIN);
  merge_lines(&a, &b, area * shown_a, area * shown_b, &sum);
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
    const uint above = trees[tree].depth - level - 1u;
    const float area = trees[tree].leaf_area * (float)(1u << above);
    for (uint i = first; i < end; ++i) heap[i] = merge_nodes(heap[2u * i], heap[2u * i + 1u], above == 0u, area);
  }
}
