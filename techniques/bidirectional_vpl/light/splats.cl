// SPDX-License-Identifier: Apache-2.0
// The strategy `splat`: light vertices connected to the camera, and sums of their light pixel by pixel in the order of
// the paths, so that they do not depend on threads.
#include "bidirectional_vpl/base/eye_directions.clh"
#include "bidirectional_vpl/shared/settings.h"
#include "lucarium/camera.clh"
#include "lucarium/lights.clh"
#include "lucarium/path_vertex.clh"
#include "lucarium/scene.clh"
#include "lucarium/sorted_keys.clh"

// One vertex from the second of its path on: its light in the pixel that sees it, weighted against all other
// strategies, and the ray to the camera. False where it is not seen.
bool aim_splat(const Scene* scene, const Frame* frame, BidirectionalSettings settings, const PathVertex* vertex,
               uint ray_seed, float3* light, uint* pixel, Ray* ray) {
  // Find the pixel.
  const CameraProjection seen = camera_project(frame, vertex->position.xyz);
  if (!(seen.density > 0.0f)) return false;
  const float2 film = seen.film, size = (float2)((float)frame->width, (float)frame->height);
  if (!(film.x >= 0.0f && film.y >= 0.0f && film.x < size.x && film.y < size.y)) return false;
  const uint2 at = convert_uint2(film);
  *pixel = at.y * frame->width + at.x;

  // Reflect towards the camera. One pixel's camera rays find the vertex with density p_eye.
  const Bsdf bsdf = path_vertex_bsdf(vertex), turned = turn_bsdf(&bsdf, seen.direction);
  if (bsdf_is_black(&turned)) return false;
  float back;
  const float3 value = eval_bsdf_eye_pdf(scene, &turned, bsdf.view, true, &back);
  const float p_eye = seen.density * fabs(dot(bsdf.n_g, seen.direction));
  *light = vertex->flux.xyz * value * p_eye;
  if (is_black(*light)) return false;
  *light *= medium_transmittance(scene, path_vertex_medium_towards(scene, vertex, seen.direction, LUCARIUM_NONE),
                                 seen.distance);
  *light /= 1.0f + path_mis_sum(path_vertex_mis(vertex), p_eye / settings.splat_samples, back);

  // Aim from the vertex to the camera.
  ray->origin = (float4)(path_vertex_end(vertex, seen.direction), as_float(ray_seed));
  ray->direction = (float4)(seen.direction, seen.distance);
  return true;
}

__kernel void aim_splats(LUCARIUM_SCENE_PARAMETERS Frame frame, const BidirectionalSettings settings, uint sample_index,
                         __global const PathVertex* restrict vertices, uint vertices_per_path,
                         LUCARIUM_RAY_ENDS_PARAMETER(ends) __global Ray* restrict rays,
                         __global float4* restrict splats, uint slice_base) {
  const uint i = slice_base + (uint)get_global_id(0);
  const uint per_path = vertices_per_path - 1u;
  if (i >= settings.light_paths * per_path) return;
  LUCARIUM_SCENE_BIND(scene);
  const uint slot = i / per_path * vertices_per_path + 1u + i % per_path;
  const PathVertex vertex = vertices[slot];
  Ray ray = inactive_ray();
  float3 light = (float3)(0.0f);
  uint pixel = LUCARIUM_NONE;
  const uint number = path_vertex_number(&vertex);
  if (number >= 2u && number <= settings.max_scatterings) {
    const uint seed = make_ray_seed(hash_uint3(frame.seed ^ 0x73706c61u, sample_index, slot));
    if (!aim_splat(&scene, &frame, settings, &vertex, seed, &light, &pixel, &ray)) {
      pixel = LUCARIUM_NONE;
      ray = inactive_ray();
    }
    RayEnds aimed = no_ray_ends();
    aimed.start = path_vertex_ray_end(&vertex, ray.direction.xyz);
    LUCARIUM_STORE_RAY_ENDS(ends, i, aimed);
  }
  rays[i] = ray;
  splats[i] = (float4)(light, as_float(pixel));
}

// Keys to sort by: the pixel, or NONE behind all pixels where there is nothing.
__kernel void key_splats(__global const float4* restrict splats, __global const uint* restrict occluded, uint count,
                         __global uint* restrict keys, __global uint* restrict values, uint slice_base) {
  const uint i = slice_base + (uint)get_global_id(0);
  if (i >= count) return;
  keys[i] = occluded[i] ? LUCARIUM_NONE : as_uint(splats[i].w);
  values[i] = i;
}

// counts[0]: rays that are traced, counts[1]: splats that nothing blocks.
__kernel void count_splats(__global const Ray* restrict rays, __global const uint* restrict keys, uint count,
                           uint chunk, __global uint* restrict counts) {
  const uint first = (uint)get_global_id(0) * chunk;
  if (first >= count) return;
  uint traced = 0u, seen = 0u;
  for (uint i = first; i < min(first + chunk, count); ++i) {
    traced += ray_is_active(rays[i]);
    seen += keys[i] != LUCARIUM_NONE;
  }
  if (traced) atomic_add(counts, traced);
  if (seen) atomic_add(counts + 1, seen);
}

// Adds each pixel's splats to its sample. One that is NaN, infinite or negative marks the pixel's camera path.
__kernel void sum_splats(const BidirectionalSettings settings, __global EyePathState* restrict states,
                         __global const float4* restrict splats, __global const uint* restrict keys,
                         __global const uint* restrict values, uint count, uint splat_layer,
                         __global float4* restrict sample, uint slice_base) {
  const uint pixel = slice_base + (uint)get_global_id(0);
  if (pixel >= settings.pixels) return;
  float3 sum = (float3)(0.0f);
  for (uint i = lower_key(keys, count, pixel); i < count && keys[i] == pixel; ++i) sum += splats[values[i]].xyz;
  if (is_black(sum)) return;
  if (!(all(sum >= 0.0f) && all(isfinite(sum)))) {
    states[pixel].flags |= EYE_PATH_BAD;
    return;
  }
  sample[BIDIRECTIONAL_INDIRECT * settings.pixels + pixel] += (float4)(sum, 0.0f);
  if (settings.flags & BIDIRECTIONAL_STRATEGIES) sample[splat_layer * settings.pixels + pixel] += (float4)(sum, 0.0f);
}
