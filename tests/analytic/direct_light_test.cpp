// SPDX-License-Identifier: Apache-2.0
// Direct light on a Lambertian floor from every kind of light, against closed forms.
#include "test_render.h"
#include "tolerance.h"

using namespace lucarium;
using namespace lucarium::test;

namespace {

Scene floor_scene(float rho, float size = 40) {
  Scene scene;
  add_horizontal(scene, 0, 0, 0, size, size, true, add_material(scene, lambert(rho)));
  return scene;
}

/// A patch of the floor so small that the irradiance on it is that at its centre.
SceneCamera patch(float x, float z) { return look_orthographic({x, 0.01f, z}, {x, 0, z}, 1e-5f); }

const std::vector<std::pair<std::string, PathEstimator>> kEstimators = {
    {"mis", PathEstimator::mis}, {"nee", PathEstimator::nee_only}, {"bsdf", PathEstimator::bsdf_only}};

/// E / L of a polygon on a point with unit normal n (Lambert 1760): half the sum over edges of the angle the edge
/// subtends times the component along n of the unit normal of its plane through the point.
double polygon_irradiance(const std::vector<glm::vec3>& corners, const glm::dvec3& point, const glm::dvec3& n) {
  double sum = 0;
  for (size_t i = 0; i < corners.size(); ++i) {
    const glm::dvec3 a = glm::normalize(glm::dvec3(corners[i]) - point);
    const glm::dvec3 b = glm::normalize(glm::dvec3(corners[(i + 1) % corners.size()]) - point);
    const glm::dvec3 axis = glm::cross(a, b);
    sum += std::atan2(glm::length(axis), glm::dot(a, b)) * glm::dot(glm::normalize(axis), n);
  }
  return 0.5 * std::abs(sum);
}

}  // namespace

TEST_CASE("direct light: a point light above a plane, L = rho/pi I h / (h^2 + r^2)^(3/2)") {
  ClosedForms table;
  Scene scene = floor_scene(0.5f);
  add_light(scene, LightType::point, 100, {0, 2, 0}, {0, 0, 0});
  const std::pair<float, double> rows[] = {{0.f, 3.978874}, {1.f, 2.847050}, {2.f, 1.406744}, {4.f, 0.355881}};
  for (const auto& [r, exact] : rows)
    table.add("r = " + std::to_string(r), estimate(scene, patch(r, 0), direct_only(), usual_effort()), exact);
  table.check();
}

TEST_CASE("direct light: a directional light, L = rho/pi E cos(theta)") {
  ClosedForms table;
  for (const float cosine : {1.f, 0.5f, 0.1f}) {
    Scene scene = floor_scene(0.5f);
    add_light(scene, LightType::directional, 100, {std::sqrt(1 - cosine * cosine), cosine, 0}, {0, 0, 0});
    table.add("cos = " + std::to_string(cosine), estimate(scene, patch(0, 0), direct_only(), usual_effort()),
              15.915494 * cosine);
  }
  table.check();
}

TEST_CASE("direct light: flux of a spot of 20 and 30 degrees is 0.533211 sr times its intensity") {
  Scene scene = floor_scene(0.5f);
  add_light(scene, LightType::spot, 100, {0, 1, 0}, {0, 0, 0});
  scene.lights[0].inner_angle = static_cast<float>(20 * M_PI / 180);
  scene.lights[0].outer_angle = static_cast<float>(30 * M_PI / 180);
  // The camera sees 1.4 m x 1.4 m, all of the lit disk: mean radiance times pi/rho times area is the flux.
  const SceneCamera camera = look_orthographic({0, 0.5f, 0}, {0, 0, 0}, 0.7f);
  Estimate flux = estimate(scene, camera, direct_only(), usual_effort());
  const double to_flux = M_PI / 0.5 * 1.4 * 1.4 / 100;
  flux.mean *= to_flux;
  flux.error *= to_flux;
  ClosedForms table;
  table.add("flux", flux, 0.533211);
  table.check();
}

TEST_CASE("direct light: a spot inside its cone, on its ramp and beyond, E = I f(theta) cos(theta)^3 / h^2") {
  const auto radians = [](double degrees) { return degrees * M_PI / 180; };
  Scene scene = floor_scene(0.5f);
  add_light(scene, LightType::spot, 100, {0, 1, 0}, {0, 0, 0});
  scene.lights[0].inner_angle = static_cast<float>(radians(20));
  scene.lights[0].outer_angle = static_cast<float>(radians(30));
  ClosedForms table;
  for (const double degrees : {0., 15., 19., 22., 25., 28., 31.}) {
    const double cosine = std::cos(radians(degrees));
    const double ramp = (cosine - std::cos(radians(30))) / (std::cos(radians(20)) - std::cos(radians(30)));
    const double falloff = std::pow(std::clamp(ramp, 0., 1.), 2);
    table.add(std::to_string(degrees) + " degrees",
              estimate(scene, patch(static_cast<float>(std::tan(radians(degrees))), 0), direct_only(), usual_effort()),
              0.5 / M_PI * 100 * falloff * cosine * cosine * cosine);
  }
  table.check();
}

