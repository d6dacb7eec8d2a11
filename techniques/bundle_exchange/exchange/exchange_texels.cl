// SPDX-License-Identifier: Apache-2.0
// The exchange as in the paper (Hermes et al. 2010, section 4.2, figure 5): every texel side's own point is projected
// into the bundle image, finds itself among the fragments of its pixel (self-localization), and takes what the
// neighbour, its opposite sampling point, sends. One ray per texel side and direction, weighted by its cosine, however
// many bundle pixels the texel side covers.
#include "bundle_exchange/base/exchange_layout.clh"
#include "bundle_exchange/base/fragment_side.clh"
#include "lucarium/atlas_surface.clh"
#include "lucarium/random.clh"
#include "lucarium/services/texel_sides/side_parts.clh"
#include "lucarium/shared/surface_point.h"

// Moves a texel side's sample position to a random one within its texel, on the same triangle; where that misses, it
// stays.
AtlasTexel jitter_texel(const __global AtlasTriangle* atlas_triangles, const __global uint* atlas_table,
                        AtlasTexel texel, uint front_side, float2 u) {
  const AtlasTriangle t = atlas_triangles[texel.triangle];
  const float2 e1 = (float2)(t.u1 - t.u0, t.v1 - t.v0), e2 = (float2)(t.u2 - t.u0, t.v2 - t.v0);
  const float area = e1.x * e2.y - e1.y * e2.x;
  if (LUCARIUM_ATLAS_PITCH(t) == 0u || area == 0.0f) return texel;
  const float2 d = floor(atlas_uv(t, texel.b1, texel.b2)) + u - (float2)(t.u0, t.v0);
  const float b1 = (d.x * e2.y - d.y * e2.x) / area, b2 = (e1.x * d.y - e1.y * d.x) / area;
  if (!(b1 >= 0.0f && b2 >= 0.0f && b1 + b2 <= 1.0f)) return texel;
  if (atlas_texel(atlas_triangles, atlas_table, texel.triangle, b1, b2) != front_side) return texel;
  texel.b1 = b1;
  texel.b2 = b2;
  return texel;
}

// Equation 3 term by term: weight W = 1/p, cosθ of the receiver's normal; f_r follows when the texel side sends
// (make_senders()). weight: W. ends: radiance that enters along omega (the view's direction), and along -omega. Of the
// records, what texel sides send is read, and each work-item adds to its own sums.
__kernel void exchange_texels(LUCARIUM_SCENE_PARAMETERS AtlasInfo atlas_info,
                              __global const AtlasTriangle* restrict atlas_triangles,
                              __global const uint* restrict atlas_table,
                              __global const AtlasTexel* restrict atlas_texels,
                              __global const SurfacePoint* restrict atlas_points, SIDE_HALVES_PARAMETERS uint sides,
                              __global const LayeredView* restrict views, __global const uint* restrict pixel_start,
                              __global const LayeredFragment* restrict fragments, float weight,
                              __global const uint* restrict accessibility, __global const float2* restrict interior,
                              __global const float4* restrict ends, __global float4* records) {
  const uint side = get_global_id(0);
  if (side >= sides) return;
  LUCARIUM_SCENE_BIND(scene);
  const FragmentList list = {views, pixel_start, fragments};
  const bool front = atlas_side_is_front(atlas_info, side);
  // Choose a point of the texel, another one for every direction, so that texels receive for all of their area.
  const float4 u = random_float4(views[0].seed, side, 0x7465786cu);
  const AtlasTexel texel = jitter_texel(atlas_triangles, atlas_table, atlas_texels[side],
                                        front ? side : side - atlas_info.double_sided_count, u.xy);
  const Triangle t = scene_triangles[texel.triangle];
  const float3 p0 = scene_vertices[t.v0].position.xyz;
  const float3 position =
      p0 + texel.b1 * (scene_vertices[t.v1].position.xyz - p0) + texel.b2 * (scene_vertices[t.v2].position.xyz - p0);
  const float3 normal = atlas_points[side].normal.xyz;
  // Find the point in its bundle pixel, and what it sees along the bundle.
  const ListedPoint point = listed_point(&list, position, texel.triangle, normal, front);
  const SeenFragment seen = seen_fragment(&list, &point, true);
  const uint sender =
      seen_half(&scene, atlas_info, atlas_triangles, atlas_table, half_count, covered, &list, &point, seen);
  // Weight the ray by the cosine and by how accessible this part of the texel is.
  const AtlasTriangle triangle = atlas_triangles[texel.triangle];
  const uint part = side_part(triangle, atlas_uv(triangle, texel.b1, texel.b2));
  const float cosine = dot(normal, views[0].row_w.xyz),
              w = weight * fabs(cosine) * part_accessibility(accessibility, side, part);
  const uint receiver = half_count > sides ? half_of_part(covered, sides, side, part) : side;
  __global float4* to = records + (size_t)receiver * BUNDLE_RECORD;
  if (sender == LUCARIUM_NONE) {
    const float3 end = cosine > 0.0f ? ends[1].xyz : ends[0].xyz;
    // Backs are black. They count, except for rays that begin in hidden places (exchange_pairs.cl).
    to[1] +=
        seen.fragment == LUCARIUM_NONE ? w * (float4)(end, 1.0f) : (float4)(0.0f, 0.0f, 0.0f, w * interior[side].y);
    return;
  }
  // Receive what the opposite sampling point sends, in all channels.
  const __global float4* from = records + (size_t)sender * BUNDLE_RECORD;
  to[0].w += w;
  to[1] += w * (float4)(from[0].xyz, 1.0f);
  for (uint channel = 1u; channel < BUNDLE_ACTIVE; ++channel) to[2u * channel + 1u].xyz += w * from[2u * channel].xyz;
}
