// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <memory>
#include <string>

#include "lucarium/compute/schedule/scheduler.h"
#include "lucarium/scene/device/scene_buffers.h"
#include "lucarium/services/interior_surfaces/texel_interior.h"
#include "lucarium/services/layered_raster/layered_raster.h"
#include "lucarium/services/texel_sides/side_halves.h"

namespace lucarium {

/// How accessible the parts of texel sides are: a(x), the share of the rays from place x that go farther than a gap g,
/// `access_gap`.
///
/// A texel has one radiance, but brightness and visibility vary together within it: places close to an occluder are
/// both darker and seen less. A ray from x reaches far receivers with probability a(x), so what they get of a texel of
/// area A, and what the plain mean gives them, are
///
///   ∫ a L dx  and  ∫ a dx · ∫ L dx / A,
///
/// which is too little wherever a and L grow together. The mean weighted by a, ∫ a L dx / ∫ a dx, is right; likewise
/// for what the texel receives, since its open places are what is displayed and sent on. So each ray counts by the a of
/// the part that receives it, each light sample by that of its point, and areas in errors and interpolation by the mean
/// of a. The balance of power sums rays as they are weighted and needs no areas. This is the projection of L on
/// constants in the inner product ∫ a u v dx: uniform fields stay exact, and so does the balance.
///
/// The price: rays shorter than g get the radiance that is right for far receivers, so places close to an occluder
/// receive too much; they count little in the result.
///
/// With two `halves`, surfaces that transmit occlude nothing: what is close under glass is seen through it. But the
/// light below glass often ends at a sharp edge, with the shadow of the lamp beside it, and only one of them is seen at
/// a time. Texel sides therefore have two halves then, whose light is kept apart: a part belongs to the covered half
/// where most of its rays meet a surface that transmits within the gap (2 edges, if it is automatic: those that lie
/// farther off share their light with open ones), else to the open one. What is kept per texel side is then there
/// twice, first for all open halves, then for all covered ones.
///
/// Measured by rays of bundles (probe_pairs.cl), one bundle at a time, for the parts of side_parts.clh. Two or so rays
/// per part suffice, and two bits to store it, rounded at random: the mean needs a to be right on average only.
class SideAccessibility {
 public:
  struct Options {
    float pixel_size = 0.5f;  ///< edge of a bundle pixel in texel edges
    float access_gap = -1;    ///< in texel edges; 0: all rays are open; below 0: automatic_gap(), below glass 2
    int rays = 256;           ///< of a texel that faces all directions
    uint32_t halves = 1;      ///< of each texel side, with `access_gap`: SideHalves::per_side()
  };
  /// Bundles that give a texel which faces all directions so many rays, within what is sensible.
  static double bundles(float pixel_size, int rays);
  /// In texel edges: 8, but no more than a tenth of the scene's diameter, where next to no ray goes farther, and no
  /// less than 2.
  static float automatic_gap(double diameter, float texel_edge);
  /// `owner` pays for the memory; `remedy` is what a message about too little of it advises. All must outlive this.
  SideAccessibility(Device& device, const SceneBuffers& buffers, const SurfaceAtlas& atlas, const Options& options,
                    const std::string& owner, const std::string& remedy);
  ~SideAccessibility();

  /// Prepares the bundles. `raster`: for bundle images of safe_pixel() at least.
  void begin(Device& device, KernelScheduler& scheduler, const Scene& scene, const SceneBuffers& buffers,
             const SurfaceAtlas& atlas, const TexelInterior& interior, const LayeredRaster& raster);
  /// When `interior` is complete: draws the next bundle; false when cancelled, and nothing has changed. Without a gap
  /// only hidden parts are looked for, and no bundle is drawn where there are none.
  bool advance();
  const char* measured() const { return options_.access_gap != 0 ? "accessibility" : "extent of hidden places"; }
  double progress() const;  ///< share of the bundles that are drawn [1]
  bool complete() const { return complete_; }

  // What holds when complete:
  /// Options::halves with a gap, else 1.
  uint32_t halves() const { return halves_; }
  SideHalves side_halves() const { return {sides_, halves_ * sides_, covered_}; }
  /// Per texel side, of its halves: mean accessibility over its area [1], which is what its area counts.
  const TypedBuffer<float>& shares() const { return shares_; }
  /// Per texel side: accessibility of its parts, four words (side_parts.clh).
  const TypedBuffer<uint32_t>& parts() const { return parts_; }
  /// Per texel side: which of its parts belong to the covered half, two words; without halves nothing.
  const TypedBuffer<uint32_t>& covered() const { return covered_; }
  /// Per texel side: accessibility of its random points, 4 bits each; 0: hidden, or closed (side_points.clh).
  const TypedBuffer<uint32_t>& points() const { return points_; }
  /// Least edge of bundle pixels, from `pixel_size` on, with which no two work-items reach the same texel at a time
  /// [m].
  double safe_pixel() const { return safe_pixel_; }
  /// Device memory while it measures, and what stays of it [bytes].
  static size_t estimate_bytes(size_t sides, uint32_t halves = 1);
  static size_t held_bytes(size_t sides, uint32_t halves = 1);

 private:
  struct Probes;
  Options options_;
  std::string owner_, remedy_;
  uint32_t sides_, halves_;
  TypedBuffer<float> shares_;
  TypedBuffer<uint32_t> parts_;
  TypedBuffer<uint32_t> covered_;
  TypedBuffer<uint32_t> points_;
  double safe_pixel_ = 0;
  uint64_t drawn_ = 0;  ///< bundles
  bool complete_ = false;
  std::unique_ptr<Probes> probes_;  ///< null before begin() and when complete
};

}  // namespace lucarium