TEST_CASE("direct light: a unit-square light at height 1, by every estimator") {
  ClosedForms table;
  const std::tuple<float, float, double> rows[] = {{0.f, 0.f, .752275}, {.5f, .5f, .435210}, {2.f, 0.f, .0437426}};
  for (const auto& [name, estimator] : kEstimators)
    for (const auto& [x, z, exact] : rows) {
      Scene scene = floor_scene(0.5f);
      add_horizontal(scene, 0, 1, 0, 1, 1, false, add_material(scene, emitter(10)));
      // Hits of a light that covers little of the hemisphere need more samples.
      Effort more = usual_effort();
      if (estimator == PathEstimator::bsdf_only) more.samples_per_replicate *= exact < 0.1 ? 32 : 4;
      table.add(name + " at " + std::to_string(x) + ", " + std::to_string(z),
                estimate(scene, patch(x, z), direct_only(estimator), more), exact * 10 * 0.5 / M_PI);
    }
  table.check(2e-3);
}

TEST_CASE("direct light: a unit-square light of 25 pieces, of which a tree chooses (Lambert's formula)") {
  const std::vector<glm::vec3> corners = {{-.5f, .2f, -.5f}, {.5f, .2f, -.5f}, {.5f, .2f, .5f}, {-.5f, .2f, .5f}};
  ClosedForms table;
  for (const auto& [name, estimator] : kEstimators) {
    for (const float x : {0.f, .45f, .8f}) {
      Scene scene = floor_scene(0.5f);
      const int material = add_material(scene, emitter(10));
      for (int i = 0; i < 25; ++i)
        add_horizontal(scene, 0.2f * static_cast<float>(i % 5 - 2), 0.2f, 0.2f * static_cast<float>(i / 5 - 2), 0.2f,
                       0.2f, false, material);
      const double exact = polygon_irradiance(corners, {x, 0, .1}, {0, 1, 0});
      Effort more = usual_effort();
      if (estimator == PathEstimator::bsdf_only) more.samples_per_replicate *= 4;
      table.add(name + " at " + std::to_string(x), estimate(scene, patch(x, .1f), direct_only(estimator), more),
                exact * 10 * 0.5 / M_PI);
    }
  }
  table.check(2e-3);
}

TEST_CASE("direct light: a tilted pentagon, by every estimator (Lambert's formula)") {
  const glm::vec3 u = glm::normalize(glm::vec3(1, .35f, .1f)),
                  v = glm::normalize(glm::cross(u, glm::vec3(.2f, 1, -.3f)));
  std::vector<glm::vec3> corners;
  for (const auto& [a, b] :
       std::vector<std::pair<float, float>>{{-.5f, -.3f}, {.2f, -.5f}, {.6f, 0}, {.3f, .5f}, {-.4f, .4f}})
    corners.push_back(glm::vec3(0, 1.1f, 0) + a * u + b * v);
  ClosedForms table;
  for (const auto& [name, estimator] : kEstimators) {
    Scene scene = floor_scene(0.8f);
    SceneMaterial light = emitter(5);
    light.double_sided = true;
    add_polygon(scene, corners, add_material(scene, light));
    const double exact = polygon_irradiance(corners, {.2, 0, .1}, {0, 1, 0});
    Effort more = usual_effort();
    if (estimator == PathEstimator::bsdf_only) more.samples_per_replicate *= 4;
    table.add(name, estimate(scene, patch(.2f, .1f), direct_only(estimator), more), exact * 5 * 0.8 / M_PI);
  }
  // A sliver that stands close to the floor.
  const std::vector<glm::vec3> sliver = {{.5f, .15f, -1}, {.6f, 1.5f, -.7f}, {.4f, .2f, 1.2f}};
  Scene scene = floor_scene(0.8f);
  SceneMaterial light = emitter(5);
  light.double_sided = true;
  add_polygon(scene, sliver, add_material(scene, light));
  table.add("sliver", estimate(scene, patch(-.1f, 0), direct_only(), usual_effort()),
            polygon_irradiance(sliver, {-.1, 0, 0}, {0, 1, 0}) * 5 * 0.8 / M_PI);
  table.check(2e-3);
}

