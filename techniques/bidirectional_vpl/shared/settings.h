// SPDX-License-Identifier: Apache-2.0
// What host and kernels share: the strategies of an iteration, and where a camera path stands.
#ifndef BIDIRECTIONAL_VPL_SHARED_SETTINGS_H
#define BIDIRECTIONAL_VPL_SHARED_SETTINGS_H
#include "lucarium/shared/dialect.h"

#define BIDIRECTIONAL_OWN_VERTICES 1u     // a camera path is connected to the light path of its own number
#define BIDIRECTIONAL_STRATEGIES 2u       // light is summed by strategy, too
#define BIDIRECTIONAL_PAIRED_VERTICES 4u  // a camera path is connected to the light path of its bundle's number
#define BIDIRECTIONAL_ALL_VERTICES 8u     // a camera path is connected to all light vertices
#define BIDIRECTIONAL_COMPENSATES 16u     // what clamps of connections leave is left to camera paths (two_bounce.clh)
#define BIDIRECTIONAL_FILTERED 32u        // pixels have their tile's samples, too (filter_pixels.cl)

// Layers of a sample, and behind them its strategies: hit, nee, vpl1 ..., splat last.
#define BIDIRECTIONAL_EMISSION 0u
#define BIDIRECTIONAL_DIRECT 1u
#define BIDIRECTIONAL_INDIRECT 2u
#define BIDIRECTIONAL_LAYERS 3u

// Samples of a strategy are 0 where it is not run.
LUCARIUM_STRUCT_BEGIN(BidirectionalSettings)
uint flags;                // BIDIRECTIONAL_*
uint pixels;               // camera paths of an iteration, one to a pixel
uint light_paths;          // of an iteration
uint max_scatterings;      // counted, of a whole path
uint camera_edges;         // scatterings of a camera path before roulette
uint candidates;           // virtual lights that are compared for one connection
float hit_samples;         // n of strategy -1
float light_samples;       // n of strategy 0
float connection_samples;  // n of strategies 1 ... K-1
float splat_samples;       // n of strategy K
uint bundles;              // directions of an iteration
uint reuse;                // BIDIRECTIONAL_REUSE_*
uint interleave;  // pixels along a tile whose pixels take different bundles and virtual lights (interleave.clh)
uint width;       // of the image
float g_max;      // of connections of two and more bounces, with BIDIRECTIONAL_TWO_BOUNCE [1/m^2]
float m_prime;    // samples that a glossy lobe covers at least (gloss.clh)
LUCARIUM_STRUCT_END(BidirectionalSettings, 64)

// Bundles of deeper scatterings: a scrambled set for each depth, different ones of independent directions, or the same.
#define BIDIRECTIONAL_REUSE_PER_DEPTH 0u
#define BIDIRECTIONAL_REUSE_DISTINCT 1u
#define BIDIRECTIONAL_REUSE_SHARED 2u

// Events of an iteration that are counted.
#define BIDIRECTIONAL_COUNT_BAD 0u               // camera paths with a NaN, infinite or negative contribution
#define BIDIRECTIONAL_COUNT_CAPPED 1u            // that end with EYE_PATH_CAPPED
#define BIDIRECTIONAL_COUNT_MIRRORS 2u           // with EYE_PATH_MIRRORS
#define BIDIRECTIONAL_COUNT_LIGHT_RAYS 3u        // shadow rays of light samples
#define BIDIRECTIONAL_COUNT_CONNECTION_RAYS 4u   // of connections
#define BIDIRECTIONAL_COUNT_CHOICES 5u           // vertices at which a virtual light was to be chosen
#define BIDIRECTIONAL_COUNT_LIGHT_TESTS 6u       // shadow rays and look-ups of maps
#define BIDIRECTIONAL_COUNT_CONNECTION_TESTS 7u  // the same of connections
#define BIDIRECTIONAL_COUNTS 8u

// A camera path between two vertices.
LUCARIUM_STRUCT_BEGIN(EyePathState)
float4 throughput;  // xyz; w: density of the ray's direction, not guided [1/sr], of an ideal lobe its probability
uint scatterings;   // counted so far
uint segment;       // vertices visited so far, for the sampler
uint medium;        // that the ray runs through (medium.clh)
uint flags;         // EYE_PATH_*
float cosine;       // of the ray to the geometric normal where it begins
float carried;      // x of what path_mis.clh carries; its y, for each number of light vertices, is in eye_mis
uint bundle;        // in whose stored fragments the ray is looked up; LUCARIUM_NONE: it is traced
uint left;          // the triangle that it leaves then
float rest;         // of paths over the last edge, what connections leave (two_bounce.clh)
float gain;         // densities of all directions so far over those of BSDFs (guide.clh)
uint pad0, pad1;
LUCARIUM_STRUCT_END(EyePathState, 64)

#define EYE_PATH_AFTER_DELTA 1u  // the last scattering was ideal, or there was none
#define EYE_PATH_CHAIN 2u        // there were ideal scatterings only
#define EYE_PATH_BAD 4u          // a contribution was NaN, infinite or negative
#define EYE_PATH_CAPPED 16u      // ended by LUCARIUM_PATH_SCATTERING_CAP
#define EYE_PATH_CACHED 64u      // its indirect light is known (caches.cl): one scattering is enough
#define EYE_PATH_MIRRORS 32u     // ended by LUCARIUM_PATH_EYE_DELTA_LIMIT
#define EYE_PATH_PARALLEL 8u     // the ray is an orthographic camera's: its density is over area

#endif
