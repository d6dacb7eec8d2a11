// SPDX-License-Identifier: Apache-2.0
// Accessibility of the parts of texel sides: the share of their rays that go farther than the neighbouring texels. Rays
// that hit backs are ignored, since most of them begin in interior places (texel_interior.h); a part that has no other
// rays is hidden.
#include "lucarium/random.clh"
#include "lucarium/services/texel_sides/side_parts.clh"
#include "lucarium/surface_atlas.clh"

#define SURELY_HIDDEN 6u  // rays to backs that prove it although no point of the texel side is hidden

// Of 0 to SIDE_MAX_LEVEL, at random one of the two about `accessible` [1], so that the mean is right.
uint dithered_level(float accessible, uint side, uint part) {
  const float random = uint_to_unit(hash_uint3(side, part, 0x6f70656eu));
  return min((uint)(accessible * (float)SIDE_MAX_LEVEL + random), SIDE_MAX_LEVEL);
}

// counts: see probe_pairs.cl. interior, hidden: TexelInterior. share: share of the texel side's area that its rays
// count for, the mean accessibility. accessibility: of its parts. points: of its random points, 4 bits each, 0 for
// hidden ones.
__kernel void finish_accessibility(uint sides, AtlasInfo atlas_info,
                                   __global const AtlasTriangle* restrict atlas_triangles,
                                   __global const AtlasSample* restrict atlas_samples,
                                   __global const uint* restrict counts, __global const float2* restrict interior,
                                   __global const uint* restrict hidden, __global float* restrict share,
                                   __global uint* restrict accessibility, __global uint* restrict points) {
  const uint side = get_global_id(0);
  if (side >= sides) return;
  // Sum up the rays over the parts.
  const __global uint* own = counts + (size_t)side * SIDE_PARTS;
  uint rays = 0u, backs = 0u, near = 0u;
  for (uint part = 0u; part < SIDE_PARTS; ++part) {
    rays += PROBE_RAYS(own[part]);
    backs += PROBE_BACKS(own[part]);
    near += PROBE_NEAR(own[part]);
  }
  // Where no ray goes far, all parts are alike.
  const bool closed = near + backs == rays;
  const float mean = closed ? 1.0f : 1.0f - (float)near / (float)(rays - backs), counted = interior[side].y;
  const bool partly = interior[side].x < 1.0f;  // some of it is hidden
  // Find how accessible each part is: of its rays that meet no backs, the share that goes far; the texel side's mean
  // without any.
  float total = 0.0f;
  for (uint word = 0u; word < SIDE_PART_WORDS; ++word) {
    uint levels = 0u;
    for (uint part = 16u * word; part < 16u * (word + 1u); ++part) {
      const uint all = PROBE_RAYS(own[part]) - PROBE_BACKS(own[part]);
      const uint lost = PROBE_BACKS(own[part]);
      float accessible = closed || all == 0u ? mean : 1.0f - (float)PROBE_NEAR(own[part]) / (float)all;
      if (all == 0u && lost > 0u && (partly || lost >= SURELY_HIDDEN)) accessible = 0.0f;
      const uint level = dithered_level(accessible, side, part);
      levels |= level << 2u * (part & 15u);
      total += (float)level * ((float)all + counted * (float)lost);
    }
    accessibility[(size_t)side * SIDE_PART_WORDS + word] = levels;
  }
  // Texel sides that no ray has met are too small to matter.
  share[side] = rays > 0u ? total / (float)(SIDE_MAX_LEVEL * rays) : interior[side].x;
  // Give the texel side's random points the accessibility of the parts in which they lie.
  uint of_points = 0u;
  for (uint k = 0u; k < SIDE_POINTS; ++k) {
    if (hidden[side] >> k & 1u) continue;
    const AtlasSample sample = atlas_samples[(size_t)side * SIDE_POINTS + k];
    const AtlasTriangle triangle = atlas_triangles[sample.triangle];
    const uint part = side_part(triangle, atlas_uv(triangle, sample.b1, sample.b2));
    of_points |= part_level(accessibility, side, part) << 4u * k;
  }
  points[side] = of_points;
}
