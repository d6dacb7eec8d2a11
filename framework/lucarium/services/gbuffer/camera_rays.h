// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>

#include "lucarium/compute/schedule/scheduler.h"
#include "lucarium/services/intersector.h"
#include "lucarium/shared/camera.h"

namespace lucarium {

/// The rays of a G-buffer's samples and what they meet first, without a G-buffer: for techniques that make more of a
/// hit at once than points keep (eye_vertex.clh).
class CameraRays {
 public:
  CameraRays(Device& device, KernelScheduler& scheduler, const Intersector& intersector, const Frame& frame,
             const std::string& owner);

  /// Fills rays() and hits() with those of sample `sample_index`. False when cancelled.
  bool trace(uint32_t sample_index);
  /// Another camera or seed; the image size stays.
  void set_frame(const Frame& frame);
  void warm_up() { scheduler_->warm_up(trace_); }
  const TypedBuffer<Ray>& rays() const { return rays_; }  ///< width · height, rows from the top
  const TypedBuffer<Hit>& hits() const { return hits_; }
  /// ray_ends: of an intersector that wants them.
  static size_t estimate_bytes(uint32_t width, uint32_t height, bool ray_ends = false);

 private:
  KernelScheduler* scheduler_;
  Frame frame_;
  TypedBuffer<Ray> rays_;
  TypedBuffer<RayEnds> ends_;  ///< empty where the intersector wants none
  TypedBuffer<Hit> hits_;
  TypedBuffer<uint32_t> active_;  ///< one element: the number of rays
  Schedule trace_;
  Variable<Frame> frame_variable_;
  Variable<uint32_t> sample_;
};

}  // namespace lucarium
