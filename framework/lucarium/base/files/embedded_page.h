// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "lucarium/base/files/embedded_files.h"

namespace lucarium {

/// A page with every "@include NAME@" replaced by the text of that name, from the first of the sets that has it.
std::string assemble_page(std::string_view source, const std::vector<const EmbeddedSources*>& assets);

}  // namespace lucarium
