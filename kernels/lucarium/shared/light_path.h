// SPDX-License-Identifier: Apache-2.0
// Paths from the lights (services/light_paths).
#ifndef LUCARIUM_SHARED_LIGHT_PATH_H
#define LUCARIUM_SHARED_LIGHT_PATH_H
#include "lucarium/shared/dialect.h"

#define LUCARIUM_LIGHT_PATHS_DIFFUSE 1u       // diffuse lobes alone; a path ends where there is none
#define LUCARIUM_LIGHT_PATHS_OPAQUE_BLEND 2u  // BLEND surfaces count as opaque

// Keys by which first rays are ordered: their bits, those of the light in front of the direction's, and the last one.
#define LIGHT_FIRST_KEY_BITS 16u
#define LIGHT_FIRST_KEY_LIGHT_BITS 4u
#define LIGHT_FIRST_KEY_LAST 0xffffu

LUCARIUM_STRUCT_BEGIN(LightPathRules)
uint count;           // paths of a run
uint flags;           // LUCARIUM_LIGHT_PATHS_*
uint kinds;           // of lights, bits 1 << LUCARIUM_LIGHT_*
uint roulette_start;  // scatterings before Russian roulette; LUCARIUM_NONE: none
// Samples of the strategies -1, 0 and all between, for weights (path_mis.clh):
float hit_samples, light_samples, connection_samples;
uint vertices;  // of a path at most
LUCARIUM_STRUCT_END(LightPathRules, 32)

#define LIGHT_MAX_PHOTONS 256  // that a density may be estimated from

// A path between two vertices.
LUCARIUM_STRUCT_BEGIN(LightPathState)
float4 flux;         // xyz: along the ray [lm]; w: density of its direction [1/sr]
float2 mis;          // what path_mis.clh carries along the ray
float start_cosine;  // of the ray to the geometric normal where it begins; 1 where there is none
uint light;          // where the path began, into scene_lights
uint medium;         // that the ray runs through (medium.clh)
uint diffused;       // scatterings so far that were not ideal
uint pad0, pad1;
LUCARIUM_STRUCT_END(LightPathState, 48)

// A point from which the light of one path is reflected diffusely, or at which it arrives (a photon).
LUCARIUM_STRUCT_BEGIN(VirtualLight)
float4 position;  // xyz [m]; w: bits of the shading normal (pack_direction)
float4 flux;      // xyz, reflected or arriving [lm]; black: no light; w: bits of the geometric normal
LUCARIUM_STRUCT_END(VirtualLight, 32)

#endif
