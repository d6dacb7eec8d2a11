// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "direction_sequence.h"
#include "lucarium/services/layered_raster.h"
#include "lucarium/services/surface_atlas.h"
#include "slot_means.h"

namespace lucarium::bundle {

/// Exchange along all rays of one direction: the scene is drawn orthographically with every fragment, and consecutive
/// fragments of a pixel give each other what they send.
class BundleTransfer {
 public:
  BundleTransfer(Device& device, KernelScheduler& scheduler, const SceneBuffers& scene, const SurfaceAtlas& atlas,
                 const TypedBuffer<float4>& records, const Channels& channels, float pixel_size);

  /// Adds the rays of one direction to the records; false when cancelled.
  bool exchange(const Direction& direction);
  void warm_up();

 private:
};

}  // namespace lucarium::bundle
