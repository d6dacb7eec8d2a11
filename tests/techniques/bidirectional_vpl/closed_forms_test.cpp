// SPDX-License-Identifier: Apache-2.0
// Closed forms by virtual lights alone: a closed sphere, where every connection brings the same.
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
      std::vector<double> means;
      for (uint32_t i = 0; i < 8; ++i) {
        picture.seed = 10 + i;
        means.push_back(
            mean_of(render(scene, "bidirectional_vpl", picture, {{"strategy", "vpl"}, {"light_paths", "512"}})
                        .find("indirect")
                        ->pixels));
      }
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
