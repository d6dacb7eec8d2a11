// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "bidirectional_vpl/base/plan.h"
#include "lucarium/services/layered_raster/layered_raster.h"

namespace lucarium::bidirectional {

/// Stored bundles of an iteration that later depths of its camera paths look up again, without a rasterization
/// (reuse=shared; Tokuyoshi and Ogaki 2012, section 7). As many as fit the memory; the others are rasterized again.
class KeptBundles {
 public:
  /// Where a bundle stands: its entry among the starts of pixels, and its first fragment.
  struct Place {
    uint32_t entry = 0, first = 0;
  };

  /// `owner` pays for the memory; of a plan of which estimate_bytes() says that something fits.
  KeptBundles(Device& device, const Plan& plan, const std::string& owner);

  /// Copies what was just stored to `entry` and `first`, where it fits.
  void record_keep(ScheduleRecorder& recorder, const Program& program, const LayeredRaster::Stored& stored,
                   const Variable<uint32_t>& entry, const Variable<uint32_t>& first) const;
  BufferRef starts() const { return starts_; }
  BufferRef fragments() const { return fragments_; }

  /// Begins an iteration: nothing is kept.
  void clear();
  /// Where the next bundle goes.
  Place next() const { return next_; }
  /// Bundle k of so many fragments was stored at next().
  void stored(uint32_t k, uint32_t fragments);
  /// Nothing where bundle k is not kept.
  std::optional<Place> find(uint32_t k) const { return places_[k]; }

  /// 0 where not even one bundle fits.
  static size_t estimate_bytes(const Plan& plan);

 private:
  uint32_t pixels_, entries_, capacity_;  ///< of a bundle; bundles; fragments
  TypedBuffer<uint32_t> starts_;
  TypedBuffer<LayeredFragment> fragments_;
  std::vector<std::optional<Place>> places_;
  Place next_;
};

}  // namespace lucarium::bidirectional
