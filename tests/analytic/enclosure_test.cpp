// SPDX-License-Identifier: Apache-2.0
// Closed scenes, whose light after every bounce is known.
#include <algorithm>

#include "test_render.h"

using namespace lucarium;
using namespace lucarium::test;

namespace {

/// The unit sphere in 2^15 flat facets that touch it at their corners only: within 1.2e-4 of it. What that does to the
/// light is known.
struct FacetedSphere {
  std::vector<glm::vec3> triangles = sphere_triangles({0, 0, 0}, 1, 6, true);
  double bounced = 0;  ///< mean irradiance of a bounce over the sphere's: the flux is the same, the area smaller
  double direct = 0;   ///< mean over directions from the centre of the irradiance by 1 cd there

  FacetedSphere() {
    double area = 0;
    for (size_t i = 0; i < triangles.size(); i += 3) {
      const glm::dvec3 a(triangles[i]), b(triangles[i + 1]), c(triangles[i + 2]);
      const glm::dvec3 normal = glm::cross(b - a, c - a) / 2.;
      area += glm::length(normal);
      // Solid angle and irradiance both have the density cos / d^2; the midpoints of the edges integrate it.
      for (const glm::dvec3& p : {(a + b) / 2., (b + c) / 2., (c + a) / 2.}) {
        const double density = std::abs(glm::dot(p, glm::normalize(normal))) / std::pow(glm::length(p), 3);
        direct += glm::length(normal) / 3 * density * density / (4 * M_PI);
      }
    }
    bounced = 4 * M_PI / area;
  }
};

}  // namespace

TEST_CASE("enclosure: a box that emits 1 everywhere shows (1 - rho^(k+2)) / (1 - rho)") {
  // Light samples alone have infinite variance in the corners and are left to the other tables.
  ClosedForms table;
  for (const auto& [name, estimator] :
       {std::pair{"mis", PathEstimator::mis}, std::pair{"bsdf", PathEstimator::bsdf_only}})
    for (const int bounces : {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, -1}) {
      // Density of hits matters to the first limits only.
      if (estimator == PathEstimator::bsdf_only && bounces > 2) continue;
      Scene scene;
      add_box(scene, {-1, -1, -1}, {1, 1, 1}, true, add_material(scene, emitter(1, 0.5f)));
      const double exact = bounces < 0 ? 2 : (1 - std::pow(0.5, bounces + 2)) / 0.5;
      table.add(std::string(name) + ", limit " + std::to_string(bounces),
                estimate(scene, look_perspective({.3f, .2f, .1f}, {-1, -.5f, 0}, 1), limited(bounces, estimator),
                         usual_effort()),
                exact);
    }
  table.check(2e-3);
}

TEST_CASE("enclosure: a sphere with a point light, E_k = rho^k I / R^2 wherever the light stands") {
  ClosedForms table;
  const FacetedSphere sphere;
  for (const glm::vec3& position : {glm::vec3(0), glm::vec3(.3f, -.2f, .1f), glm::vec3(-.1f, .6f, .2f)})
    for (const int bounces : {1, 2, 3, -1}) {
      Scene scene;
      add_triangles(scene, sphere.triangles, add_material(scene, lambert(0.5f)));
      add_light(scene, LightType::point, static_cast<float>(M_PI), position, position - glm::vec3(0, 1, 0));
      PathIntegratorOptions options = limited(bounces);
      options.path_set.direct = false;
      // Sum over k = 1 … n of rho/pi rho^k I, I = pi.
      const double exact = 0.5 * (bounces < 0 ? 1 : 1 - std::pow(0.5, bounces)) * sphere.bounced;
      table.add("limit " + std::to_string(bounces),
                estimate(scene, look_perspective({0, 0, 0}, {1, .5f, .2f}, 1), options, usual_effort()), exact);
    }
  table.check(2e-3);
}

TEST_CASE("enclosure: the unit sphere of albedo 0.5 with I = pi at its centre shows 1") {
  const FacetedSphere sphere;
  Scene scene;
  add_triangles(scene, sphere.triangles, add_material(scene, lambert(0.5f)));
  add_light(scene, LightType::point, static_cast<float>(M_PI), {0, 0, 0}, {0, -1, 0});
  ClosedForms table;
  table.add("radiance", estimate(scene, look_perspective({0, 0, 0}, {1, .5f, .2f}, 1), limited(-1), usual_effort()),
            0.5 * sphere.direct + 0.5 * sphere.bounced);
  table.check(2e-3);
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
    std::vector<double> fluxes(usual_effort().replicates, 0.0);
    for (int wall = 0; wall < 6; ++wall) {
      const SceneCamera camera = look_orthographic({0, 0, 0}, axes[wall], 0.5f);
      const std::vector<double> means = replicate_means(scene, camera, limited(bounces), usual_effort(), 1 + wall);
      for (size_t r = 0; r < means.size(); ++r) fluxes[r] += means[r] * M_PI / rho;  // walls of 1 m²
    }
    table.add("up to bounce " + std::to_string(bounces), estimate_of(fluxes),
              4 * M_PI * (1 - std::pow(rho, bounces + 1)) / (1 - rho));
  }
  table.check(1e-3);
}

