// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "lucarium/compute/schedule/scheduler.h"
#include "lucarium/services/bvh/bvh.h"
#include "lucarium/shared/layered_raster.h"

namespace lucarium::bench {

/// The rays of orthographic views one by one: through every pixel's centre, closest hit after closest hit, until
/// nothing is hit any more.
class ThroughRays {
 public:
  /// All must outlive this. `pixels`: of a view, at most.
  ThroughRays(KernelScheduler& scheduler, const Intersector& intersector, const TypedBuffer<LayeredView>& views,
              uint32_t pixels);
  /// All rays of a view; returns how many hits they had.
  uint32_t trace(uint32_t view);

 private:
  KernelScheduler* scheduler_;
  TypedBuffer<Ray> rays_[2];
  TypedBuffer<Hit> hits_;
  TypedBuffer<uint32_t> counter_[2], found_;
  Schedule first_, next_[2];
  Variable<uint32_t> view_;
  uint32_t remaining_ = 0;
};

}  // namespace lucarium::bench
