// SPDX-License-Identifier: Apache-2.0
// Where specular chains add what they find (advance_chains.cl).
#ifndef BUNDLE_EXCHANGE_SHARED_CONTRIBUTION_LAYOUT_H
#define BUNDLE_EXCHANGE_SHARED_CONTRIBUTION_LAYOUT_H

#define CONTRIBUTION_CHANNELS 0u  // of a target: one per channel of reflected light
#define CONTRIBUTION_ONE 1u       // one for all scatterings
#define CONTRIBUTION_LAYERS 2u    // two: light of one scattering, and of more

#endif
