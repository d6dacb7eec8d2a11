// SPDX-License-Identifier: Apache-2.0
// Closed forms by one strategy alone: virtual lights in a closed sphere, where every connection brings the same, and
// ray-bundles under a sky.
#include "bidirectional_rig.h"
#include "tolerance.h"

using namespace lucarium;
using namespace lucarium::test;

TEST_CASE("in a sphere, virtual lights alone give each bounce albedo^k I / R^2, wherever the light is") {
  // Connections carry c1 c3 / d^2 = 1 / 4 R^2 everywhere, so that only facets and the choice of light paths are noise.
  const float albedo = 0.6f;
  ClosedForms table;
  for (const glm::vec3& place : {glm::vec3(0), glm::vec3(0.9f, 0.2f, -0.4f), glm::vec3(0, -1.9f, 0.1f)}) {
    const Scene scene = sphere_room(albedo, place);
    for (int bounces = 1; bounces <= 3; ++bounces) {
      Picture picture;
      picture.width = picture.height = 16;
      picture.max_bounces = bounces;
      picture.iterations = full_run() ? 256 : 16;
      const std::vector<double> means = layer_means(scene, "bidirectional_vpl", picture, "indirect",
                                                    {{"strategy", "vpl"}, {"light_paths", "512"}}, 10);
      // Radiance rho E / pi; E_0 of the point light is not uniform, all further bounces are: I / R^2 rho^k.
      double expected = 0;
      for (int k = 1; k <= bounces; ++k) expected += std::pow(double{albedo}, k + 1) / (4 * M_PI);
      // Facets of the sphere: 5 levels leave 0.1 percent of the radius.
      table.add("light at " + std::to_string(place.y) + ", " + std::to_string(bounces) + " bounces", estimate_of(means),
                expected, 3e-3 * expected);
    }
  }
  table.check(0.01);
}

TEST_CASE("in a sphere each of few virtual lights counts alike, whatever the number of candidates") {
  // The table has blocks of eight: numbers of lights and of candidates are below, at and above such blocks.
  const float albedo = 0.6f;
  const Scene scene = sphere_room(albedo, glm::vec3(0));
  ClosedForms table;
  for (const auto& [light_paths, candidates] :
       {std::pair(1, 1), {2, 8}, {3, 3}, {3, 8}, {3, 32}, {5, 5}, {5, 11}, {11, 8}, {11, 256}}) {
    Picture picture;
    picture.width = picture.height = 16;
    picture.max_bounces = 4;
    picture.iterations = full_run() ? 256 : 32;
    const std::vector<double> means = layer_means(scene, "bidirectional_vpl", picture, "indirect",
                                                  {{"strategy", "vpl"},
                                                   {"light_vertices", "3"},
                                                   {"light_paths", std::to_string(light_paths)},
                                                   {"candidates", std::to_string(candidates)}},
                                                  40);
    double expected = 0;
    for (int k = 1; k <= picture.max_bounces; ++k) expected += std::pow(double{albedo}, k + 1) / (4 * M_PI);
    table.add(std::to_string(light_paths) + " light paths, " + std::to_string(candidates) + " candidates",
              estimate_of(means), expected, 3e-3 * expected);
  }
  table.check(0.02);
}

TEST_CASE("a bundle that serves both sides of surfaces has half the second moment of one that serves one side") {
  // Under a sky of radiance 1 a sample of a floor is rho cos / pi over the density: 2 rho cos with 1 / 2 pi; 4 rho cos
  // with 1 / 4 pi, and nothing in the other hemisphere. The mean of cos^2 is 1/3.
  const float albedo = 0.8f;
  Scene scene;
  scene.source = "test:floor";
  add_triangles(scene, {{-9, 0, 9}, {9, 0, 9}, {9, 0, -9}, {-9, 0, 9}, {9, 0, -9}, {-9, 0, -9}},
                add_material(scene, lambert(albedo)));
  scene.environment = Environment{};
  SceneCamera camera;
  camera.yfov = 0.5f;
  camera.world_from_camera = glm::inverse(glm::lookAt(glm::vec3(0, 2, 0), glm::vec3(0), {0, 0, -1}));
  scene.cameras.push_back(camera);
  Picture picture;
  picture.width = picture.height = 64;
  picture.max_bounces = 0;
  picture.iterations = 1;
  ClosedForms table;
  for (const auto& [sides, second_moment] : {std::pair{"two", 4.0 / 3}, std::pair{"one", 8.0 / 3}}) {
    std::vector<double> means, squares;
    picture.seed = 20;
    for (const Film& film :
         films(scene, "bidirectional_vpl", picture,
               {{"strategy", "hit"}, {"directions", "bundle"}, {"bundles", "4096"}, {"bundle_sides", sides}}, 8)) {
      std::vector<float> values = film.find("direct")->pixels;
      means.push_back(mean_of(values));
      for (float& value : values) value *= value;
      squares.push_back(mean_of(values));
    }
    const double rho = double{albedo};
    table.add(std::string("mean, sides served: ") + sides, estimate_of(means), rho, 1e-4);
    table.add(std::string("second moment, sides served: ") + sides, estimate_of(squares), second_moment * rho * rho,
              1e-4);
  }
  table.check(0.02);
}
