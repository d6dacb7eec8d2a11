// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <map>
#include <string>
#include <vector>

#include "bidirectional_vpl/base/plan.h"
#include "bidirectional_vpl/bundles/kept_bundles.h"
#include "lucarium/services/layered_raster/layered_raster.h"
#include "lucarium/services/primitives/primitives.h"
#include "lucarium/shared/ray.h"

namespace lucarium::bidirectional {

/// Camera paths' rays along bundles, and what they are to meet.
struct BundleRays {
  BufferRef rays, queue, active, states;  ///< as EyePaths has them
  BufferRef hits;                         ///< written for rays whose state names a bundle
};

/// Edges of camera paths along bundles that are rasterized (bundle_mode): for each depth, the bundles that some path
/// takes, one after the other.
///
///   prepare   key, sort       rays by their bundle
///             bounds          box of the points that look, and a view for each bundle
///   bundles   LayeredRaster   all fragments of the view of one bundle
///   look up   look_up_bundle  its rays -> hits
///   keep      keep_bundle     the same for later depths (reuse=shared), which look up alone
class BundleEdges {
 public:
  /// `scene` must outlive this; `owner` pays for the memory.
  BundleEdges(Device& device, KernelScheduler& scheduler, const SceneBuffers& scene, const Plan& plan,
              const BundleRays& rays, const std::string& owner);

  /// Finds what the rays meet that left the vertices of `depth` (EyePathState::segment there). False when cancelled.
  bool trace(uint32_t seed, uint32_t sample, uint32_t depth);
  /// Follows a change of the scene. False where schedules must be recorded again.
  bool update();
  void warm_up();
  /// Counts the iteration, once it is complete.
  void complete();
  /// Of complete iterations since clear_counters(): bundles that were rasterized, their fragments, and bundles that
  /// were looked up again instead.
  std::map<std::string, double> counters() const;
  void clear_counters() { totals_ = {}; }
  static size_t estimate_bytes(const Plan& plan, size_t triangles);

 private:
  struct Counts {
    double bundles = 0, fragments = 0, again = 0;
  };

  void record_prepare(const BundleRays& rays);
  void record_bundle(const BundleRays& rays);
  void record_again(const BundleRays& rays);
  /// `start`, `fragment`: where the bundle begins in `stored`.
  template <class Base>
  void add_look_up(ScheduleRecorder& recorder, const BundleRays& rays, const Variable<uint32_t>& number,
                   const LayeredRaster::Stored& stored, const Base& start, const Base& fragment);
  bool look_up(uint32_t k);

  KernelScheduler& scheduler_;
  const SceneBuffers& scene_;
  Plan plan_;
  std::string owner_;
  Primitives primitives_;
  LayeredRaster raster_;
  uint64_t generation_;
  Program program_;
  TypedBuffer<LayeredView> views_;
  TypedBuffer<uint32_t> keys_, order_, left_, starts_;
  std::optional<KeptBundles> kept_;  ///< reuse=shared
  Schedule prepare_, bundle_, again_;
  Variable<uint32_t> seed_, sample_, depth_;
  Variable<uint32_t> number_, entry_, first_;                       ///< of bundle_
  Variable<uint32_t> again_number_, again_start_, again_fragment_;  ///< of again_
  std::vector<uint32_t> ranges_;                                    ///< starts_ of this depth, read back
  uint32_t total_ = 0;                                              ///< fragments of the last bundle
  Counts totals_, new_;                                             ///< new_: of this iteration
};

}  // namespace lucarium::bidirectional
