// SPDX-License-Identifier: Apache-2.0
// Accessibility of the parts of texel sides: the share of their rays that go farther than the gap. Rays that hit backs
// are ignored, since most of them begin in interior places (texel_interior.h); a part that has no other rays is hidden.
#include "lucarium/random.clh"
#include "lucarium/services/texel_sides/side_parts.clh"
#include "lucarium/services/texel_sides/side_points.clh"
#include "lucarium/surface_atlas.clh"

#define SURELY_HIDDEN 6u  // rays to backs that prove it although no point of the texel side is hidden

// Of 0 to SIDE_MAX_LEVEL, at random one of the two about `accessible` [1], so that the mean is right.
uint dithered_level(float accessible, uint side, uint part) {
  const float random = uint_to_unit(hash_uint3(side, part, 0x6f70656eu));
  return min((uint)(accessible * (float)SIDE_MAX_LEVEL + random), SIDE_MAX_LEVEL);
}

#ifdef SIDE_HALVES
#define FINISH_GLASS_PARAMETERS __global const uint *restrict glass, __global uint *restrict covered,

// Of a part: rays that meet no backs, of them those that meet what transmits.
typedef struct PartRays {
  uint all, glass;
} PartRays;

// The few rays of a part would often say the wrong thing: where parts touch, those of its neighbours in the texel count
// as well, by 4, 2 and 1.
PartRays rays_around(const __global uint* own, const __global uint* own_glass, uint part, bool parts_touch) {
  const int u = (int)(part & 3u), v = (int)(part >> 2 & 3u), reach = parts_touch ? 1 : 0;
  PartRays sum = {0u, 0u};
  for (int y = max(v - reach, 0); y <= min(v + reach, 3); ++y)
    for (int x = max(u - reach, 0); x <= min(u + reach, 3); ++x) {
      const uint place = (part & ~15u) | (uint)(4 * y + x), weight = (x == u ? 2u : 1u) * (y == v ? 2u : 1u);
      sum.all += weight * (PROBE_RAYS(own[place]) - PROBE_BACKS(own[place]));
      sum.glass += weight * own_glass[place];
    }
  return sum;
}
#else
#define FINISH_GLASS_PARAMETERS
#endif

// counts, glass: see probe_pairs.cl. interior, hidden: TexelInterior. share: share of the texel side's area that its
// rays count for, the mean accessibility; with SIDE_HALVES of the open halves, then of the covered ones. accessibility:
// of its parts. covered: of each part a bit. points: of its random points, 4 bits each, 0 for hidden ones.
__kernel void finish_accessibility(uint sides, FINISH_GLASS_PARAMETERS AtlasInfo atlas_info,
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
#ifdef SIDE_HALVES
  // A part is covered where most rays of it and of the parts around meet what transmits; without rays as most of the
  // texel side.
  const __global uint* own_glass = glass + (size_t)side * SIDE_PARTS;
  const bool parts_touch =
      LUCARIUM_ATLAS_PITCH(atlas_triangles[atlas_samples[(size_t)side * SIDE_POINTS].triangle]) > 0u;
  uint transmitted = 0u, cover[SIDE_COVER_WORDS] = {0u, 0u};
  for (uint part = 0u; part < SIDE_PARTS; ++part) transmitted += own_glass[part];
  const bool mostly = transmitted > 0u && 2u * transmitted >= rays - backs;
  for (uint part = 0u; transmitted > 0u && part < SIDE_PARTS; ++part) {
    const PartRays around = rays_around(own, own_glass, part, parts_touch);
    cover[part / 32u] |= (uint)(around.all > 0u ? 2u * around.glass >= around.all : mostly) << (part & 31u);
  }
  for (uint word = 0u; word < SIDE_COVER_WORDS; ++word) covered[(size_t)side * SIDE_COVER_WORDS + word] = cover[word];
#endif
  // Where no ray goes far, all parts are alike.
  const bool closed = near + backs == rays;
  const float mean = closed ? 1.0f : 1.0f - (float)near / (float)(rays - backs), counted = interior[side].y;
  const bool partly = interior[side].x < 1.0f;  // some of it is hidden
  // Find how accessible each part is: of its rays that meet no backs, the share that goes far; the texel side's mean
  // without any. Where no part counts then, all that are not hidden count a little: light must not get lost.
  float total = 0.0f, under = 0.0f;  // of them those of the covered half
  for (uint least = 0u; least < 2u && !(total > 0.0f); ++least) {
    for (uint word = 0u; word < SIDE_PART_WORDS; ++word) {
      uint levels = 0u;
      for (uint part = 16u * word; part < 16u * (word + 1u); ++part) {
        const uint all = PROBE_RAYS(own[part]) - PROBE_BACKS(own[part]);
        const uint lost = PROBE_BACKS(own[part]);
        const bool is_hidden = all == 0u && lost > 0u && (partly || lost >= SURELY_HIDDEN);
        const float accessible = closed || all == 0u ? mean : 1.0f - (float)PROBE_NEAR(own[part]) / (float)all;
        const uint level = is_hidden ? 0u : max(dithered_level(accessible, side, part), least);
        levels |= level << 2u * (part & 15u);
        const float rays_count = (float)level * ((float)all + counted * (float)lost);
        total += rays_count;
#ifdef SIDE_HALVES
        if (part_covered(covered, side, part)) under += rays_count;
#endif
      }
      accessibility[(size_t)side * SIDE_PART_WORDS + word] = levels;
    }
  }
  // Texel sides that no ray has met are too small to matter.
  share[side] = rays > 0u ? (total - under) / (float)(SIDE_MAX_LEVEL * rays) : interior[side].x;
#ifdef SIDE_HALVES
  share[sides + side] = rays > 0u ? under / (float)(SIDE_MAX_LEVEL * rays) : 0.0f;
#endif
  // Give the texel side's random points the accessibility of the parts in which they lie.
  uint of_points = 0u;
  for (uint k = 0u; k < SIDE_POINTS; ++k) {
    if (hidden[side] >> k & 1u) continue;
    const AtlasSample sample = atlas_samples[(size_t)side * SIDE_POINTS + k];
    const AtlasTriangle triangle = atlas_triangles[sample.triangle];
    const uint part = side_part(triangle, atlas_uv(triangle, sample.b1, sample.b2));
    uint level = part_level(accessibility, side, part);
#ifdef SIDE_HALVES
    if (level != 0u && part_covered(covered, side, part)) level |= POINT_COVERED;
#endif
    of_points |= level << 4u * k;
  }
  points[side] = of_points;
}
