// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>

#include "bidirectional_vpl/base/plan.h"
#include "bidirectional_vpl/shared/cached_pixel.h"
#include "lucarium/services/gbuffer/gbuffer.h"

namespace lucarium::bidirectional {

/// Indirect light of the frame before, by sub-pixel (caches.cl): of iterations 0 to 3, 4 to 7 …, one is computed in a
/// frame, in turn, and the others look theirs up. In the first frame all are computed.
class Caches {
 public:
  Caches(Device& device, KernelScheduler& scheduler, const SceneBuffers& scene, const Intersector& intersector,
         const Frame& frame, const Plan& plan, const std::string& owner);

  /// Finds the surfaces of an iteration and what caches hold for them. False when cancelled.
  bool look_up(uint32_t index);
  /// Records that an iteration's indirect light (`layer` of the sample) is replaced where it was found, and kept.
  void record_keep(ScheduleRecorder& recorder, const TypedBuffer<float4>& sample, uint32_t layer);
  /// Before the schedule of record_keep() runs.
  void prepare_keep(Schedule& schedule) const;
  /// By pixel: light that was found; w: 1 or 0. In place while an iteration runs.
  const TypedBuffer<float4>& reused() const { return reused_; }
  /// The scene or the camera has moved on.
  void next_frame(const Frame& frame);
  /// Forgets everything.
  void clear(const Frame& frame);
  void warm_up();
  static size_t estimate_bytes(const Plan& plan, size_t vertices, bool ray_ends);

 private:
  void record_look_up(const SceneBuffers& scene, const std::string& owner);
  void record_advance(const SceneBuffers& scene, const std::string& owner);
  void advance(const Frame& frame, bool begin);
  uint32_t first_of(uint32_t index) const { return index % BIDIRECTIONAL_SUB_PIXELS * pixels_; }

  KernelScheduler& scheduler_;
  Frame frame_, before_;  ///< this one and the one before
  uint32_t pixels_;
  GBuffer surfaces_;
  Program program_;
  TypedBuffer<CachedPixel> caches_, kept_;   ///< of the frame before, and of this one
  TypedBuffer<float4> positions_, present_;  ///< of vertices: in the frame before, and in this one
  TypedBuffer<float4> reused_;
  Schedule look_up_, advance_;
  Variable<Frame> before_variable_;
  Variable<uint32_t> first_, computed_, begin_, keep_first_;
  uint32_t frames_ = 0, index_ = 0;
};

}  // namespace lucarium::bidirectional
