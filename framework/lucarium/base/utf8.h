// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string_view>

namespace lucarium {

/// Whether JSON and file headers can hold the text.
bool is_utf8(std::string_view text);

}  // namespace lucarium
