// SPDX-License-Identifier: Apache-2.0
// Closed scenes, whose light after every bounce is known.
#include "closed_form.h"

using namespace lucarium;
using namespace lucarium::test;

namespace {

Effort effort() { return full_run() ? Effort{64, 16, 64} : Effort{32, 16, 16}; }

PathIntegratorOptions limited(int max_bounces, PathEstimator estimator = PathEstimator::mis) {
  PathIntegratorOptions options;
  options.path_set.max_bounces = max_bounces;
  options.estimator = estimator;
  return options;
}

/// The unit sphere in 2^15 flat facets that touch it at their corners only: within 1.2e-4 of it, and so is the light.
std::vector<glm::vec3> inner_sphere() { return sphere_triangles({0, 0, 0}, 1, 6, true); }

}  // namespace

TEST_CASE("enclosure: a box that emits 1 everywhere shows (1 - rho^(k+2)) / (1 - rho)") {
  // Light samples alone have infinite variance in the corners and are left to the other tables.
  ClosedForms table;
  for (const auto& [name, estimator] : {std::pair{"mis", PathEstimator::mis}, std::pair{"bsdf", PathEstimator::bsdf_only}})
    for (const int bounces : {0, 1, 2, 9, -1}) {
      Scene scene;
      add_box(scene, {-1, -1, -1}, {1, 1, 1}, true, add_material(scene, emitter(1, 0.5f)));
      const double exact = bounces < 0 ? 2 : (1 - std::pow(0.5, bounces + 2)) / 0.5;
      table.add(std::string(name) + ", limit " + std::to_string(bounces),
                estimate(scene, look_perspective({.3f, .2f, .1f}, {-1, -.5f, 0}, 1), limited(bounces, estimator), effort()), exact);
    }
  table.check(full_run() ? 5e-4 : 2e-3);
}

TEST_CASE("enclosure: a sphere with a point light, E_k = rho^k I / R^2 wherever the light stands") {
  const double slack = 4e-4;
  ClosedForms table;
  const std::vector<glm::vec3> sphere = inner_sphere();
  for (const glm::vec3& position : {glm::vec3(0), glm::vec3(.3f, -.2f, .1f)})
    for (const int bounces : {1, 2, 3, -1}) {
      Scene scene;
      add_triangles(scene, sphere, add_material(scene, lambert(0.5f)));
      add_light(scene, LightType::point, static_cast<float>(M_PI), position, position - glm::vec3(0, 1, 0));
      PathIntegratorOptions options = limited(bounces);
      options.path_set.direct = false;
      // Sum over k = 1 … n of rho/pi rho^k I, I = pi.
      const double exact = 0.5 * (bounces < 0 ? 1 : 1 - std::pow(0.5, bounces));
      table.add("limit " + std::to_string(bounces), estimate(scene, look_perspective({0, 0, 0}, {1, .5f, .2f}, 1), options, effort()),
                exact, slack);
    }
  table.check(full_run() ? 5e-4 : 2e-3);
}

TEST_CASE("enclosure: the unit sphere of albedo 0.5 with I = pi at its centre shows 1") {
  Scene scene;
  add_triangles(scene, inner_sphere(), add_material(scene, lambert(0.5f)));
  add_light(scene, LightType::point, static_cast<float>(M_PI), {0, 0, 0}, {0, -1, 0});
  ClosedForms table;
  table.add("radiance", estimate(scene, look_perspective({0, 0, 0}, {1, .5f, .2f}, 1), limited(-1), effort()), 1, 4e-4);
  table.check(full_run() ? 5e-4 : 2e-3);
}

TEST_CASE("enclosure: in a closed scene of one albedo the flux of bounce k is rho^k of the light's") {
  // A unit cube with a point light of 1 cd off its centre; each wall seen whole by its own camera.
  const glm::vec3 axes[6] = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  const float rho = 0.6f;
  ClosedForms table;
  for (const int bounces : {0, 1, 3}) {
    Scene scene;
    add_box(scene, glm::vec3(-.5f), glm::vec3(.5f), true, add_material(scene, lambert(rho)));
    add_light(scene, LightType::point, 1, {.2f, .1f, -.25f}, {0, -1, 0});
    std::vector<double> fluxes(effort().replicates, 0.0);
    for (int wall = 0; wall < 6; ++wall) {
      const SceneCamera camera = look_orthographic({0, 0, 0}, axes[wall], 0.5f);
      const std::vector<double> means = replicate_means(scene, camera, limited(bounces), effort(), 1 + wall);
      for (size_t r = 0; r < means.size(); ++r) fluxes[r] += means[r] * M_PI / rho;  // walls of 1 m²
    }
    table.add("up to bounce " + std::to_string(bounces), estimate_of(fluxes),
              4 * M_PI * (1 - std::pow(rho, bounces + 1)) / (1 - rho));
  }
  table.check(full_run() ? 5e-4 : 1e-3);
}
