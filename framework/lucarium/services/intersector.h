// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>

#include "lucarium/compute/schedule/schedule.h"
#include "lucarium/scene/device/scene_buffers.h"
#include "lucarium/shared/ray.h"

namespace lucarium {

/// Rays in, hits out, in large batches: the one interface between light transport and acceleration structures.
/// Implementations honour MASK and BLEND (Ray::origin.w seeds the decision); any-hit reports every opaque thing,
/// delta glass included.
class Intersector {
 public:
  virtual ~Intersector() = default;
  virtual std::string name() const = 0;

  /// Records the passes that fill hits[i] for rays[i], i < counter[counter_index] ≤ capacity. `rays` holds Ray, `hits`
  /// Hit.
  virtual void record_closest(ScheduleRecorder& recorder, const std::string& pass_name, const BufferRef& rays,
                              const BufferRef& hits, const BufferRef& counter, uint32_t counter_index,
                              uint32_t capacity) const = 0;
  /// Records the passes that set occluded[i] (uint) to 1 when anything lies within ray i's length, else 0.
  virtual void record_any(ScheduleRecorder& recorder, const std::string& pass_name, const BufferRef& rays,
                          const BufferRef& occluded, const BufferRef& counter, uint32_t counter_index,
                          uint32_t capacity) const = 0;
};

}  // namespace lucarium
