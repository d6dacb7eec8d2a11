// SPDX-License-Identifier: Apache-2.0
// Caches of indirect light (Tokuyoshi and Ogaki 2012, section 6 and supplement): one of four sub-pixels is computed in
// a frame, the others take what their caches hold, found by reverse reprojection (Nehab et al. 2007): the surface point
// goes back to where it was in the frame before, by barycentrics in the vertices of then, and from there to the pixel
// that saw it.
#include "bidirectional_vpl/shared/cached_pixel.h"
#include "lucarium/camera.clh"
#include "lucarium/math.clh"
#include "lucarium/scene.clh"
#include "lucarium/shared/gbuffer.h"

// The next frame: vertices that were present are those before. At first (`begin`) there is none before.
__kernel void advance_positions(__global const Vertex* restrict scene_vertices, uint count, uint begin,
                                __global float4* restrict present, __global float4* restrict positions,
                                uint slice_base) {
  const uint i = slice_base + (uint)get_global_id(0);
  if (i >= count) return;
  positions[i] = begin ? scene_vertices[i].position : present[i];
  present[i] = scene_vertices[i].position;
}

// The next frame: what is kept is read, and nothing is kept yet.
__kernel void advance_caches(uint count, uint begin, __global CachedPixel* restrict kept,
                             __global CachedPixel* restrict caches, uint slice_base) {
  const uint i = slice_base + (uint)get_global_id(0);
  if (i >= count) return;
  CachedPixel none;
  none.position = none.normal = none.light = (float4)(0.0f);
  caches[i] = begin ? none : kept[i];
  kept[i] = none;
}

// The cached sub-pixel that shows a point, LUCARIUM_NONE where none does. `before`: the frame before.
uint find_cached(__global const Triangle* triangles, __global const float4* positions, const Frame* before,
                 __global const CachedPixel* caches, const __global GBufferPoint* point) {
  if (point->state != LUCARIUM_GBUFFER_SURFACE || point->throughput.w > 0.0f) return LUCARIUM_NONE;
  // Where it was.
  const Triangle triangle = triangles[point->triangle];
  const float3 a = positions[triangle.v0].xyz, ab = positions[triangle.v1].xyz - a, ac = positions[triangle.v2].xyz - a;
  const float3 was = a + point->u * ab + point->v * ac;
  const float3 normal = safe_normalize(cross(ab, ac), (float3)(0.0f));
  // Who saw it: the same depth within two pixels' edges across its plane, and the same normal.
  const CameraProjection seen = camera_project(before, was);
  if (!(seen.density > 0.0f) || !(seen.film.x >= 0.0f && seen.film.y >= 0.0f)) return LUCARIUM_NONE;
  if (!(seen.film.x < (float)before->width && seen.film.y < (float)before->height)) return LUCARIUM_NONE;
  const uint found = (uint)seen.film.y * before->width + (uint)seen.film.x;
  const CachedPixel cached = caches[found];
  if (cached.position.w == 0.0f || !(cached.light.w > 0.0f)) return LUCARIUM_NONE;
  const float footprint = rsqrt(seen.density);
  const bool agrees =
      fabs(dot(cached.normal.xyz, normal)) > 0.9f && fabs(dot(cached.position.xyz - was, normal)) < 2.0f * footprint;
  return agrees ? found : LUCARIUM_NONE;
}

// reused[pixel]: the light of its sub-pixel's cache; w: 1, or 0 where it has to be computed. caches: of the frame
// before, of this sub-pixel.
__kernel void reproject_caches(__global const Triangle* restrict scene_triangles,
                               __global const float4* restrict positions, Frame before,
                               __global const CachedPixel* restrict caches, uint first, uint computed,
                               __global const GBufferPoint* restrict points, __global float4* restrict reused,
                               uint slice_base) {
  const uint pixel = slice_base + (uint)get_global_id(0);
  if (pixel >= before.width * before.height) return;
  reused[pixel] = (float4)(0.0f);
  if (computed) return;
  const uint found = find_cached(scene_triangles, positions, &before, caches + first, points + pixel);
  if (found == LUCARIUM_NONE) return;
  const float4 light = caches[first + found].light;
  reused[pixel] = (float4)(light.xyz / light.w, 1.0f);
}

// Puts reused light in place of the sample's, and keeps what the sub-pixel has now.
__kernel void keep_in_caches(__global const GBufferPoint* restrict points, __global const float4* restrict reused,
                             uint first, uint layer, uint pixels, __global float4* restrict sample,
                             __global CachedPixel* restrict kept) {
  const uint pixel = (uint)get_global_id(0);
  if (pixel >= pixels) return;
  const uint at = layer * pixels + pixel;
  if (reused[pixel].w > 0.0f) sample[at] = (float4)(reused[pixel].xyz, 0.0f);
  const __global GBufferPoint* point = points + pixel;
  const bool usable = point->state == LUCARIUM_GBUFFER_SURFACE && point->throughput.w == 0.0f;
  kept[first + pixel].position = (float4)(point->position.xyz, usable ? 1.0f : 0.0f);
  kept[first + pixel].normal = (float4)(point->normal.xyz, 0.0f);
  kept[first + pixel].light += (float4)(sample[at].xyz, 1.0f);
}
