// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace lucarium {

/// Names the form of comparison files (docs/comparisons.md).
inline constexpr const char* comparison_schema = "lucarium-comparison-1";

}  // namespace lucarium
