// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <utility>
#include <vector>

#include "lucarium/base/stopwatch.h"
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
  /// {"x", "y", "obstacle", "surface": null | {…}, "sides": [{"technique", "layers": {NAME: [values]},
  /// "insides": [[NAME, text]]}]}: layers from the pictures that were sent last, insides (Technique::inspect) as they
  /// are now, once a second at most unless `last`: no further report may come.
  nlohmann::ordered_json describe(const std::array<std::unique_ptr<ViewSide>, view_sides>& sides, uint32_t count,
                                  bool last);

 private:
  void look_inside(const std::array<std::unique_ptr<ViewSide>, view_sides>& sides, uint32_t count, bool last);

  std::array<InspectedValues, view_sides> insides_;
  Stopwatch since_inside_;
  bool looked_inside_ = false;  ///< since the pixel was asked for
  uint32_t x_ = 0, y_ = 0;
  bool known_ = false;
  std::string obstacle_;
  PixelSurface surface_;
};

}  // namespace lucarium
