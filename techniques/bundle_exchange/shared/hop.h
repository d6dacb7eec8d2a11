// SPDX-License-Identifier: Apache-2.0
// Chains of specular reflections and transmissions, traced from where their light is wanted.
#ifndef BUNDLE_EXCHANGE_SHARED_HOP_H
#define BUNDLE_EXCHANGE_SHARED_HOP_H
#include "lucarium/shared/dialect.h"

#define HOP_GAIN_CHANNELS 0u  // of a target: one per channel of reflected light
#define HOP_GAIN_ONE 1u       // one for all scatterings
#define HOP_GAIN_LAYERS 2u    // two: light of one scattering, and of more

// Where a chain stands: its ray has left its hops-th vertex.
LUCARIUM_STRUCT_BEGIN(Hop)
float4 throughput;  // xyz: what of the light that the ray finds arrives at the target; w unused
uint target;        // slot list entry or pixel
uint hops;          // vertices so far, at least 1
uint medium;        // material the ray runs through, LUCARIUM_NONE: air
uint pad;
LUCARIUM_STRUCT_END(Hop, 32)

LUCARIUM_STRUCT_BEGIN(HopSettings)
uint seed;         // of this round of chains
uint first_light;  // hops from which on emitters count: 1, or 2 where light sampling has done the first
uint limit;        // most scatterings on the way to the target; LUCARIUM_NONE: unlimited
uint gains;        // HOP_GAIN_*
uint most_hops;    // longest chain
uint lit;          // 1: chains find lights too; 0: only what slots reflect
uint pad0, pad1;
LUCARIUM_STRUCT_END(HopSettings, 32)

#endif
