// SPDX-License-Identifier: Apache-2.0
// The balance of power (senders/balance_power.cl), for host and kernels.
#ifndef BUNDLE_EXCHANGE_SHARED_BALANCE_H
#define BUNDLE_EXCHANGE_SHARED_BALANCE_H

#define BALANCE_CHUNK 1024u  // texel sides that a work-item sums

#endif
