// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <vector>

#include "lucarium/scene/gltf/document/document.h"

namespace lucarium::gltf {

/// Appends all materials of the document to the scene, in their order. Textures are decoded for those in `used` only
/// (one flag per material).
void import_materials(const Document& document, const std::vector<bool>& used, Scene& scene, ImportContext& context);

}  // namespace lucarium::gltf
