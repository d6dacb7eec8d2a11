// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "lucarium/services/interior_surfaces/texel_interior.h"
#include "lucarium/services/layered_raster/layered_raster.h"
#include "lucarium/services/surface_atlas/surface_atlas.h"
#include "lucarium/services/texel_sides/side_accessibility.h"
#include "lucarium/shared/texel_sides.h"

namespace lucarium {

/// Rays between texel sides of many views of one raster (kept_rows.clh), which outlive the schedules: a consumer walks
/// over them again and again without rasterizing, in the order of bundle_pairs.clh, so that it gets the same bits.
/// About one uint per end of a ray at a side. Lengths of gaps are not kept.
class KeptRows {
 public:
  struct Options {
    uint32_t views = 0;   ///< how many there are
    uint32_t height = 0;  ///< of every view [pixels]
    size_t bytes = 0;     ///< for fragments; views beyond it are not kept
    std::string owner;
    std::string remedy;  ///< where memory does not suffice
  };
  /// Halves of texel sides that the ends of rays can name: of more, no rays can be kept.
  static constexpr uint32_t kMaxHalves = 1u << KEPT_HALF_BITS;

  /// All must outlive this; interior and accessibility are complete. `view`: one LayeredView, which keep() rasterizes.
  KeptRows(Device& device, KernelScheduler& scheduler, const LayeredRaster& raster, const SurfaceAtlas& atlas,
           const TexelInterior& interior, const SideAccessibility& accessibility, const TypedBuffer<LayeredView>& view,
           const Options& options);

  /// Keeps the view that is in `view`, if it fits, under a number that has none yet.
  void keep(uint32_t number);
  /// Waits for the device: which views are kept.
  void finish();
  bool has(uint32_t number) const { return !kept_.empty() && kept_[number]; }
  uint32_t kept_views() const;
  size_t used_bytes() const;  ///< of those for fragments

  /// Records a consumer's kernel with LAYERED_KEPT_PARAMETERS (kept_rows.clh), once for even rows of tiles and once for
  /// odd ones, for the view `number`, which must be kept. `bind` binds the kernel's own arguments.
  void record_walk(ScheduleRecorder& recorder, const std::string& name, const Variable<uint32_t>& number,
                   const Program& program, std::string_view kernel,
                   const std::function<void(PassBuilder&)>& bind) const;

  void warm_up();
  /// Expected bytes of so many ends of rays at texel sides.
  static size_t estimate_bytes(double ends) { return static_cast<size_t>(sizeof(uint32_t) * kWordsPerEnd * ends); }

 private:
  static constexpr double kWordsPerEnd = 1.35;  // with headers, and what is black

  KernelScheduler* scheduler_;
  uint32_t rows_;
  TypedBuffer<uint32_t> words_, starts_, counts_, taken_;
  Schedule keep_;
  Variable<uint32_t> number_;
  std::vector<uint8_t> kept_;
};

}  // namespace lucarium
