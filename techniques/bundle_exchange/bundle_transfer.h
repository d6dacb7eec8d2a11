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

  /// Adds the rays of one direction to the records; false when cancelled. `seed` decides BLEND. `direct_only`: only the
  /// channel of emission.
  bool exchange(const Direction& direction, uint32_t seed, bool direct_only = false);
  void warm_up();
  /// Largest film of a direction [pixels].
  double film_pixels() const;
  /// Edge of a film pixel [m].

 private:
  struct Recorded {
    Schedule schedule;
    Variable<LayeredView> view;
    Variable<float4> omega;
    Variable<float> weight;
  };
  Recorded record(Device& device, const SceneBuffers& buffers, const SurfaceAtlas& atlas,
                  const TypedBuffer<float4>& records, bool direct_only);
  KernelScheduler* scheduler_;
  Channels channels_;
  Bounds bounds_;
  double pixel_;
  uint32_t side_;
  LayeredRaster raster_;
  TypedBuffer<LayeredView> views_;
  TypedBuffer<float4> ends_;
  Recorded all_, direct_;  ///< exchanging all channels, or that of emission only
};

}  // namespace lucarium::bundle
