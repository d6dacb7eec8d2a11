// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>

#include "lucarium/technique/state_file.h"

namespace lucarium {

/// The header's text, JSON, and back. Throws Error{input} that says what is missing or wrong.
std::string state_header_text(const StateHeader& header);
StateHeader parse_state_header(const std::string& text);

}  // namespace lucarium
