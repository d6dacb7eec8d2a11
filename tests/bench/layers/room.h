// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "lucarium/scene/scene.h"

namespace lucarium::bench {

/// A closed room of about 70 000 triangles: subdivided walls, spheres and boxes.
Scene make_full_room();

}  // namespace lucarium::bench
