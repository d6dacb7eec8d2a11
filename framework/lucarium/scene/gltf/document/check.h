// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "lucarium/scene/gltf/document/context.h"

namespace lucarium::gltf {

/// asset.version and minVersion; comes before everything else, for glTF 1.0 differs in structure.
void check_version(const nlohmann::json& root, const ImportContext& context);

/// Buffer views against their buffers and accessors against their views, in 64-bit arithmetic that cannot overflow.
/// The structure must have been checked.
void check_layout(const nlohmann::json& root, const ImportContext& context);

/// Node graph: no cycle, no second parent, scenes list roots only; returns every node's parent.
std::vector<int> check_nodes(const nlohmann::json& root, ImportContext& context);

/// References inside animations, cameras and lights that rules cannot express.
void check_details(const nlohmann::json& root, ImportContext& context);

/// Bytes of one accessor element: columns of matrices start at multiples of 4 (glTF 2.0, section 3.6.2.4).
uint64_t element_bytes(int component_type, std::string_view type);
uint64_t component_bytes(int component_type);

}  // namespace lucarium::gltf
