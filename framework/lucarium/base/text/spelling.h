// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>
#include <string_view>
#include <utility>

namespace lucarium {

/// "colour" as "color", "centre" as "center": names are taken in both spellings and printed in this one.
inline std::string american_spelling(std::string_view name) {
  std::string result(name);
  for (const auto& [british, american] : {std::pair{"colour", "color"}, std::pair{"centre", "center"}}) {
    for (size_t at = 0; (at = result.find(british, at)) != std::string::npos;)
      result.replace(at, std::string_view(british).size(), american);
  }
  return result;
}

}  // namespace lucarium
