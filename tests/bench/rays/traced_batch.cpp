// SPDX-License-Identifier: Apache-2.0
#include "traced_batch.h"

namespace lucarium::bench {

TracedBatch::TracedBatch(Device& device, KernelScheduler& scheduler, const Intersector& intersector,
                         const std::vector<Ray>& rays, bool any, const std::vector<RayEnds>& ends, uint32_t row)
    : scheduler_(scheduler),
      rays_(device, "bench", "rays", rays),
      hits_(device, "bench", "hits", any ? 1 : rays.size()),
      ends_(device, "bench", "ends", ends),
      occluded_(device, "bench", "occluded", any ? rays.size() : 1),
      counter_(device, "bench", "counter", std::vector<uint32_t>{static_cast<uint32_t>(rays.size())}) {
  const auto count = static_cast<uint32_t>(rays.size());
  ScheduleRecorder recorder = scheduler.record("rays", "bench");
  if (any)
    intersector.record_any(recorder, "any hit", {rays_, counter_, 0, count, ends_}, occluded_);
  else
    intersector.record_closest(recorder, "closest hit", {rays_, counter_, 0, count, ends_, row}, hits_);
  schedule_ = recorder.compile();
  run();
}

void TracedBatch::run() {
  scheduler_.run(schedule_);
  scheduler_.finish();
}

}  // namespace lucarium::bench
