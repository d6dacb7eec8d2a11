// SPDX-License-Identifier: Apache-2.0
// test_instant_radiosity FOLDER_OF_THE_PLUGIN: a scene whose direct and indirect light are known exactly.
//
// A point light of intensity I in the middle of a sphere of radius R and albedo ρ lights all of it by E = I/R². In a
// sphere every point sees every other by G = 1/(4R²), so that each bounce brings ρ times the light before it:
// direct light is ρ E/π at every pixel, the one bounce ρ² E/π.
#include <cmath>
#include <cstdio>

#include "lucarium/scene/builtin/builder.h"
#include "lucarium/session/session.h"

using namespace lucarium;

namespace {

constexpr float albedo = 0.6f, radius = 2, intensity = 10;

Scene make_scene() {
  Scene scene;
  scene.source = "test:sphere";
  MeshBuilder builder("sphere");
  for (const auto& t : icosphere(5)) builder.triangle(radius * t[0], radius * t[2], radius * t[1]);  // seen from inside
  add_instance(scene, add_mesh(scene, builder.take()), add_lambert(scene, "grey", glm::vec3(albedo)));
  SceneLight light;
  light.intensity = glm::vec3(intensity);
  scene.lights = {light};
  scene.cameras.emplace_back().world_from_camera[3] = glm::vec4(0, 0, 1, 1);
  return scene;
}

double mean(const FilmLayer& layer) {
  double sum = 0;
  for (const float value : layer.pixels) sum += double{value};
  return sum / static_cast<double>(layer.pixels.size());
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc != 2) return 2;
  const TechniqueRegistry registry({argv[1]});
  Scene scene = make_scene();
  RenderSettings settings;
  settings.width = settings.height = 32;
  settings.camera = scene.cameras.front();
  RenderSession session(Device::open(), std::move(scene), registry.find("instant_radiosity"), settings);
  session.run({.samples = 8});

  const Film film = session.resolve();
  const double direct = static_cast<double>(albedo) * intensity / (radius * radius) / 3.14159265358979;
  int wrong = 0;
  for (const auto& [layer, expected] :
       {std::pair{"direct", direct}, {"indirect", static_cast<double>(albedo) * direct}}) {
    const double found = mean(*film.find(layer));
    std::printf("%s: %.5f, expected %.5f\n", layer, found, expected);
    wrong += !(std::abs(found / expected - 1) < 0.01);  // facets of the sphere
  }
  return wrong;
} catch (const std::exception& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}
