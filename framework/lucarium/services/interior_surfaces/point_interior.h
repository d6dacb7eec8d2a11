// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "lucarium/compute/schedule/scheduler.h"
#include "lucarium/services/interior_surfaces/interior_walks.h"
#include "lucarium/services/primitives/primitives.h"
#include "lucarium/shared/interior_point.h"

namespace lucarium {

/// Which points of surfaces are interior (interior_walks.h), for points that the host has.
class PointInterior {
 public:
  /// `owner` pays for the memory; `remedy` is what a message about too little of it advises.
  PointInterior(Device& device, KernelScheduler& scheduler, const SceneBuffers& scene, const Intersector& intersector,
                const InteriorRule& rule, std::string owner, const char* remedy);

  using Progress = std::function<void(double fraction)>;  ///< may be empty
  enum class Side { own, behind };                        ///< of points, INTERIOR_BACK included
  /// Per point, whether one of `walks` walks from that side escapes; points that are `known` to be open are left out.
  /// `known` may be empty. Throws Error{interrupted}.
  std::vector<bool> are_open(std::span<const InteriorPoint> points, std::span<const uint8_t> known, Side side,
                             uint32_t walks, const Progress& progress) const;
  static size_t estimate_bytes(size_t points);

 private:
  std::vector<uint8_t> walk(std::span<const InteriorPoint> points, std::span<const uint8_t> known, Side side,
                            uint32_t walks, const Progress& progress) const;
  Device& device_;
  KernelScheduler& scheduler_;
  const SceneBuffers& scene_;
  const Intersector& intersector_;
  InteriorRule rule_;
  Program program_;
  Primitives primitives_;
  std::string owner_;
  const char* remedy_;
};

}  // namespace lucarium
