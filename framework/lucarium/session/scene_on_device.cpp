// SPDX-License-Identifier: Apache-2.0
#include "lucarium/session/scene_on_device.h"

#include "lucarium/session/session.h"

namespace lucarium {

std::shared_ptr<SceneOnDevice> share_scene(Scene scene) {
  auto shared = std::make_shared<SceneOnDevice>();
  shared->scene = std::move(scene);
  return shared;
}

}  // namespace lucarium
