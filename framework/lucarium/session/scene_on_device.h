// SPDX-License-Identifier: Apache-2.0
// What sessions share of a scene (share_scene() in session.h).
#pragma once
#include <memory>

#include "lucarium/scene/device/scene_buffers.h"
#include "lucarium/services/bvh/bvh.h"

namespace lucarium {

struct SceneOnDevice {
  Scene scene;
  std::unique_ptr<SceneBuffers> buffers;  ///< null until a session needs them
  std::unique_ptr<Bvh> bvh;               ///< as `buffers`
  int sessions = 0;                       ///< that render it
};

}  // namespace lucarium
