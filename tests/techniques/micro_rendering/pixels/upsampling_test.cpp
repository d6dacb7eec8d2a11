// SPDX-License-Identifier: Apache-2.0
// Pixels between gathers.
#include <doctest/doctest.h>

#include <cmath>
#include <numbers>

#include "lucarium/base/numbers.h"
#include "technique_fixture.h"

using namespace lucarium;
using namespace lucarium::test;

namespace {

/// E / L of the wall x of [-1, 1], y of [0, 1] at z = 0 on a point of the floor (Lambert 1760): half the sum over edges
/// of the angle that the edge subtends times the vertical component of the unit normal of its plane through the point.
double wall_irradiance(const glm::dvec3& point) {
  const glm::dvec3 corners[] = {{-1, 0, 0}, {1, 0, 0}, {1, 1, 0}, {-1, 1, 0}};
  double sum = 0;
  for (int i = 0; i < 4; ++i) {
    const glm::dvec3 a = glm::normalize(corners[i] - point), b = glm::normalize(corners[(i + 1) % 4] - point);
    const glm::dvec3 axis = glm::cross(a, b);
    sum += std::atan2(glm::length(axis), glm::dot(a, b)) * glm::normalize(axis).y;
  }
  return 0.5 * std::abs(sum);
}

}  // namespace

TEST_CASE("between gathers light falls off as it does with a gather at every pixel: weights fall with the distance") {
  // A floor before a lit wall, from above: 16 pixels of which the light falls off to a third.
  Scene scene;
  scene.source = "test:slope";
  const int white = add_lambert(scene, "white", glm::vec3(0.8f));
  add_instance(scene, add_mesh(scene, MeshBuilder("floor").quad({-1, 0, 2}, {1, 0, 2}, {1, 0, 0}, {-1, 0, 0}).take()),
               white);
  add_instance(scene, add_mesh(scene, MeshBuilder("wall").quad({-1, 0, 0}, {1, 0, 0}, {1, 1, 0}, {-1, 1, 0}).take()),
               white);
  SceneLight light;
  light.type = LightType::directional;
  light.world_from_light = frame_along({0, 0, 0}, {0, 0, -1});
  light.intensity = glm::vec3(10);
  scene.lights.push_back(light);
  SceneCamera camera = look_at_camera("above", {0, 10, 0.8f}, {0, 0, 0.8f}, 6.8f);
  scene.cameras.push_back(camera);
  const auto render = [&](const char* step) {
    return indirect_light(scene, "micro_rendering", 17, 1, 1, {{"points_log2", "13"}, {"gather_step", step}});
  };
  const std::vector<float> every = render("1"), fourth = render("4");
  // The wall's radiance is 0.8 10 / pi; the floor sends 0.8 / pi of its irradiance.
  std::vector<float> exact;
  const double half = 10 * std::tan(glm::radians(3.4));
  for (int row = 0; row < 17; ++row)
    for (int column = 0; column < 17; ++column) {
      const double x = half * ((2 * column + 1) / 17.0 - 1), z = 0.8 + half * ((2 * row + 1) / 17.0 - 1);
      exact.insert(exact.end(), 3, static_cast<float>(0.64 * 10 / (pi * pi) * wall_irradiance({x, 0, z})));
    }
  const double error = relative_rmse(every, exact), between = relative_rmse(fourth, exact);
  MESSAGE("RMSE over the mean: ", error, ", of a gather at every fourth pixel ", between, ", of them apart ",
          relative_rmse(fourth, every));
  CHECK(exact[3 * (17 + 8)] > 2 * exact[3 * (17 * 15 + 8)]);
  CHECK(error < 0.035);  // noise of 8192 points and of pixels of the gathers
  CHECK(between < 0.045);
}
