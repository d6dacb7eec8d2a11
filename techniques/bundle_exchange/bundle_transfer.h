// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "bundle_view.h"
#include "lucarium/services/layered_raster.h"
#include "lucarium/services/surface_atlas.h"
#include "slot_means.h"

namespace lucarium::bundle {

/// Exchange along all rays of one direction: the scene is drawn orthographically with every fragment, and consecutive
/// fragments of a pixel give each other what they send (exchange_rows.cl).
class BundleTransfer {
 public:
  /// `pixel_size`: edge of a film pixel in texel edges.
  BundleTransfer(Device& device, KernelScheduler& scheduler, const Scene& scene, const SceneBuffers& buffers,
                 const SurfaceAtlas& atlas, const TypedBuffer<float4>& records, const Channels& channels,
                 float pixel_size);

  /// Adds the rays of one direction to the records; false when cancelled. `seed` decides BLEND.
  bool exchange(const Direction& direction, uint32_t seed);
  void warm_up();
  /// Largest film of a direction [pixels].
  double film_pixels() const;
  /// Edge of a film pixel [m].
  double pixel() const { return pixel_; }

 private:
  void record(Device& device, const SceneBuffers& buffers, const SurfaceAtlas& atlas, const TypedBuffer<float4>& records);
  KernelScheduler* scheduler_;
  Channels channels_;
  Bounds bounds_;
  double pixel_;
  uint32_t side_;
  LayeredRaster raster_;
  TypedBuffer<LayeredView> views_;
  TypedBuffer<float4> ends_;
  Schedule exchange_;
  Variable<LayeredView> view_;
  Variable<float4> omega_;
  Variable<float> weight_;
};

}  // namespace lucarium::bundle
