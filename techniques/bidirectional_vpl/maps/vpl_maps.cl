// SPDX-License-Identifier: Apache-2.0
// Shadow maps of virtual point lights (Tokuyoshi and Ogaki 2012, section 4.1): five faces of a cube, all that lies
// before the light's surface, turned about its normal at random. A map serves every connection to its light, whatever
// the depth of the camera path.
#define LUCARIUM_JOINED
#include "bidirectional_vpl/maps/seen_maps.clh"
#include "lucarium/path_vertex.clh"
#include "lucarium/random.clh"

#define VPL_MAP_STREAM 0x76706c6du
#define VPL_FACES 5u

// Work-item k: the views of virtual light list[k]. places[its slot] = k.
__kernel void make_vpl_views(LUCARIUM_SCENE_PARAMETERS __global const PathVertex* restrict vertices,
                             __global const uint* restrict list, __global const uint* restrict count, uint side,
                             uint seed, uint sample_index, __global LayeredView* restrict views,
                             __global uint* restrict places) {
  const uint k = (uint)get_global_id(0);
  if (k >= count[0]) return;
  LUCARIUM_SCENE_BIND(scene);
  const PathVertex vertex = vertices[list[k]];
  places[list[k]] = k;
  const float3 normal = vertex.normal.xyz, eye = path_vertex_end(&vertex, normal);
  const float4 u = random_float4(seed ^ VPL_MAP_STREAM, sample_index, k);
  const Basis basis = make_basis(normal);
  float cosine;
  const float sine = sincos_turns(u.x, &cosine);
  const float3 t = cosine * basis.t + sine * basis.b, b = cosine * basis.b - sine * basis.t;
  const float2 depths = view_depths(&scene, eye);
  const uint view_seed = as_uint(u.y);
  __global LayeredView* v = views + VPL_FACES * k;
  v[0] = face_view(eye, normal, t, side, side, depths.x, depths.y, view_seed);
  // Upper halves: below lies the surface.
  v[1] = face_view(eye, t, -normal, side, side / 2u, depths.x, depths.y, view_seed);
  v[2] = face_view(eye, -t, -normal, side, side / 2u, depths.x, depths.y, view_seed);
  v[3] = face_view(eye, b, -normal, side, side / 2u, depths.x, depths.y, view_seed);
  v[4] = face_view(eye, -b, -normal, side, side / 2u, depths.x, depths.y, view_seed);
}

// Where a face's texels begin in its map.
uint face_start(uint face, uint side) { return face == 0u ? 0u : (face + 1u) * (side * side / 2u); }

// Keeps the triangles of view `number`, in a raster of side x side.
__kernel void keep_vpl_face(uint number, uint side, __global const uint* restrict seen,
                            __global uint* restrict triangles) {
  const uint i = (uint)get_global_id(0);
  if (i >= side * (number % VPL_FACES == 0u ? side : side / 2u)) return;
  const uint map = number / VPL_FACES;
  triangles[map * (3u * side * side) + face_start(number % VPL_FACES, side) + i] = kept_triangle(seen[i]);
}

// Shadow rays of connections, each from a surface to a virtual light: what lies before the light's surface is answered
// by its map, and the connection's light becomes black where something stands before the point. The others go to
// `traced`. w of connections[i]: connection_path() (connect.clh).
__kernel void test_vpl_maps(LUCARIUM_SCENE_PARAMETERS uint vertices_per_path,
                            __global const PathVertex* restrict vertices, __global const uint* restrict places,
                            uint side, __global const LayeredView* restrict views,
                            __global const uint* restrict triangles, __global const uint* restrict connection_paths,
                            __global const Hit* restrict hits, __global const uint* restrict active,
                            __global const Ray* restrict rays, __global Ray* restrict traced,
                            __global float4* restrict connections, uint slice_base) {
  const uint i = slice_base + (uint)get_global_id(0);
  if (i >= active[0]) return;
  LUCARIUM_SCENE_BIND(scene);
  const Ray ray = rays[i];
  if (!ray_is_active(ray)) {
    traced[i] = ray;
    return;
  }
  const uint slot = connection_paths[i] * vertices_per_path + (as_uint(connections[i].w) >> 16) - 1u;
  const PathVertex vertex = vertices[slot];
  const float3 direction = -ray.direction.xyz;
  if (dot(vertex.normal.xyz, direction) <= 0.0f) {
    traced[i] = ray;
    return;
  }
  traced[i] = inactive_ray();
  const uint map = places[slot];
  float2 place;
  const uint face = seen_face(views + VPL_FACES * map, VPL_FACES, direction, &place);
  const uint texel = face_start(face, side) + texel_at(views + VPL_FACES * map + face, place);
  const uint triangle = seen_triangle(triangles[map * (3u * side * side) + texel]);
  const float3 eye = path_vertex_end(&vertex, direction);
  if (stands_before(&scene, triangle, hits[i].triangle, eye, direction, ray.direction.w, 2.0f / (float)side))
    connections[i].xyz = (float3)(0.0f);
}
