// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "lucarium/scene/scene.h"

namespace lucarium {

/// A camera that sees all of `bounds` from an elevated three-quarter view.
SceneCamera frame_camera(const Bounds& bounds, float aspect);

}  // namespace lucarium
