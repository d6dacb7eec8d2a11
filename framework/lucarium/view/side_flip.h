// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <optional>
#include <string>

#include "lucarium/base/stopwatch.h"

namespace lucarium {

class ViewSide;

/// FLIP between the two sides, the first one as the reference, at a small share of the time.
class SideFlip {
 public:
  /// The map as a picture of that number (picture_code.h; header: "flip", the mean), where both sides have a new whole
  /// one and the last measurement is long enough ago. `exposure`: of the scene; NaN: what suits the first picture.
  std::optional<std::string> between(const ViewSide& first, const ViewSide& second, float exposure, uint64_t number);

 private:
  uint64_t first_ = 0, second_ = 0;  ///< numbers of the pictures that were measured
  double cost_ = 0;                  ///< of the last measurement [s]
  Stopwatch since_;
};

}  // namespace lucarium