/// The walls of a regular tetrahedron with corners at (±1, ±1, ±1), whole or each of three triangles, one narrow.
std::vector<std::vector<glm::vec3>> tetrahedron_faces(bool whole) {
  const glm::vec3 corners[4] = {{1, 1, 1}, {-1, -1, 1}, {-1, 1, -1}, {1, -1, -1}};
  std::vector<std::vector<glm::vec3>> faces;
  for (int opposite = 0; opposite < 4; ++opposite) {
    glm::vec3 a = corners[(opposite + 1) % 4], b = corners[(opposite + 2) % 4];
    const glm::vec3 c = corners[(opposite + 3) % 4];
    if (glm::dot(glm::cross(b - a, c - a), a) > 0) std::swap(a, b);  // towards the centre
    const glm::vec3 inner = glm::mix(glm::mix(a, b, 0.2f), c, 0.1f);
    faces.push_back(whole ? std::vector{a, b, c} : std::vector{a, b, inner, b, c, inner, c, a, inner});
  }
  return faces;
}

TEST_CASE("enclosure: nor does the tessellation matter to the flux of a bounce") {
  // A tetrahedron with a light off its centre. Each face is seen from 20 micrometres above it, so that the slopes of
  // its neighbours hide nothing that counts.
  const float rho = 0.7f;
  ClosedForms table;
  for (const int bounces : {0, 1, 2, -1}) {
    Scene scene;
    const int white = add_material(scene, lambert(rho));
    for (const std::vector<glm::vec3>& face : tetrahedron_faces(false)) add_triangles(scene, face, white);
    add_light(scene, LightType::point, 1, {.1f, -.2f, .15f}, {0, -1, 0});
    std::vector<double> fluxes(usual_effort().replicates, 0.0);
    uint64_t seed = 1;
    for (const std::vector<glm::vec3>& face : tetrahedron_faces(false)) {
      const glm::vec3 middle = (face[0] + face[1] + face[4]) / 3.f;
      const SceneCamera camera = look_orthographic(middle * (1 - 2e-5f), middle, 1.64f);
      const std::vector<double> means = replicate_means(scene, camera, limited(bounces), usual_effort(), seed++);
      for (size_t r = 0; r < means.size(); ++r) fluxes[r] += means[r] * 3.28 * 3.28 * M_PI / rho;
    }
    const double remaining = bounces < 0 ? 0 : std::pow(rho, bounces + 1);
    table.add("up to bounce " + std::to_string(bounces), estimate_of(fluxes), 4 * M_PI * (1 - remaining) / (1 - rho));
  }
  table.check(2e-3);
}

TEST_CASE("enclosure: nothing of what shines outside comes in") {
  // Any ray that escapes, of eye paths as of shadows, meets an environment of radiance 1; shadow rays start at every
  // vertex. Far from the origin coordinates are coarse, and at the tetrahedron's edges walls lean over each other.
  const double wanted = full_run() ? 1e8 : 1e6;
  double traced = 0;
  for (const bool box : {true, false})
    for (const glm::vec3 offset : {glm::vec3(0), glm::vec3(300, -200, 1000)}) {
      Scene scene;
      const int white = add_material(scene, lambert(0.9f));
      if (box) add_box(scene, {-1, -1, -1}, {1, 1, 1}, true, white);
      if (!box)
        for (const std::vector<glm::vec3>& face : tetrahedron_faces(true)) add_triangles(scene, face, white);
      // Turned, so that no edge runs along an axis.
      const glm::mat3 turn(glm::rotate(glm::mat4(1), 0.7f, glm::vec3(1, 2, -3)));
      for (Mesh& mesh : scene.meshes) {
        for (glm::vec3& position : mesh.positions) position = turn * position + offset;
        for (glm::vec3& normal : mesh.normals) normal = turn * normal;
      }
      set_environment(scene, 1);
      PathIntegratorOptions options = limited(-1);
      options.samples_per_iteration = 16;
      TestRender render(scene, look_perspective(offset, offset + glm::vec3(1, .2f, .3f), 1.5f), options, 64);
      double rays = 0;
      while (rays < wanted / 4) {
        REQUIRE(render.integrator->iterate());
        const auto counters = render.integrator->counters();
        rays = counters.at("closest_rays") + counters.at("shadow_rays");
      }
      traced += rays;
      Film film(64, 64);
      render.integrator->resolve(film);
      const std::vector<float> image = film.image();
      const auto bright = std::count_if(image.begin(), image.end(), [](float value) { return value != 0; });
      CAPTURE(box);
      CAPTURE(offset.x);
      CAPTURE(rays);
      CHECK(bright == 0);
    }
  CHECK(traced >= wanted);
}
