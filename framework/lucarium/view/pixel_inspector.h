// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "lucarium/view/inspect/pixel_surface.h"
#include "lucarium/view/view_side.h"

namespace lucarium {

/// What there is at the pixel that a page has clicked.
class PixelInspector {
 public:
  /// Finds the surface at the request's pixel.
  void look(const ViewSurroundings& around, SceneOnDevice& scene);
  /// The camera has moved: the pixel stays, its surface has to be found again.
  void forget() { known_ = false; }
  /// {"x", "y", "obstacle", "surface": null | {…}, "sides": [{"technique", "layers": {NAME: [values]}}]}, from the
  /// pictures that were sent last.
  nlohmann::ordered_json describe(const std::array<std::unique_ptr<ViewSide>, view_sides>& sides, uint32_t count) const;

 private:
  uint32_t x_ = 0, y_ = 0;
  bool known_ = false;
  std::string obstacle_;
  PixelSurface surface_;
};

}  // namespace lucarium
