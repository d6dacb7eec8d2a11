// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>
#include <string_view>

namespace lucarium {

/// A compiler's log with real files and lines. Some drivers (NVIDIA's) do not heed `#line` and call line 2848 of the
/// text that they were given `<kernel>:2848:`; here it gets the name and the number that `#line` in `source` says.
std::string name_lines(std::string_view log, std::string_view source);

}  // namespace lucarium
