// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <string>
#include <string_view>

namespace lucarium {

/// "1.50 GiB", "64 bytes": for messages.
std::string format_bytes(size_t bytes);

/// "512M" → 536870912. Accepts a decimal number with an optional suffix K, M, G or T (powers of 1024; a further "iB"
/// or "B" is allowed). Throws Error{usage} that names `what` for anything else.
size_t parse_bytes(std::string_view text, std::string_view what);

}  // namespace lucarium
