// SPDX-License-Identifier: Apache-2.0
// Where specular chains add what they find (hops.cl).
#ifndef BUNDLE_EXCHANGE_SHARED_GAIN_LAYOUT_H
#define BUNDLE_EXCHANGE_SHARED_GAIN_LAYOUT_H

#define HOP_GAIN_CHANNELS 0u  // of a target: one per channel of reflected light
#define HOP_GAIN_ONE 1u       // one for all scatterings
#define HOP_GAIN_LAYERS 2u    // two: light of one scattering, and of more

#endif
