// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <vector>

#include "lucarium/compute/schedule/scheduler.h"
#include "lucarium/services/bvh/bvh.h"

namespace lucarium::bench {

/// One pass of an intersector over a fixed batch of rays.
class TracedBatch {
 public:
  /// `any`: occlusion instead of closest hits; `row`: of RayBuffers. Runs once, so that drivers have compiled what they
  /// compile late.
  TracedBatch(Device& device, KernelScheduler& scheduler, const Intersector& intersector, const std::vector<Ray>& rays,
              bool any, const std::vector<RayEnds>& ends = {}, uint32_t row = 0);

  void run();
  std::vector<Hit> hits() const { return hits_.download(); }
  std::vector<uint32_t> occluded() const { return occluded_.download(); }

 private:
  KernelScheduler& scheduler_;
  TypedBuffer<Ray> rays_;
  TypedBuffer<Hit> hits_;
  TypedBuffer<RayEnds> ends_;
  TypedBuffer<uint32_t> occluded_, counter_;
  Schedule schedule_;
};

}  // namespace lucarium::bench
