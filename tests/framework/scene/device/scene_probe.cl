// SPDX-License-Identifier: Apache-2.0
#include "lucarium/shared/scene_types.h"

kernel void probe(global const SceneInfo* scene_info, global const Light* scene_lights, global uint* result) {
  result[0] = scene_info->triangle_count;
  result[1] = scene_info->instance_count;
  result[2] = scene_info->light_count;
  result[3] = scene_lights[scene_info->environment_light].kind;
}
