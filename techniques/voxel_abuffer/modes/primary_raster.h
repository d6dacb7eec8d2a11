// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>

#include "lucarium/scene/scene.h"
#include "lucarium/services/intersector.h"
#include "lucarium/services/layered_raster/layered_raster.h"
#include "lucarium/shared/camera.h"

namespace lucarium::abuffer {

/// First visibility by rasterization (deferred shading: Hu et al. 2014, section 4): knows what rays through the centres
/// of pixels of a perspective camera meet, and leaves all others to another intersector; those, too, whose first
/// surface lets them pass (MASK, BLEND). Their origin and direction show which these are, so that any service may run
/// over it.
class PrimaryRaster : public Intersector {
 public:
  /// `scheduler`, `scene` and `others` must outlive this. Images up to LAYERED_MAX_EDGE pixels wide and high.
  PrimaryRaster(KernelScheduler& scheduler, const SceneBuffers& scene, const Intersector& others, uint32_t width,
                uint32_t height);

  /// Whether it can show what this camera sees: perspective, sampled at pixels' centres, not too large.
  static bool possible(const Frame& frame);
  /// Follows a change of the scene; after SceneBuffers::update().
  void update() { raster_.update(); }
  /// Rasterizes the scene as this camera sees it: a possible() one, of the same size.
  void rasterize(const Frame& frame);

  std::string name() const override { return others_->name(); }
  bool wants_ends() const override { return others_->wants_ends(); }
  void record_closest(ScheduleRecorder& recorder, const std::string& pass_name, const RayBuffers& rays,
                      const BufferRef& hits) const override;
  void record_any(ScheduleRecorder& recorder, const std::string& pass_name, const RayBuffers& rays,
                  const BufferRef& occluded) const override {
    others_->record_any(recorder, pass_name, rays, occluded);
  }

  /// Device bytes, with passes over batches of so many rays.
  static size_t estimate_bytes(size_t triangles, uint32_t width, uint32_t height, size_t rays);

 private:
  void record();
  KernelScheduler* scheduler_;
  const SceneBuffers* scene_;
  const Intersector* others_;
  LayeredRaster raster_;
  Program program_;
  TypedBuffer<LayeredView> view_;
  TypedBuffer<float4> eye_;
  TypedBuffer<float> depth_;
  TypedBuffer<uint32_t> triangle_;
  Schedule schedule_;
  uint64_t recorded_ = 0;  ///< generation of the raster
};

/// The camera of a frame as a view whose depths hold `bounds`.
LayeredView camera_view(const Frame& frame, const Bounds& bounds);

}  // namespace lucarium::abuffer
