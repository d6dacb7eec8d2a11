// SPDX-License-Identifier: Apache-2.0
// Tinted glass as bundle_exchange sees it, against path tracing: lamps, lit walls and light on its way through a block
// that absorbs, and through a pane without thickness, which does not.
#include <doctest/doctest.h>

#include "made_scene.h"
#include "technique_rig.h"
#include "tolerance.h"

using namespace lucarium;
using namespace lucarium::test;

namespace {

/// A white room whose floor is lit by a lamp below its ceiling, and between them a block (or pane) of glass, through
/// which the camera looks down at half of the floor and at a lamp that lies there. `tinted`: red is absorbed in it.
Scene room_with_glass(bool thin, bool tinted, float roughness) {
  Scene scene;
  const int wall = add_material(scene, lambert(0.6f)), lamp = add_material(scene, emitter(8, 0.3f));
  SceneMaterial glass;
  glass.base_color = glm::vec4(1);
  glass.metallic = 0;
  glass.roughness = roughness;
  glass.ior = 1.2f;
  glass.transmission = 1;
  glass.thickness = thin ? 0.f : 1.f;
  if (tinted) {
    glass.attenuation_color = glm::vec3(0.3f, 0.9f, 1);
    glass.attenuation_distance = 0.15f;
  }
  const int block = add_material(scene, glass);
  test::add_box(scene, {0, 0, 0}, {1, 1, 1}, true, wall);
  add_horizontal(scene, 0.5f, 0.98f, 0.5f, 0.4f, 0.4f, false, lamp);
  add_horizontal(scene, 0.35f, 0.01f, 0.45f, 0.3f, 0.4f, true, add_material(scene, emitter(4, 0.3f)));
  if (thin)
    add_horizontal(scene, 0.35f, 0.4f, 0.5f, 0.5f, 0.8f, true, block);
  else
    test::add_box(scene, {0.1f, 0.3f, 0.1f}, {0.6f, 0.45f, 0.9f}, false, block);
  SceneCamera camera;
  camera.world_from_camera = glm::inverse(glm::lookAt(glm::vec3(0.5f, 0.9f, 0.93f), {0.5f, 0, 0.45f}, {0, 0, -1}));
  scene.cameras.push_back(camera);
  return scene;
}

/// Over all pixels.
struct ColorSum {
  double red, green;
};

std::map<std::string, ColorSum> layers(const std::string& technique, const Scene& scene, uint64_t iterations,
                                       const Options& options) {
  const auto run = session(technique, scene, 2, options);
  run->run({.iterations = iterations});
  std::map<std::string, ColorSum> result;
  const Film film = run->resolve();
  for (const char* name : {"emission", "direct", "indirect"}) {
    const FilmLayer* layer = film.find(name);
    if (!layer) continue;
    ColorSum& light = result[name];
    for (size_t i = 0; i < layer->pixels.size(); i += 3)
      light.red += layer->pixels[i], light.green += layer->pixels[i + 1];
  }
  return result;
}

}  // namespace

TEST_CASE("tinted glass absorbs what is seen and lit through it as in path tracing, panes absorb nothing") {
  struct Glass {
    bool thin, tinted;
    float roughness;
  };
  for (const auto& [thin, tinted, roughness] :
       {Glass{false, false, 0}, Glass{false, true, 0}, Glass{false, true, 0.3f}, Glass{true, true, 0}}) {
    CAPTURE(thin);
    CAPTURE(tinted);
    CAPTURE(roughness);
    const Scene scene = room_with_glass(thin, tinted, roughness);
    const auto expected = layers("path_tracing", scene, 12, {{"samples_per_iteration", "64"}});
    const auto found = layers("bundle_exchange", scene, 48, with(few_texels, {{"texels", "4096"}}));
    for (const char* layer : {"emission", "direct", "indirect"}) {
      CAPTURE(layer);
      const ColorSum light = found.at(layer), reference = expected.at(layer);
      MESSAGE(std::string(layer), ": red ", light.red, " of ", reference.red, ", green ", light.green, " of ",
              reference.green);
      // Seen through rough glass, lamps are indirect light.
      if (reference.red == 0) continue;
      CHECK(light.red == relative(reference.red, 0.03));
      CHECK(light.green == relative(reference.green, 0.03));
      if (thin) CHECK(light.red == relative(light.green, 1e-4));
    }
    if (tinted && !thin) CHECK(found.at("indirect").red < 0.8 * found.at("indirect").green);
  }
}
