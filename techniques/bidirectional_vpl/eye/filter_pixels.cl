// SPDX-License-Identifier: Apache-2.0
// Means over a window of pixels that see the same surface (Tokuyoshi and Ogaki 2012, section 6, filter).
#include "lucarium/camera.clh"
#include "lucarium/math.clh"
#include "lucarium/shared/gbuffer.h"

// Edge length of a pixel at a point [m].
float pixel_footprint(const Frame* frame, const __global GBufferPoint* point) {
  const float per_pixel = camera_ray_density(frame, -point->view.xyz);
  return rsqrt(per_pixel) * (film_plane(frame).orthographic ? 1.0f : point->position.w);
}

// What light is divided by before it is mixed: the reflectance of the surface, and what mirrors before it leave.
float3 pixel_modulation(const __global GBufferPoint* point) {
  return fmax(point->albedo.xyz * point->throughput.xyz, 1e-3f);
}

bool same_surface(const __global GBufferPoint* p, const __global GBufferPoint* q, float footprint) {
  return q->state == LUCARIUM_GBUFFER_SURFACE && p->throughput.w == q->throughput.w &&
         fabs(dot(p->shading.xyz, q->shading.xyz)) > 0.9f &&
         fabs(dot(q->position.xyz - p->position.xyz, p->normal.xyz)) < 2.0f * footprint;
}

// filtered[pixel]: the mean of `sums` over the window of side^2 pixels about it; w: 1.
__kernel void filter_pixels(Frame frame, __global const GBufferPoint* restrict points, uint side,
                            __global const float4* restrict sums, __global float4* restrict filtered, uint slice_base) {
  const uint pixel = slice_base + (uint)get_global_id(0);
  if (pixel >= frame.width * frame.height) return;
  const __global GBufferPoint* point = points + pixel;
  if (point->state != LUCARIUM_GBUFFER_SURFACE) {
    filtered[pixel] = sums[pixel] / fmax(sums[pixel].w, 1.0f);
    return;
  }
  const int x0 = (int)(pixel % frame.width) - (int)((side - 1u) / 2u),
            y0 = (int)(pixel / frame.width) - (int)((side - 1u) / 2u);
  const float footprint = pixel_footprint(&frame, point);
  // Light of all over reflectance of all: a lamp in a ceiling has none, and nothing is divided by that.
  float3 light = (float3)(0.0f), modulation = (float3)(0.0f);
  for (int y = max(y0, 0); y < min(y0 + (int)side, (int)frame.height); ++y) {
    for (int x = max(x0, 0); x < min(x0 + (int)side, (int)frame.width); ++x) {
      const uint other = (uint)y * frame.width + (uint)x;
      if (!same_surface(point, points + other, footprint)) continue;
      light += sums[other].xyz;
      modulation += sums[other].w * pixel_modulation(points + other);
    }
  }
  filtered[pixel] = (float4)(modulation.x > 0.0f ? light / modulation * pixel_modulation(point) : 0.0f, 1.0f);
}
