// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "lucarium/compute/device/device.h"
#include "lucarium/services/intersector.h"

namespace lucarium {

/// Makes `pass` trace a batch by shares, a run of rays per work-item: what intersectors do on processors, where a
/// work-item keeps many rays in flight. Sets the size, slices short enough for cancellation, and the arguments
/// `counter`, `counter_index`, `capacity` and `shares_per_slice` of ray_share() (ray_shares.clh), which says which
/// rays a work-item traces.
void trace_by_shares(PassBuilder& pass, const RayBuffers& rays, const Device& device);

}  // namespace lucarium
