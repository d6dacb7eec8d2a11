// SPDX-License-Identifier: Apache-2.0
#include "lucarium/scene/device/specular_albedo.h"

namespace lucarium {

std::vector<float> specular_albedo_table() {
  static const float values[] = {
#include "specular_albedo_values.inc"
  };
  return {std::begin(values), std::end(values)};
}

}  // namespace lucarium
