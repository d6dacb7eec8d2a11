// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>

#include "lucarium/compute/schedule/schedule.h"
#include "lucarium/scene/device/scene_buffers.h"
#include "lucarium/shared/ray.h"

namespace lucarium {

/// A batch of rays on the device.
struct RayBuffers {
  BufferRef rays;              ///< Ray
  BufferRef counter;           ///< uint; counter[counter_index] rays are there
  uint32_t counter_index = 0;  ///< into counter
  uint32_t capacity = 0;       ///< rays at most
  BufferRef ends;              ///< RayEnds of each, for intersectors that want them (ray_ends.h); else empty
  /// Rays in a row where they are those of pixels, row by row, as long as none has ended; else 0. Says which rays are
  /// neighbours: hierarchies trace them in squares where it is a multiple of 4. Results lie where the rays do.
  uint32_t row = 0;
};

/// Rays in, hits out, in large batches: the one interface between light transport and acceleration structures.
/// Implementations honour MASK and BLEND (Ray::origin.w seeds the decision); any-hit reports every opaque thing,
/// delta glass included.
class Intersector {
 public:
  virtual ~Intersector() = default;
  virtual std::string name() const = 0;
  /// Whether it needs to know which surfaces a ray leaves and is to reach, since distance alone does not show it:
  /// callers of record_*() then fill RayBuffers::ends. One answer in its whole life.
  virtual bool wants_ends() const { return false; }

  /// Records the passes that fill hits[i] (Hit) for ray i of the batch.
  virtual void record_closest(ScheduleRecorder& recorder, const std::string& pass_name, const RayBuffers& rays,
                              const BufferRef& hits) const = 0;
  /// Records the passes that set occluded[i] (uint) to 1 when anything lies within ray i's length, else 0.
  virtual void record_any(ScheduleRecorder& recorder, const std::string& pass_name, const RayBuffers& rays,
                          const BufferRef& occluded) const = 0;
};

}  // namespace lucarium
