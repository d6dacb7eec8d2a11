// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <map>
#include <string>

#include "lucarium/compute/schedule/scheduler.h"

namespace lucarium {

struct Scene;

/// Halves of texel sides (SideAccessibility), as kernels that keep or look up light by them need to know them
/// (side_halves.clh, side_parts.clh).
struct SideHalves {
  uint32_t sides = 0;             ///< texel sides of the atlas
  uint32_t count = 0;             ///< halves of all of them together: as many as sides, or twice as many
  TypedBuffer<uint32_t> covered;  ///< SideAccessibility::covered()

  bool two() const { return count > sides; }
  /// Binds what SIDE_HALVES_PARAMETERS declare.
  void bind(PassBuilder& pass) const { pass.arg("half_count", count).arg("covered", covered); }
  /// For kernels that are compiled with halves or without.
  std::map<std::string, std::string> defines() const;

  /// How many each texel side has: two where some surface transmits, within a gap.
  static uint32_t per_side(const Scene& scene, float access_gap);
};

}  // namespace lucarium
