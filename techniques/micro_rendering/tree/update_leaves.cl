// SPDX-License-Identifier: Apache-2.0
// Leaf nodes from the scene's triangles (Ritschel et al. 2009, section 2.1, "Deforming and Moving Geometry"), and the
// lines that bound their discs.
#include "micro_rendering/tree/micro_node.clh"
#include "micro_rendering/tree/micro_surface.clh"

#define MICRO_CLIP_STEPS 32u  // directions over which the area of a bounded disc is summed up

float3 mesh_position(__global const Vertex* mesh_vertices, __global const Instance* instance, uint vertex) {
  return mesh_vertices[instance->mesh_vertex + (vertex - instance->world_vertex)].position.xyz;
}

// Lines that bound the disc of a leaf, in its plane: outward normals as angles, distances from the centre.
typedef struct LeafLines {
  float angle[MICRO_CLIPS], distance[MICRO_CLIPS];
  uint count;
} LeafLines;

// Area of what the lines leave of the disc of radius r, each moved outwards by `shift`: a mean over directions.
float kept_area(const LeafLines* lines, float r, float shift) {
  float sum = 0.0f;
  for (uint i = 0; i < MICRO_CLIP_STEPS; ++i) {
    float reach = r;
    for (uint k = 0; k < lines->count; ++k) {
      const float c = cos(((float)i + 0.5f) * (2.0f * M_PI_F / (float)MICRO_CLIP_STEPS) - lines->angle[k]);
      if (c > 0.0f) reach = fmin(reach, (lines->distance[k] + shift) / c);
    }
    sum += reach * reach;
  }
  return sum * (M_PI_F / (float)MICRO_CLIP_STEPS);
}

// The line through a and b, corners of a triangle that is wound about `front`, unless it is too far from c. Lines of
// neighbours count where the point of the edge that is nearest to c is on it, and c lies on their triangle's side.
void add_line(float3 c, float3 front, const Basis* basis, float r, float3 a, float3 b, bool own, LeafLines* lines) {
  const float3 edge = (b - a) - front * dot(b - a, front);
  const float length2 = dot(edge, edge);
  if (!(length2 > 0.0f)) return;
  const float3 outward = cross(edge, front) * rsqrt(length2);
  const float distance = dot(outward, a - c), along = dot(edge, c - a);
  if (distance >= r || (!own && (distance < 0.0f || along < 0.0f || along > length2))) return;
  lines->angle[lines->count] = atan2(dot(outward, basis->b), dot(outward, basis->t));
  lines->distance[lines->count++] = fmax(distance, 0.0f);
}

// Packs the lines; they leave of the disc at least the area that the leaf stands for, so that no holes open between
// discs on facets that are smaller.
uint4 pack_lines(const LeafLines* lines, float r, float min_area) {
  float shift = 0.0f;
  const float wanted = min_area * M_PI_F * r * r;
  if (kept_area(lines, r, 0.0f) < wanted) {
    float enough = r;
    for (uint i = 0; i < 12u; ++i) {
      const float middle = 0.5f * (shift + enough);
      if (kept_area(lines, r, middle) < wanted)
        shift = middle;
      else
        enough = middle;
    }
  }
  uint words[MICRO_CLIPS] = {0u, 0u, 0u, 0u};
  for (uint k = 0; k < lines->count; ++k) {
    const float distance = (lines->distance[k] + shift) / r;
    if (distance >= 1.0f) continue;
    const uint angle = (uint)(int)rint(lines->angle[k] * (65536.0f / (2.0f * M_PI_F))) & 0xffffu;
    words[k] = angle | ((1u + (uint)rint(distance * 65534.0f)) << 16);
  }
  return (uint4)(words[0], words[1], words[2], words[3]);
}

// Bounds a leaf's disc by the edges of its triangle. node: as packed, which is the disc that is drawn.
uint4 bound_disc(__global const Vertex* scene_vertices, __global const Vertex* mesh_vertices,
                 __global const Instance* instance, __global const MicroTree* tree, MicroNode node, bool back,
                 const TriangleEdges edges, const MicroLeafRules rules) {
  const float inverse_step = 1.0f / tree->origin_step.w;
  const Basis basis = make_basis(node.normal);
  LeafLines lines;
  lines.count = 0u;
  for (uint k = 0; k < MICRO_CLIPS && edges.ends[2 * k] != LUCARIUM_NONE; ++k) {
    float3 ends[2];
    for (uint e = 0; e < 2u; ++e) {
      const uint vertex = edges.ends[2 * k + e];
      const float3 p =
          rules.object_space ? mesh_position(mesh_vertices, instance, vertex) : scene_vertices[vertex].position.xyz;
      ends[e] = (p - tree->origin_step.xyz) * inverse_step;
    }
    add_line(node.center, back ? -node.normal : node.normal, &basis, node.radius, ends[0], ends[1], k < edges.own,
             &lines);
  }
  return lines.count > 0u ? pack_lines(&lines, node.radius, rules.min_area) : (uint4)(0u);
}

