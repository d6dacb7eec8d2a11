// SPDX-License-Identifier: Apache-2.0
// Numbers about slots that host and kernels share.
#ifndef BUNDLE_EXCHANGE_SHARED_SLOTS_H
#define BUNDLE_EXCHANGE_SHARED_SLOTS_H

#define SLOT_POINTS 8u       // random points per slot that the atlas is to have
#define SLOT_PARTS 64u       // of a slot, whose openness differs (slot_parts.clh)
#define SLOT_PART_WORDS 4u   // uints that hold it
#define BUNDLE_PART 26u      // bits for a cell or texel in what a fragment carries; the part is above them
#define BALANCE_CHUNK 1024u  // slots that a work-item of the balance sums

#endif
