// SPDX-License-Identifier: Apache-2.0
// Shadow maps of virtual point lights (Tokuyoshi and Ogaki 2012, section 4.1): five faces of a cube, all that lies
// before the light's surface, turned about its normal at random. A map serves every connection to its light, whatever
// the depth of the camera path.
#define LUCARIUM_JOINED
#include "bidirectional_vpl/maps/eight_looks.clh"
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

// Where a map's texels begin. All maps together may have more than 2^32.
size_t map_start(uint map, uint side) { return (size_t)map * (3u * side * side); }

// Where a face's texels begin in its map.
uint face_start(uint face, uint side) { return face == 0u ? 0u : (face + 1u) * (side * side / 2u); }

// Keeps the triangles of view `number`, in a raster of side x side.
__kernel void keep_vpl_face(uint number, uint side, __global const uint* restrict seen,
                            __global uint* restrict triangles) {
  const uint i = (uint)get_global_id(0);
  if (i >= side * (number % VPL_FACES == 0u ? side : side / 2u)) return;
  const uint map = number / VPL_FACES;
  triangles[map_start(map, side) + face_start(number % VPL_FACES, side) + i] = kept_triangle(seen[i]);
}

// Where no surface transmits light (VPL_MAPS_ALONE), maps answer all connections, as any-hit rays would: hidden[i] is
// whether something stands between. Else they answer what lies before the light's surface: the connection's light
// becomes black where something stands before the point, and other rays go to `traced`.
#ifdef VPL_MAPS_ALONE
#define VPL_ANSWERS __global uint *restrict hidden, __global float4 *restrict connections
#define VPL_ANSWERS_PASSED hidden, connections
#else
#define VPL_ANSWERS __global Ray *restrict traced, __global float4 *restrict connections
#define VPL_ANSWERS_PASSED traced, connections
#endif

// The slot of connection i's virtual light: of all of them where a launch is for one (VPL_MAPS_OF_ONE). w of
// connections[i]: connection_path() (connect.clh).
#ifdef VPL_MAPS_OF_ONE
#define VPL_LIGHT __global const uint *restrict list, uint number
#define VPL_SLOT(i) list[number]
#else
#define VPL_LIGHT uint vertices_per_path, __global const uint *restrict connection_paths
#define VPL_SLOT(i) (connection_paths[i] * vertices_per_path + (as_uint(connections[i].w) >> 16) - 1u)
#endif

// Shadow ray i of a connection, from a surface to the virtual light in `slot`.
LUCARIUM_JOIN void test_vpl_map(const Scene* scene, uint i, uint slot, __global const PathVertex* vertices,
                                __global const uint* places, uint side, __global const LayeredView* views,
                                __global const uint* triangles, __global const Hit* hits, __global const Ray* rays,
                                VPL_ANSWERS) {
  const Ray ray = rays[i];
  const PathVertex vertex = vertices[slot];
  const float3 direction = -ray.direction.xyz;
#ifndef VPL_MAPS_ALONE
  if (dot(vertex.normal.xyz, direction) <= 0.0f) {
    traced[i] = ray;
    return;
  }
  traced[i] = inactive_ray();
#endif
  const uint map = places[slot];
  float2 place;
  const uint face = seen_face(views + VPL_FACES * map, VPL_FACES, direction, &place);
  const uint texel = face_start(face, side) + texel_at(views + VPL_FACES * map + face, place);
  const uint triangle = seen_triangle(triangles[map_start(map, side) + texel]);
  const float3 eye = path_vertex_end(&vertex, vertex.normal.xyz);
  const bool dark =
      stands_before(scene, triangle, hits[i].triangle, eye, direction, ray.direction.w, 2.0f / (float)side);
#ifdef VPL_MAPS_ALONE
  hidden[i] = dark;
#else
  if (dark) connections[i].xyz = (float3)(0.0f);
#endif
}

