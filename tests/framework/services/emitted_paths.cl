// SPDX-License-Identifier: Apache-2.0
// Light paths that only start. EIGHT: eight at once, where they can; CHOSEN: from lights chosen otherwise than by the
// scene's table.
#define LUCARIUM_JOINED
#define LUCARIUM_LIGHT_PATH_MIS
#define LUCARIUM_LIGHTS_FROM_TABLE
#define LIGHT_VERTEX_PARAMETERS
#define LIGHT_VERTEX_ARGUMENTS
#ifdef EIGHT
#define LIGHT_PATHS_PLAIN
#endif
#ifdef CHOSEN
#include "lucarium/lights.clh"
uint choose_any_light(const Scene* scene, float u, float* choice) {
  const uint count = scene->scene_info->light_count;
  *choice = 1.0f / (float)count;
  return min((uint)(u * (float)count), count - 1u);
}
#define LIGHT_PATH_CHOOSE(scene, u, low_bits, choice) choose_any_light(scene, u, choice)
#endif
#include "lucarium/services/light_paths/light_paths.clh"

void take_light_vertex(const Scene* scene, const LightVertex* vertex) {}
#ifdef EIGHT
void take_plain_light_vertices(const Scene* scene, const PlainLightVertices8* taken, uint first, uint lanes,
                               bool together) {}
#endif
