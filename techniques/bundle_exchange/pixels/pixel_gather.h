// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "bundle_exchange/senders/side_means.h"
#include "lucarium/services/gbuffer/gbuffer.h"
#include "lucarium/services/layered_raster/layered_raster.h"
#include "lucarium/services/surface_atlas/surface_atlas.h"

namespace lucarium::bundle {

/// The last reflection towards the eye, gathered from the stored fragments of bundles (gather_pixels.cl): one ray per
/// pixel and direction, the same directions for all pixels.
class PixelGather {
 public:
  struct Options {
    uint32_t pixels = 0;
    bool whole = false;   ///< the diffuse lobe too
    float min_alpha = 0;  ///< of specular lobes that are gathered; narrower ones are left to rays
  };
  PixelGather(Device& device, KernelScheduler& scheduler, const Program& program, const SceneBuffers& scene,
              const Intersector& intersector, const SurfaceAtlas& atlas, const SideMeans& means,
              const TypedBuffer<GBufferPoint>& points, const Options& options);

  /// Records the gathering along one direction into a schedule that stores its fragments. `first`: 1 for the first
  /// direction of a batch; `weight`: W [sr].
  void record(ScheduleRecorder& recorder, const LayeredRaster::Stored& stored, const TypedBuffer<LayeredView>& views,
              const TypedBuffer<float4>& ends, const Variable<uint32_t>& first, const Variable<float>& weight) const;
  /// The batch counts. restart(): for the next camera sample.
  void commit(uint32_t directions);
  void restart();
  void warm_up();

  const Options& options() const { return options_; }
  /// Per pixel two float4: xyz sums of light scattered once, w directions; xyz sums of light scattered more often.
  const TypedBuffer<float4>& gathered() const { return gathered_; }
  static size_t estimate_bytes(size_t pixels);

 private:
  Program program_;
  KernelScheduler* scheduler_;
  const SceneBuffers* scene_;
  const Intersector* intersector_;
  const SurfaceAtlas* atlas_;
  Options options_;
  TypedBuffer<GBufferPoint> points_;
  SideHalves halves_;
  TypedBuffer<float4> records_, contribution_, gathered_, shares_;
  TypedBuffer<Ray> rays_;
  TypedBuffer<uint32_t> count_;
  Schedule add_;
  Variable<uint32_t> directions_;
};

}  // namespace lucarium::bundle
