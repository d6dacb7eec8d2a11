// SPDX-License-Identifier: Apache-2.0
// test_my_technique FOLDER_OF_THE_PLUGIN: a scene whose image is known exactly.
//
// A white convex body of albedo a under a sky of radiance 1 everywhere reflects a: the light of the sky is scattered
// once and nothing shades anything. Replace this by closed forms of your technique; `lucarium check` does the general
// ones.
#include <cmath>
#include <cstdio>

#include "lucarium/scene/load/load_scene.h"
#include "lucarium/session/session.h"

using namespace lucarium;

int main(int argc, char** argv) try {
  if (argc != 2) return 2;
  const TechniqueRegistry registry({argv[1]});
  Scene scene = load_scene("builtin:furnace");
  RenderSettings settings;
  settings.width = settings.height = 32;
  settings.camera = scene.cameras.front();
  RenderSession session(Device::open(), std::move(scene), registry.find("my_technique"), settings);
  session.run({.samples = 16});

  // The body fills the middle of the picture.
  const Film film = session.resolve();
  const std::vector<float> image = film.image();
  double sum = 0;
  for (uint32_t y = 12; y < 20; ++y) {
    for (uint32_t x = 12; x < 20; ++x) sum += image[3 * (y * settings.width + x)];
  }
  const double mean = sum / 64, expected = 0.8;
  std::printf("furnace: %.4f, expected %.4f\n", mean, expected);
  return std::abs(mean - expected) < 0.01 ? 0 : 1;
} catch (const std::exception& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}
