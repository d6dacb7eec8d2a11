// SPDX-License-Identifier: Apache-2.0
// Settings of PathIntegrator's kernels: which paths to follow, and which samples a batch holds.
#ifndef LUCARIUM_SHARED_PATH_SETTINGS_H
#define LUCARIUM_SHARED_PATH_SETTINGS_H
#include "lucarium/shared/dialect.h"

#define LUCARIUM_PATH_EMISSION 1u  // layer 0: no counted scattering
#define LUCARIUM_PATH_DIRECT 2u    // layer 1
#define LUCARIUM_PATH_INDIRECT 4u  // layers 2 and up
// Light of emissive triangles and of the environment; punctual lights are always sampled:
#define LUCARIUM_PATH_SAMPLE_LIGHTS 8u         // such light is sampled at every vertex (next-event estimation)
#define LUCARIUM_PATH_HIT_LIGHTS 16u           // it counts where a BSDF sample hits it; with the flag above: MIS
#define LUCARIUM_PATH_SEES_TRIANGLES 32u       // some surface emits, and such light is in the path set
#define LUCARIUM_PATH_SEES_ENVIRONMENT 64u     // the same for the environment
#define LUCARIUM_PATH_PUNCTUAL 128u            // the same for point, spot and directional lights
#define LUCARIUM_PATH_LIGHT_DELTA 512u         // delta events behind the first counted scattering
#define LUCARIUM_PATH_SECONDARY_LAMBERT 1024u  // behind the first non-delta vertex only the diffuse lobe
#define LUCARIUM_PATH_GEOMETRIC_NORMALS 2048u
#define LUCARIUM_PATH_RANDOM_SAMPLER 4096u  // independent random numbers instead of Sobol points
#define LUCARIUM_PATH_OPAQUE_BLEND 8192u    // BLEND surfaces count as opaque

#define LUCARIUM_PATH_LAYERS 3u
#define LUCARIUM_PATH_NUMBER_ROWS 12u  // words that a vertex decides by (eight/vertex_numbers.clh)
// Delta events between the eye and the first non-delta vertex, where their number is unlimited: no more than this;
// reaching it is counted and reported.
#define LUCARIUM_PATH_EYE_DELTA_LIMIT 4096u
// Those of them before Russian roulette.
#define LUCARIUM_PATH_EYE_ROULETTE_START 32u
// Counted scatterings of an unlimited path: no more than this; reaching it is counted and reported.
#define LUCARIUM_PATH_SCATTERING_CAP 4096u

LUCARIUM_STRUCT_BEGIN(PathSettings)
uint flags;               // LUCARIUM_PATH_*
uint max_scatterings;     // highest layer that is wanted
uint roulette_start;      // counted scatterings before Russian roulette; LUCARIUM_NONE: none
uint eye_roulette_start;  // delta events on the eye's side before it
uint eye_deltas;          // those after which such an event ends the path; LUCARIUM_PATH_EYE_DELTA_LIMIT: unlimited
uint replicates;          // sample n belongs to replicate n mod replicates
float indirect_clamp;     // upper bound of one sample's indirect light [cd/m²]; 0: none
uint pad0;
LUCARIUM_STRUCT_END(PathSettings, 32)

// Path i of a batch is sample first_sample + i / pixel_count of pixel first_pixel + i mod pixel_count.
LUCARIUM_STRUCT_BEGIN(PathBatch)
uint first_pixel;
uint pixel_count;
uint first_sample;
uint sample_count;
uint seed;
uint pad0, pad1, pad2;
LUCARIUM_STRUCT_END(PathBatch, 32)

// Where a path stands.
LUCARIUM_STRUCT_BEGIN(PathState)
uint scatterings;  // counted so far
uint segment;      // vertices visited so far, for the sampler
uint medium;       // material the segment runs through, LUCARIUM_NONE: air
uint flags;        // events and counts, see path_state.clh
LUCARIUM_STRUCT_END(PathState, 16)

// Events that must not happen, and one that may: counted on the device.
#define LUCARIUM_PATH_COUNT_NONFINITE 0u  // samples with a NaN, infinite or negative contribution
#define LUCARIUM_PATH_COUNT_CAPPED 1u     // paths ended by LUCARIUM_PATH_SCATTERING_CAP
#define LUCARIUM_PATH_COUNT_EYE_DELTA 2u  // paths ended by LUCARIUM_PATH_EYE_DELTA_LIMIT
#define LUCARIUM_PATH_COUNTS 4u

#endif
