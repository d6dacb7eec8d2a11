// SPDX-License-Identifier: Apache-2.0
// Numbers about texel sides (framework/lucarium/services/texel_sides) that host and kernels share.
#ifndef LUCARIUM_SHARED_TEXEL_SIDES_H
#define LUCARIUM_SHARED_TEXEL_SIDES_H

#define SIDE_POINTS 8u       // random points per texel side that the atlas is to have
#define SIDE_PARTS 64u       // of a texel side, whose accessibility differs (side_parts.clh)
#define SIDE_PART_WORDS 4u   // uints that hold it
#define SIDE_COVER_WORDS 2u  // uints that hold which parts are covered
#define KEPT_HALF_BITS 26u   // bits for a half of a texel side in a kept end of a ray (kept_rows.clh)
#define BUNDLE_PART 26u      // bits for a cell or texel in what a fragment carries; the part is above them

#endif
