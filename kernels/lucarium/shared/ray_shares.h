// SPDX-License-Identifier: Apache-2.0
// Shares of a batch of rays, one per work-item.
#ifndef LUCARIUM_SHARED_RAY_SHARES_H
#define LUCARIUM_SHARED_RAY_SHARES_H

// Many, so that rays in flight rarely run out; few, so that all threads have some of a small batch. A multiple of 16,
// the rays of a packet.
#define LUCARIUM_RAYS_PER_SHARE 256u

#endif
