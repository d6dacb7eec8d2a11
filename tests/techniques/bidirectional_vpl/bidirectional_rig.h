// SPDX-License-Identifier: Apache-2.0
// Pictures of bidirectional_vpl and of its reference, and their agreement.
#pragma once
#include <doctest/doctest.h>

#include <string>
#include <utility>
#include <vector>

#include "closed_forms.h"
#include "device_fixture.h"
#include "lucarium/conformance/block_comparison.h"
#include "lucarium/scene/load/load_scene.h"
#include "lucarium/session/session.h"
#include "made_scene.h"
#include "registry.h"

namespace lucarium::test {

inline constexpr uint32_t kSeeds = 8;  ///< of pictures that are compared

using Parameters = std::vector<std::pair<std::string, std::string>>;

struct Picture {
  uint32_t width = 40, height = 32;
  int max_bounces = 3;
  uint64_t iterations = 8, seed = 1;
  uint32_t pixel_sampling = LUCARIUM_PIXEL_JITTER;
};

inline RenderSettings settings_of(const Scene& scene, const Picture& picture) {
  RenderSettings settings;
  settings.width = picture.width;
  settings.height = picture.height;
  settings.max_bounces = picture.max_bounces;
  settings.seed = picture.seed;
  settings.pixel_sampling = picture.pixel_sampling;
  settings.camera = scene.cameras.front();
  return settings;
}

inline Film render(const Scene& scene, const std::string& technique, const Picture& picture,
                   const Parameters& parameters = {}, const std::shared_ptr<Device>& device = test_device()) {
  RenderSession session(device, scene, registry().find(technique), settings_of(scene, picture), parameters);
  session.run({.iterations = picture.iterations});
  return session.resolve();
}

/// `count` independent pictures, of the seeds from `picture.seed` on. What does not depend on the seed is prepared
/// once.
inline std::vector<Film> films(const Scene& scene, const std::string& technique, const Picture& picture,
                               const Parameters& parameters, uint32_t count) {
  RenderSession session(test_device(), scene, registry().find(technique), settings_of(scene, picture), parameters);
  std::vector<Film> films;
  for (uint32_t i = 0; i < count; ++i) {
    if (i > 0) session.restart(picture.seed + i);
    session.run({.iterations = picture.iterations});
    films.push_back(session.resolve());
  }
  return films;
}

/// Inside a white sphere of radius 2 with a point light of 1 cd; the camera looks at its inside.
inline Scene sphere_room(float albedo, const glm::vec3& light) {
  Scene scene;
  scene.source = "test:sphere";
  add_triangles(scene, sphere_triangles(glm::vec3(0), 2, 5, true), add_material(scene, lambert(albedo)));
  add_light(scene, LightType::point, 1, light, {0, -1, 0});
  SceneCamera camera;
  camera.yfov = 1;
  camera.world_from_camera = glm::inverse(glm::lookAt(glm::vec3(0, 0, 1), glm::vec3(0.3f, 0.1f, -1), {0, 1, 0}));
  scene.cameras.push_back(camera);
  return scene;
}

/// The sum of the additive layers.
inline std::vector<float> image_of(const Film& film) {
  std::vector<float> sum;
  for (const FilmLayer& layer : film.layers()) {
    if (!layer.additive) continue;
    sum.resize(layer.pixels.size());
    for (size_t i = 0; i < sum.size(); ++i) sum[i] += layer.pixels[i];
  }
  return sum;
}

inline double mean_of(const std::vector<float>& values) {
  double sum = 0;
  for (const float value : values) sum += static_cast<double>(value);
  return sum / static_cast<double>(values.size());
}

/// Independent pictures, by seed.
inline std::vector<std::vector<float>> pictures(const Scene& scene, const std::string& technique, Picture picture,
                                                const Parameters& parameters, uint32_t count) {
  picture.seed = 1000;
  std::vector<std::vector<float>> images;
  for (const Film& film : films(scene, technique, picture, parameters, count)) images.push_back(image_of(film));
  return images;
}

/// The mean of a layer in each of `count` independent pictures, of the seeds from `first_seed` on.
inline std::vector<double> layer_means(const Scene& scene, const std::string& technique, Picture picture,
                                       const std::string& layer, const Parameters& parameters, uint64_t first_seed,
                                       uint32_t count = kSeeds) {
  picture.seed = first_seed;
  std::vector<double> means;
  for (const Film& film : films(scene, technique, picture, parameters, count))
    means.push_back(mean_of(film.find(layer)->pixels));
  return means;
}

/// The mean of the layer `indirect`, over seeds.
inline Estimate indirect(const Scene& scene, const Picture& picture, const Parameters& parameters) {
  return estimate_of(layer_means(scene, "bidirectional_vpl", picture, "indirect", parameters, 30));
}

/// Blocks of 8 x 8 pixels and the image's mean agree with path_tracing of the same paths.
inline void check_agreement(const std::string& name, const Scene& scene, const Picture& picture,
                            const Parameters& parameters, const Parameters& reference, uint32_t count) {
  INFO(name);
  Picture other = picture;
  other.iterations *= 4;
  const check::BlockTest test =
      check::compare_blocks(pictures(scene, "bidirectional_vpl", picture, parameters, count),
                            pictures(scene, "path_tracing", other, reference, count), picture.width, picture.height);
  MESSAGE(name << ": " << test.describe(0));
  CHECK(test.passes(0));
}

}  // namespace lucarium::test
