// SPDX-License-Identifier: Apache-2.0
// Cubes of what point and spot lights see: reflective shadow maps, from which light paths take their first surface
// (Tokuyoshi and Ogaki 2012, section 4.1; Dachsbacher and Stamminger 2005), and shadow maps for light samples, with
// percentage-closer filtering over 16 texels (Reeves et al. 1987). The cubes are turned at random in every iteration.
#include "bidirectional_vpl/maps/seen_maps.clh"
#include "lucarium/lights.clh"
#include "lucarium/shared/light_path.h"

#define LIGHT_MAP_STREAM 0x63756265u
#define CUBE_FACES 6u

// Work-item m: the views of the cube of light map_lights[m].
__kernel void make_cube_views(LUCARIUM_SCENE_PARAMETERS __global const uint* restrict map_lights, uint count, uint side,
                              uint seed, uint sample_index, __global LayeredView* restrict views) {
  const uint m = (uint)get_global_id(0);
  if (m >= count) return;
  LUCARIUM_SCENE_BIND(scene);
  const float3 eye = scene.scene_lights[map_lights[m]].position.xyz;
  const float4 u = random_float4(seed ^ LIGHT_MAP_STREAM, sample_index, m);
  const Basis basis = make_basis(sample_uniform_sphere(u.xy));
  float cosine;
  const float sine = sincos_turns(u.z, &cosine);
  const float3 axes[3] = {basis.n, cosine * basis.t + sine * basis.b, cosine * basis.b - sine * basis.t};
  const float2 depths = view_depths(&scene, eye);
  for (uint face = 0u; face < CUBE_FACES; ++face) {
    const float3 direction = face & 1u ? -axes[face >> 1] : axes[face >> 1];
    views[CUBE_FACES * m + face] =
        face_view(eye, direction, axes[((face >> 1) + 1u) % 3u], side, side, depths.x, depths.y, as_uint(u.w) + face);
  }
}

// Where a face's texels begin. Those of all lights together may be more than 2^32.
size_t cube_face_start(uint face, uint side) { return (size_t)face * (side * side); }

// Keeps the triangles of view `number`, in a raster of side x side.
__kernel void keep_cube_face(uint number, uint side, __global const uint* restrict seen,
                             __global uint* restrict triangles) {
  const uint i = (uint)get_global_id(0);
  if (i < side * side) triangles[cube_face_start(number, side) + i] = kept_triangle(seen[i]);
}

// The rays of light paths that a cube cannot answer: of other lights.
__kernel void rays_without_map(__global const LightPathState* restrict states, __global const uint* restrict places,
                               uint lights, __global const Ray* restrict rays, uint count,
                               __global Ray* restrict traced, uint slice_base) {
  const uint i = slice_base + (uint)get_global_id(0);
  if (i >= count) return;
  const uint light = states[i].light;
  traced[i] = light < lights && places[light] != LUCARIUM_NONE ? inactive_ray() : rays[i];
}

// What the others meet: the ray's point in the plane of the triangle that its texel shows, in the ray's own direction,
// so that the density p_e stays what it is.
__kernel void look_up_light_maps(LUCARIUM_SCENE_PARAMETERS __global const LightPathState* restrict states,
                                 __global const uint* restrict places, uint side,
                                 __global const LayeredView* restrict views, __global const uint* restrict triangles,
                                 __global const Ray* restrict rays, uint count, __global Hit* restrict hits,
                                 uint slice_base) {
  const uint i = slice_base + (uint)get_global_id(0);
  if (i >= count) return;
  LUCARIUM_SCENE_BIND(scene);
  const Ray ray = rays[i];
  const uint light = states[i].light;
  if (!ray_is_active(ray) || light >= scene.scene_info->light_count || places[light] == LUCARIUM_NONE) return;
  const uint first = CUBE_FACES * places[light];
  float2 place;
  const uint face = first + seen_face(views + first, CUBE_FACES, ray.direction.xyz, &place);
  const uint triangle = seen_triangle(triangles[cube_face_start(face, side) + texel_at(views + face, place)]);
  Hit hit = {INFINITY, LUCARIUM_NO_HIT, 0.0f, 0.0f};
  if (triangle != LUCARIUM_NONE) {
    const float3 met = meet_seen_triangle(&scene, triangle, ray.origin.xyz, ray.direction.xyz, 2.0f / (float)side);
    if (met.z > 0.0f) {
      const Hit found = {met.z, triangle, met.x, met.y};
      hit = found;
    }
  }
  hits[i] = hit;
}

// Shadow rays of light samples: those to lights with a cube are answered there, by the share of 4 x 4 texels about the
// direction that show nothing before the point, which their light is multiplied by. The others go to `traced`.
// light_numbers[i]: into scene_lights.
__kernel void test_light_maps(LUCARIUM_SCENE_PARAMETERS __global const uint* restrict places, uint side,
                              __global const LayeredView* restrict views, __global const uint* restrict triangles,
                              __global const uint* restrict light_numbers, __global const Hit* restrict hits,
                              __global const uint* restrict active, __global const Ray* restrict rays,
                              __global Ray* restrict traced, __global float4* restrict light, uint slice_base) {
  const uint i = slice_base + (uint)get_global_id(0);
  if (i >= active[0]) return;
  LUCARIUM_SCENE_BIND(scene);
  const Ray ray = rays[i];
  traced[i] = ray;
  if (!ray_is_active(ray) || places[light_numbers[i]] == LUCARIUM_NONE) return;
  traced[i] = inactive_ray();
  const uint first = CUBE_FACES * places[light_numbers[i]];
  const float3 eye = scene.scene_lights[light_numbers[i]].position.xyz, direction = -ray.direction.xyz;
  float2 place;
  const uint face = first + seen_face(views + first, CUBE_FACES, direction, &place);
  uint hidden = 0u;
  for (uint tap = 0u; tap < 16u; ++tap) {
    const float2 beside = place + (float2)((float)(tap & 3u), (float)(tap >> 2)) - 1.5f;
    const uint triangle = seen_triangle(triangles[cube_face_start(face, side) + texel_at(views + face, beside)]);
    hidden += stands_before(&scene, triangle, hits[i].triangle, eye, direction, ray.direction.w, 6.0f / (float)side);
  }
  light[i].xyz *= 1.0f - (float)hidden / 16.0f;
}
