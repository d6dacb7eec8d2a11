// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "lucarium/scene/gltf/model/accessor.h"

namespace lucarium::gltf {

/// All animations; nodes and instances must be there (morph targets are counted).
void import_animations(const Document& document, Scene& scene, ImportContext& context);

}  // namespace lucarium::gltf
