// SPDX-License-Identifier: Apache-2.0
// What SpecularChains (framework/lucarium/services/specular_chains) and its kernels share.
#ifndef LUCARIUM_SHARED_SPECULAR_CHAIN_H
#define LUCARIUM_SHARED_SPECULAR_CHAIN_H
#include "lucarium/shared/dialect.h"

// Where a chain stands: its ray has left its last vertex.
LUCARIUM_STRUCT_BEGIN(SpecularChain)
float4 throughput;  // xyz: share of the light that the ray finds which arrives at the target; w unused
uint target;        // for which light is looked for: pixel, texel side, ...
uint vertices;      // so far: times that what the ray finds is scattered on the way
uint medium;        // material that the ray runs through (medium.clh); LUCARIUM_NONE: air
uint pad;
LUCARIUM_STRUCT_END(SpecularChain, 32)

LUCARIUM_STRUCT_BEGIN(ChainSettings)
uint seed;          // of this round of chains
uint lit;           // 1: chains find lights; 0: only what the consumer adds at surfaces
uint first_light;   // vertices from which on emitters count: 1, or 2 where light sampling has done the first
uint limit;         // max scatterings on the way to the target; LUCARIUM_NONE: unlimited
uint max_vertices;  // of a chain
uint pad0, pad1, pad2;
LUCARIUM_STRUCT_END(ChainSettings, 32)

#endif