// The nearest of the lines that bound a leaf's disc, as nodes have it.
float4 nearest_line(uint4 clips, const MicroNode* node) {
  const uint words[MICRO_CLIPS] = {clips.x, clips.y, clips.z, clips.w};
  uint nearest = 0u;
  for (uint k = 0; k < MICRO_CLIPS; ++k)
    if (words[k] != 0u && (nearest == 0u || words[k] >> 16 < nearest >> 16)) nearest = words[k];
  if (nearest == 0u) return (float4)(0.0f);
  const Basis basis = make_basis(node->normal);
  const float angle = (float)(nearest & 0xffffu) * (2.0f * M_PI_F / 65536.0f);
  return (float4)(cos(angle) * basis.t + sin(angle) * basis.b,
                  node->radius * (float)((nearest >> 16) - 1u) * (1.0f / 65534.0f));
}

// Leaf nodes of one tree, from barycentric weights (Ritschel et al. 2009, section 2.1), and the lines that bound their
// discs.
__kernel void update_leaves(__global const Vertex* restrict scene_vertices,
                            __global const Vertex* restrict mesh_vertices,
                            __global const Triangle* restrict scene_triangles,
                            __global const Instance* restrict scene_instances,
                            __global const Material* restrict scene_materials,
                            __global const MicroLeaf* restrict leaves, __global const MicroTree* restrict trees,
                            const MicroLeafRules rules, uint count,
                            __global const TriangleEdges* restrict triangle_edges, __global uint4* restrict nodes,
                            __global uint4* restrict clips) {
  const uint i = get_global_id(0);
  if (i >= count) return;
  __global const MicroTree* tree = trees + rules.tree;
  const uint index = tree->first_node / 2u + i;
  const MicroLeaf leaf = leaves[index];
  const Triangle triangle = scene_triangles[leaf_triangle(leaf)];
  __global const Instance* instance = scene_instances + triangle.instance;
  // Find the triangle as it is now; a moving instance's tree is in object space, and only its matrix moves.
  float3 a, b, c;
  if (rules.object_space) {
    a = mesh_position(mesh_vertices, instance, triangle.v0);
    b = mesh_position(mesh_vertices, instance, triangle.v1);
    c = mesh_position(mesh_vertices, instance, triangle.v2);
  } else {
    a = scene_vertices[triangle.v0].position.xyz;
    b = scene_vertices[triangle.v1].position.xyz;
    c = scene_vertices[triangle.v2].position.xyz;
  }
  const float2 weights = leaf_weights(leaf);
  const float3 normal = cross(b - a, c - a);
  const float area = 0.5f * length(normal);
  const bool back = leaf.triangle & MICRO_LEAF_BACK;
  const bool two_sided = shows_both_sides(scene_materials[instance->material].flags);
  const bool cullable = two_sided || rules.all_cullable || leaf.triangle & MICRO_LEAF_SOLID;

  // Make the disc: its area grows as the triangle's does, which compensates for the points' changed density.
  MicroNode node;
  const float inverse_step = 1.0f / tree->origin_step.w;
  node.center = (a + weights.x * (b - a) + weights.y * (c - a) - tree->origin_step.xyz) * inverse_step;
  node.radius = rules.disc_radius * (leaf.area > 0.0f ? sqrt(area / leaf.area) : 1.0f) * inverse_step;
  node.normal = safe_normalize(back ? -normal : normal, (float3)(0.0f, 0.0f, 1.0f));
  node.cone = 0.0f;
  node.flags = (two_sided ? MICRO_NODE_TWIN : 0u) | (cullable ? MICRO_NODE_CULLABLE : 0u);
  node.side = MICRO_SIDE(triangle_edges[leaf_triangle(leaf)].sheet, back);
  node.line = (float4)(0.0f);

  // Bound the disc that is drawn, which is the packed one.
  uint4 packed = pack_node(node);
  node = unpack_node(packed);
  const uint4 lines =
      bound_disc(scene_vertices, mesh_vertices, instance, tree, node, back, triangle_edges[leaf_triangle(leaf)], rules);
  packed.w |= pack_line(nearest_line(lines, &node), node.radius);
  clips[index] = lines;
  nodes[tree->first_node + (1u << tree->depth) + i] = packed;
}
