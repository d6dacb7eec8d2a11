// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <memory>

#include "lucarium/compute/schedule/scheduler.h"
#include "lucarium/scene/device/scene_buffers.h"
#include "lucarium/services/interior_surfaces/texel_interior.h"
#include "lucarium/services/layered_raster/layered_raster.h"

namespace lucarium::bundle {

/// How open the parts of slots are: which share of the rays that leave a part goes farther than `open_gap`. A texel has
/// one radiance; what of it is seen, and lights others, are its open parts, so that it is to be theirs: every part
/// counts by its openness, in what is received as in what is sent. Measured by rays of bundles (probe_rows.cl), one
/// bundle at a time.
class SlotOpenness {
 public:
  struct Options {
    float pixel_size = 0.5f;  ///< edge of a film pixel in texel edges
    float open_gap = 2;       ///< in texel edges; 0: all rays are open
  };
  SlotOpenness(Device& device, const SceneBuffers& buffers, const SurfaceAtlas& atlas, const Options& options);
  ~SlotOpenness();

  /// Prepares the bundles. `raster`: for films of safe_pixel() at least.
  void begin(Device& device, KernelScheduler& scheduler, const Program& program, const Scene& scene,
             const SceneBuffers& buffers, const SurfaceAtlas& atlas, const TexelInterior& exposure,
             const LayeredRaster& raster);
  /// When `exposure` is complete: draws the next bundle; false when cancelled, and nothing has changed. Without a gap
  /// only hidden parts are looked for, and no bundle is drawn where there are none.
  bool advance();
  const char* measured() const { return options_.open_gap > 0 ? "openness" : "extent of hidden places"; }
  double progress() const;  ///< what of the bundles has been drawn [1]
  bool complete() const { return complete_; }

  // What holds when complete:
  /// Per slot: mean openness over its area [1], which is what its area counts.
  const TypedBuffer<float>& shares() const { return shares_; }
  /// Per slot: openness of its parts, four words (slot_parts.clh).
  const TypedBuffer<uint32_t>& parts() const { return parts_; }
  /// Per slot: the same of its random points, 4 bits each; 0: hidden, or closed.
  const TypedBuffer<uint32_t>& points() const { return points_; }
  /// Least edge of film pixels, from `pixel_size` on, with which no two work-items reach the same texel at a time [m].
  double safe_pixel() const { return safe_pixel_; }
  static size_t estimate_bytes(size_t slots);

 private:
  struct Probes;
  Options options_;
  TypedBuffer<float> shares_;
  TypedBuffer<uint32_t> parts_;
  TypedBuffer<uint32_t> points_;
  double safe_pixel_ = 0;
  uint64_t drawn_ = 0;  ///< bundles
  bool complete_ = false;
  std::unique_ptr<Probes> probes_;  ///< null before begin() and when complete
};

}  // namespace lucarium::bundle
