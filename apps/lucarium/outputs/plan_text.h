// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>
#include <utility>
#include <vector>

namespace lucarium::app {

/// What --dry-run prints: plans by name, each a text for people; as JSON the schema is lucarium-plan-1.
void print_plans(const std::vector<std::pair<std::string, std::string>>& plans, bool json);

}  // namespace lucarium::app
