// SPDX-License-Identifier: Apache-2.0
// test_ambient_occlusion FOLDER_OF_THE_PLUGIN: two scenes whose accessibility is known exactly.
#include <cstdio>

#include "lucarium/scene/load/load_scene.h"
#include "lucarium/session/session.h"

using namespace lucarium;

namespace {

/// Number of pixels of the scene whose accessibility is not `expected` after a few samples.
int count_wrong(const TechniqueType& type, const char* scene_name, const char* distance, float expected) {
  Scene scene = load_scene(scene_name);
  RenderSettings settings;
  settings.width = settings.height = 48;
  settings.camera = scene.cameras.front();
  RenderSession session(Device::open(), std::move(scene), type, settings, {{"distance", distance}});
  session.run({.iterations = 8});
  int wrong = 0;
  const Film film = session.resolve();
  for (const float value : film.find("ambient_occlusion")->pixels) wrong += value != expected;
  std::printf("%s, distance %s: %d values are not %g\n", scene_name, distance, wrong, static_cast<double>(expected));
  return wrong;
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc != 2) return 2;
  const TechniqueRegistry registry({argv[1]});
  const TechniqueType& type = registry.find("ambient_occlusion");
  // A convex body occludes nothing of itself; in a closed room every long ray ends at a wall.
  return count_wrong(type, "builtin:furnace", "10", 1) + count_wrong(type, "builtin:room", "10", 0) > 0 ? 1 : 0;
} catch (const std::exception& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}