TEST_CASE("direct light: a sphere, E = pi L (r/d)^2 cos(theta), tessellation summed exactly") {
  const auto sphere_at = [](double cosine) {
    const double sine = std::sqrt(1 - cosine * cosine);
    return sphere_triangles({static_cast<float>(2 * sine), static_cast<float>(2 * cosine), 0}, 0.5f, 4, false);
  };
  const auto render = [&](double cosine, PathEstimator estimator) {
    Scene scene = floor_scene(0.5f);
    add_triangles(scene, sphere_at(cosine), add_material(scene, emitter(10)));
    Effort more = usual_effort();
    more.samples_per_replicate *= 4;
    return estimate(scene, patch(0, 0), direct_only(estimator), more);
  };
  const auto irradiance = [&](double cosine) {
    const std::vector<glm::vec3> sphere = sphere_at(cosine);
    double sum = 0;
    for (size_t i = 0; i < sphere.size(); i += 3) {
      const glm::dvec3 a = sphere[i], b = sphere[i + 1], c = sphere[i + 2];
      if (glm::dot(glm::cross(b - a, c - a), -a) > 0)
        sum += polygon_irradiance({sphere[i], sphere[i + 1], sphere[i + 2]}, {0, 0, 0}, {0, 1, 0});
    }
    CHECK(sum == test::relative(0.196350 * cosine, 0.01));
    return sum;
  };
  ClosedForms table;
  for (const auto& [name, estimator] : kEstimators)
    table.add(name, render(1, estimator), irradiance(1) * 10 * 0.5 / M_PI);
  // The whole sphere is above the horizon.
  for (const double cosine : {0.8, 0.5, 0.3})
    table.add("cos " + std::to_string(cosine), render(cosine, PathEstimator::mis),
              irradiance(cosine) * 10 * 0.5 / M_PI);
  table.check(4e-3);
}

TEST_CASE("direct light: environment of radiance max(0, y), E = 2 pi / 3, by every estimator") {
  ClosedForms table;
  for (const auto& [name, estimator] : kEstimators) {
    Scene scene = floor_scene(0.5f);
    Environment& environment = scene.environment.emplace();
    environment.width = 8;
    environment.height = 1024;
    for (uint32_t row = 0; row < environment.height; ++row) {
      const double y = std::cos((row + 0.5) * M_PI / environment.height);
      environment.radiance.insert(environment.radiance.end(), environment.width,
                                  glm::vec3(static_cast<float>(std::max(0.0, y))));
    }
    Effort more = usual_effort();
    more.samples_per_replicate *= 4;
    table.add(name, estimate(scene, patch(0, 0), direct_only(estimator), more), 2 * M_PI / 3 * 0.5 / M_PI);
  }
  table.check(1e-3);
}

TEST_CASE("direct light: the back of a single-sided surface neither emits nor reflects, and it blocks") {
  // A lit floor seen from below, and an emitter seen from behind.
  Scene scene = floor_scene(0.5f);
  add_light(scene, LightType::point, 100, {0, 2, 0}, {0, 0, 0});
  add_light(scene, LightType::point, 100, {0, -2, 0}, {0, 0, 0});
  const SceneCamera below = look_orthographic({0, -1, 0}, {0, 0, 0}, 0.1f);
  const Estimate reflected = estimate(scene, below, direct_only(), {16, 4, 4});
  CHECK(reflected.mean == 0);

  Scene emitting;
  add_horizontal(emitting, 0, 0, 0, 2, 2, true, add_material(emitting, emitter(10)));
  CHECK(estimate(emitting, below, direct_only(), {16, 4, 4}).mean == 0);
  const SceneCamera from_front = look_orthographic({0, 1, 0}, {0, 0, 0}, 0.1f);
  CHECK(estimate(emitting, from_front, direct_only(), {16, 4, 4}).mean == test::relative(10));

  // A plate whose front faces the floor shades it from the light behind the plate.
  Scene shaded = floor_scene(0.5f);
  add_light(shaded, LightType::point, 100, {0, 2, 0}, {0, 0, 0});
  add_horizontal(shaded, 0, 1, 0, 4, 4, false, add_material(shaded, lambert(0.f)));
  CHECK(estimate(shaded, patch(0, 0), direct_only(), {16, 4, 4}).mean == 0);
}

TEST_CASE("direct light: lamps that lie in a ceiling shine into the room, whatever rounding makes of its plane") {
  // Level or tilted, at a height that is a float or not, at the origin or far from there.
  for (const float slope : {0.f, 0.37f}) {
    for (const glm::vec3& at : {glm::vec3(0, 2, 0), glm::vec3(0, 2.71f, 0), glm::vec3(3000, -2000.3f, 1000)}) {
      CAPTURE(slope);
      CAPTURE(at.y);
      const auto ceiling = [&](float x, float z) { return at + glm::vec3(x, slope * x, z); };
      const glm::vec3 floor = at - glm::vec3(0, 2, 0);
      Scene scene;
      const int material = add_material(scene, lambert(0.5f));
      add_horizontal(scene, floor.x, floor.y, floor.z, 40, 40, true, material);
      for (const float x : {-0.9f, -0.7f, 0.3f, 0.6f, 1.1f}) {
        add_light(scene, x < -0.8f ? LightType::spot : LightType::point, 100, {0, 0, 0}, {0, -1, 0});
        scene.lights.back().world_from_light[3] = glm::vec4(ceiling(x, 0.1f - 0.7f * x), 1);
      }
      const SceneCamera camera = look_orthographic(floor + glm::vec3(0, 1, 0), floor, 2);
      const double bare = estimate(scene, camera, direct_only(), {32, 4, 16}).mean;
      CHECK(bare > 1);
      add_polygon(scene, {ceiling(-3, 3), ceiling(-3, -3), ceiling(3, -3), ceiling(3, 3)}, material);
      CHECK(estimate(scene, camera, direct_only(), {32, 4, 16}).mean == test::relative(bare));
    }
  }
}
