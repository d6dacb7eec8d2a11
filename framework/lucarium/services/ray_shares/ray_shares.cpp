// SPDX-License-Identifier: Apache-2.0
#include "lucarium/services/ray_shares/ray_shares.h"

#include <algorithm>

#include "lucarium/shared/ray_shares.h"

namespace lucarium {

namespace {

constexpr uint32_t rays_per_slice = 1u << 15;  // per compute unit, between two looks at the cancel flag

}  // namespace

void trace_by_shares(PassBuilder& pass, const RayBuffers& rays, const Device& device) {
  constexpr size_t share = LUCARIUM_RAYS_PER_SHARE;
  const uint32_t slice = rays_per_slice / LUCARIUM_RAYS_PER_SHARE * std::max(1u, device.info().compute_units);
  pass.global(std::max<size_t>(1, (size_t{rays.capacity} + share - 1) / share))
      .local(1)
      .slice(slice)
      .arg("counter", rays.counter)
      .arg("counter_index", rays.counter_index)
      .arg("capacity", rays.capacity)
      .arg("shares_per_slice", slice);
}

}  // namespace lucarium