// The same of those rays among the eight from `first` on whose bits are set, all of them to one virtual light.
LUCARIUM_JOIN void test_vpl_map8(const Scene* scene, uint first, uint active, uint slot,
                                 __global const PathVertex* vertices, __global const uint* places, uint side,
                                 __global const LayeredView* views, __global const uint* triangles,
                                 __global const Hit* hits, const Fields8* ray, __global const Ray* rays, VPL_ANSWERS) {
  const Vectors8 arriving = {ray->x, ray->y, ray->z}, direction = flipped8(arriving, (int8)(-1));
  const PathVertex vertex = vertices[slot];
#ifdef VPL_MAPS_ALONE
  const uint answered = active;
#else
  const uint answered = active & lane_bits8(dot8(spread8(vertex.normal.xyz), direction) > 0.0f);
  // Rays that are not traced have no length.
  __global float4* rows = (__global float4*)(traced + first);
  const float8 none = (float8)(0.0f);
  store_fields8(rows + 1, 2u, ~(active & ~answered) & 255u, none, none, (float8)(1.0f), (float8)(-1.0f));
  for (uint others = active & ~answered; others != 0u; others &= others - 1u)
    traced[first + lowest_bit8(others)] = rays[first + lowest_bit8(others)];
#endif
  const uint map = places[slot];
  const uint8 texel = seen_texels8(views + VPL_FACES * map, VPL_FACES, direction) & as_uint8(lanes_of_bits8(answered));
  const __global uint* texels = triangles + map_start(map, side);
  const uint8 triangle = LIST_OF_EIGHT(uint8, texels, texel) - 1u;
  const uint8 own = as_uint8(load_fields8((__global const float4*)(hits + first), 1u).y);
  const int8 asked = lanes_of_bits8(answered) & (triangle != LUCARIUM_NONE) & (triangle != own);
  int8 dark = (int8)(0);
  if (lane_bits8(asked) != 0u) {
    const float3 eye = path_vertex_end(&vertex, vertex.normal.xyz);
    dark = stand_before8(scene, asked, triangle, eye, direction, ray->w, 2.0f / (float)side);
  }
#ifdef VPL_MAPS_ALONE
  vstore8(as_uint8(dark) & 1u, 0, hidden + first);
#else
  for (uint left = lane_bits8(dark); left != 0u; left &= left - 1u)
    connections[first + lowest_bit8(left)].xyz = (float3)(0.0f);
#endif
}

// Rays that a later work-item reads, and the hits beside them.
void prefetch_connections(__global const Ray* rays, __global const Hit* hits, uint first, uint count) {
  const uint later = first + 96u;
  if (later + 8u > count) return;
  LUCARIUM_PREFETCH(rays + later);
  LUCARIUM_PREFETCH(rays + later + 2u);
  LUCARIUM_PREFETCH(rays + later + 4u);
  LUCARIUM_PREFETCH(rays + later + 6u);
  LUCARIUM_PREFETCH(hits + later);
  LUCARIUM_PREFETCH(hits + later + 4u);
}

// All shadow rays of connections, of which work-item i has eight from 8 i on.
__kernel void test_vpl_maps(LUCARIUM_SCENE_PARAMETERS VPL_LIGHT, __global const PathVertex* restrict vertices,
                            __global const uint* restrict places, uint side, __global const LayeredView* restrict views,
                            __global const uint* restrict triangles, __global const Hit* restrict hits,
                            __global const uint* restrict active, __global const Ray* restrict rays, VPL_ANSWERS,
                            uint slice_base) {
  const uint first = 8u * (slice_base + (uint)get_global_id(0)), count = active[0];
  if (first >= count) return;
  LUCARIUM_SCENE_BIND(scene);
  prefetch_connections(rays, hits, first, count);
  if (first + 8u <= count) {
    const Fields8 ray = load_fields8((__global const float4*)(rays + first) + 1, sizeof(Ray) / sizeof(float4));
    const uint left = lane_bits8(ray.w >= 0.0f);
    if (left == 0u) {
#ifndef VPL_MAPS_ALONE
      for (uint k = 0u; k < 8u; ++k) traced[first + k].direction.w = -1.0f;
#endif
      return;
    }
    const uint slot = VPL_SLOT(first + lowest_bit8(left));
    bool together = true;
#ifndef VPL_MAPS_OF_ONE
    for (uint rest = left & (left - 1u); rest != 0u; rest &= rest - 1u)
      together = together && VPL_SLOT(first + lowest_bit8(rest)) == slot;
#endif
    if (together) {
      test_vpl_map8(&scene, first, left, slot, vertices, places, side, views, triangles, hits, &ray, rays,
                    VPL_ANSWERS_PASSED);
      return;
    }
  }
  for (uint i = first; i < min(first + 8u, count); ++i) {
    if (ray_is_active(rays[i])) {
      test_vpl_map(&scene, i, VPL_SLOT(i), vertices, places, side, views, triangles, hits, rays, VPL_ANSWERS_PASSED);
      continue;
    }
#ifndef VPL_MAPS_ALONE
    traced[i].direction.w = -1.0f;
#endif
  }
}
