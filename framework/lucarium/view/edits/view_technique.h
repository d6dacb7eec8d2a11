// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>
#include <utility>
#include <vector>

namespace lucarium {

/// A technique with the parameters that were given; all others have their defaults.
struct ViewTechnique {
  std::string name;
  std::vector<std::pair<std::string, std::string>> parameters;
  bool operator==(const ViewTechnique&) const = default;
};

}  // namespace lucarium
