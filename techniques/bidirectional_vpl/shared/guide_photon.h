// SPDX-License-Identifier: Apache-2.0
// Light that ideal surfaces have passed on, as camera paths are guided by it.
#ifndef BIDIRECTIONAL_VPL_SHARED_GUIDE_PHOTON_H
#define BIDIRECTIONAL_VPL_SHARED_GUIDE_PHOTON_H
#include "lucarium/shared/dialect.h"

#define BIDIRECTIONAL_GUIDE_PHOTONS 131072u     // at most; no more are collected then
#define BIDIRECTIONAL_GUIDE_WINDOW 32u          // that guide a camera path
#define BIDIRECTIONAL_GUIDE_NO_KEY 0x40000000u  // behind all keys

LUCARIUM_STRUCT_BEGIN(GuidePhoton)
float4 position;   // xyz [m]; w: distance to the third nearest of its window [m]
float4 direction;  // xyz: to where the light came from; w: width of its lobe (alpha of a GGX distribution)
LUCARIUM_STRUCT_END(GuidePhoton, 32)

#endif
