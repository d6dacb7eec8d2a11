// SPDX-License-Identifier: Apache-2.0
// Object space -> world space. World vertices and triangles lie in the order of instances, so each work-item finds its
// instance by bisection over the instances' first indices.
#include "lucarium/shared/scene_types.h"

// The last instance whose range starts at or before `index` (empty ranges are skipped by being not the last).
#define FIND_INSTANCE(name, member)                                                    \
  uint name(global const Instance* scene_instances, uint instance_count, uint index) { \
    uint low = 0, high = instance_count;                                               \
    while (high - low > 1) {                                                           \
      const uint middle = (low + high) / 2;                                            \
      if (scene_instances[middle].member <= index)                                     \
        low = middle;                                                                  \
      else                                                                             \
        high = middle;                                                                 \
    }                                                                                  \
    return low;                                                                        \
  }
FIND_INSTANCE(find_vertex_instance, world_vertex)
FIND_INSTANCE(find_triangle_instance, world_triangle)

float3 unit_or_zero(float3 v) {
  const float length2 = dot(v, v);
  return length2 > 0.f ? v * rsqrt(length2) : (float3)(0.f);
}

float3 multiply_rows(float4 row0, float4 row1, float4 row2, float3 v) {
  return (float3)(dot(row0.xyz, v), dot(row1.xyz, v), dot(row2.xyz, v));
}

// World vertices first .. first + count.
kernel __attribute__((reqd_work_group_size(64, 1, 1))) void transform_vertices(const uint first, const uint count,
                                                                               const uint instance_count,
                                                                               global const Instance* scene_instances,
                                                                               global const Vertex* scene_mesh_vertices,
                                                                               global Vertex* scene_vertices) {
  if (get_global_id(0) >= count) return;
  const uint index = first + (uint)get_global_id(0);
  const uint i = find_vertex_instance(scene_instances, instance_count, index);
  global const Instance* instance = scene_instances + i;
  Vertex v = scene_mesh_vertices[instance->mesh_vertex + (index - instance->world_vertex)];
  const float4 row0 = instance->row0, row1 = instance->row1, row2 = instance->row2;
  v.position.xyz = multiply_rows(row0, row1, row2, v.position.xyz) + (float3)(row0.w, row1.w, row2.w);
  v.normal.xyz = unit_or_zero(multiply_rows(instance->normal0, instance->normal1, instance->normal2, v.normal.xyz));
  // A reflection turns cross(normal, tangent) against the image of the bitangent.
  v.tangent.xyz = unit_or_zero(multiply_rows(row0, row1, row2, v.tangent.xyz));
  if (instance->flags & LUCARIUM_INSTANCE_FLIPPED) v.tangent.w = -v.tangent.w;
  scene_vertices[index] = v;
}

kernel __attribute__((reqd_work_group_size(64, 1, 1))) void derive_triangles(const uint triangle_count,
                                                                             const uint instance_count,
                                                                             global const Instance* scene_instances,
                                                                             global const uint4* scene_mesh_triangles,
                                                                             global Triangle* scene_triangles) {
  const uint index = (uint)get_global_id(0);
  if (index >= triangle_count) return;
  const uint i = find_triangle_instance(scene_instances, instance_count, index);
  global const Instance* instance = scene_instances + i;
  const uint4 corners = scene_mesh_triangles[instance->mesh_triangle + (index - instance->world_triangle)];
  const bool flipped = (instance->flags & LUCARIUM_INSTANCE_FLIPPED) != 0;
  Triangle t;
  t.v0 = instance->world_vertex + corners.x;
  t.v1 = instance->world_vertex + (flipped ? corners.z : corners.y);
  t.v2 = instance->world_vertex + (flipped ? corners.y : corners.z);
  t.instance = i;
  scene_triangles[index] = t;
}
