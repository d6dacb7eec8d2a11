// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "lucarium/scene/gltf/document/context.h"

namespace lucarium::gltf {

/// Names for reports, sorted: declared or found anywhere, and those of them that have no effect.
struct ExtensionLists {
  std::vector<std::string> used, ignored;
};

/// Refuses required extensions that cannot be done without, by name and with a remedy; warns about ignored ones and
/// about those that the file uses without declaring them. Works on unchecked JSON, so that an unknown extension is
/// named before anything it changes is complained about.
ExtensionLists check_extensions(const nlohmann::json& root, ImportContext& context);

}  // namespace lucarium::gltf
