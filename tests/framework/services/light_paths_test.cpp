// SPDX-License-Identifier: Apache-2.0
// LightPaths and LightAtPoints: the power that arrives at surfaces after so many scatterings, in closed form, and the
// light of virtual lights in a sphere.
#include "lucarium/services/light_paths/light_paths.h"

#include <doctest/doctest.h>

#include <cmath>
#include <cstring>
#include <numbers>

#include "device_fixture.h"
#include "lucarium/base/numbers.h"
#include "lucarium/compute/program/source_library.h"
#include "lucarium/scene/builtin/builder.h"
#include "lucarium/services/bvh/bvh.h"
#include "lucarium/services/light_at_points/light_at_points.h"
#include "lucarium/shared/surface_point.h"
#include "made_scene.h"
#include "test_support.h"
#include "tolerance.h"

using namespace lucarium;
using namespace lucarium::test;

namespace {

Scene empty_scene() {
  Scene scene;
  scene.source = "test:light paths";
  return scene;
}

/// Light paths of a scene.
struct Rig {
  explicit Rig(Scene s)
      : scene(std::move(s)),
        buffers(*test_device(), scene),
        bvh(*test_device(), scene, buffers),
        scheduler(test_device()) {}

  /// Vertices from the first on, and of each number the flux that arrives there, or that is reflected (green) [lm].
  std::vector<VirtualLight> trace(const LightPathOptions& options, bool reflected = false) {
    const LightPaths paths(*test_device(), buffers, bvh, options, "test");
    TypedBuffer<VirtualLight> lights(*test_device(), "test", "vertices", paths.virtual_lights(0));
    ScheduleRecorder recorder = scheduler.record("light paths", "test");
    const Variable<uint32_t> run = recorder.variable("run", 3u), seed = recorder.variable("seed", 5u);
    paths.record_virtual_lights(recorder, run, seed, lights, 0, reflected);
    Schedule schedule = recorder.compile();
    REQUIRE(scheduler.run(schedule) == RunResult::done);
    scheduler.finish();
    return lights.download();
  }
  std::vector<double> fluxes(const LightPathOptions& options, bool reflected = false) {
    std::vector<double> sums(options.vertices);
    const std::vector<VirtualLight> lights = trace(options, reflected);
    for (size_t i = 0; i < lights.size(); ++i) sums[i / options.paths] += double{lights[i].flux.y};
    return sums;
  }

  Scene scene;
  SceneBuffers buffers;
  Bvh bvh;
  KernelScheduler scheduler;
};

const uint32_t paths = 4096;

}  // namespace

TEST_CASE("in a closed room every scattering leaves the albedo's share of the lamps' power") {
  // Flat walls of albedo 1/2, one light of each kind that fits inside. Lambertian reflection has no noise.
  Scene scene = empty_scene();
  add_box(scene, glm::vec3(-1), glm::vec3(1), true, add_material(scene, lambert(0.5f)));
  add_light(scene, LightType::point, 2, {0.3f, 0.2f, -0.4f}, {0, -1, 0});
  add_light(scene, LightType::spot, 5, {-0.3f, 0.6f, 0.4f}, {0, -1, 0});
  scene.lights.back().inner_angle = static_cast<float>(20 * pi / 180);
  scene.lights.back().outer_angle = static_cast<float>(30 * pi / 180);
  SceneMaterial lamp = emitter(3);  // black: what meets it is lost, which is little
  lamp.double_sided = true;
  add_triangles(scene, {{0, 0, 0}, {0.02f, 0, 0}, {0, 0.02f, 0}}, add_material(scene, lamp));
  const double power = 4 * pi * 2 + .533211 * 5 + 2 * pi * 2e-4 * 3;
  Rig rig(std::move(scene));
  const std::vector<double> diffuse = rig.fluxes({.paths = paths, .vertices = 3, .diffuse_only = true}),
                            all = rig.fluxes({.paths = paths, .vertices = 3}),
                            roulette = rig.fluxes({.paths = 4 * paths, .vertices = 3, .roulette_start = 1}),
                            reflected = rig.fluxes({.paths = paths, .vertices = 1, .diffuse_only = true}, true);
  for (int k = 0; k < 3; ++k) {
    CAPTURE(k);
    const double expected = power * std::pow(0.5, k);
    CHECK(diffuse[k] == test::relative(expected, 0.01));  // the share of lights among the paths
    CHECK(all[k] == test::relative(expected, 0.01));
    CHECK(roulette[k] == test::relative(expected, 0.04));
    CHECK(diffuse[k] / diffuse[0] == test::relative(std::pow(0.5, k), 1e-3));
  }
  CHECK(reflected[0] == test::relative(0.5 * diffuse[0], 1e-5));
}

TEST_CASE("many light paths, which are traced in batches, are all different and the same as of few") {
  Scene scene = empty_scene();
  add_box(scene, glm::vec3(-1), glm::vec3(1), true, add_material(scene, lambert(0.5f)));
  add_light(scene, LightType::point, 2, {0.3f, 0.2f, -0.4f}, {0, -1, 0});
  Rig rig(std::move(scene));
  const uint32_t many = 40003, few = 5003, batch = 1 << 14;
  const std::vector<VirtualLight> all = rig.trace({.paths = many, .vertices = 2}),
                                  first = rig.trace({.paths = few, .vertices = 2});
  for (uint32_t number = 0; number < 2; ++number) {
    CAPTURE(number);
    int same = 0, repeated = 0, absent = 0;
    for (uint32_t i = 0; i < many; ++i) {
      const VirtualLight& light = all[number * many + i];
      const auto lies_at = [&](const VirtualLight& other) {
        return light.position.x == other.position.x && light.position.y == other.position.y &&
               light.position.z == other.position.z;
      };
      if (i < few) same += lies_at(first[number * few + i]);
      if (i >= batch) repeated += lies_at(all[number * many + i - batch]);
      absent += light.flux.y <= 0.0f;
    }
    CHECK(same == static_cast<int>(few));
    CHECK(repeated == 0);
    CHECK(absent == 0);
  }
}

TEST_CASE("light paths whose first rays are traced in another order are the same") {
  Scene scene = empty_scene();
  add_box(scene, glm::vec3(-1), glm::vec3(1), true, add_material(scene, lambert(0.5f)));
  add_light(scene, LightType::point, 2, {0.3f, 0.2f, -0.4f}, {0, -1, 0});
  add_light(scene, LightType::point, 3, {-0.3f, 0.2f, 0.4f}, {0, -1, 0});
  add_triangles(scene, {{0, 0, 0}, {0.3f, 0, 0}, {0, 0.3f, 0}}, add_material(scene, emitter(3)));
  Rig rig(std::move(scene));
  const uint32_t many = (1 << 18) + 4099;  // one batch, and a short one
  CHECK(FirstRays::pays(rig.buffers, rig.bvh, many, 31));
  CHECK_FALSE(FirstRays::pays(rig.buffers, rig.bvh, 1 << 12, 31));
  CHECK_FALSE(FirstRays::pays(rig.buffers, rig.bvh, many, 1 << LUCARIUM_LIGHT_TRIANGLE));
  CHECK(LightPaths::estimate_bytes(many, rig.scene) == LightPaths::estimate_bytes(many));
  CHECK(LightPaths::estimate_bytes(many, empty_scene()) < LightPaths::estimate_bytes(many) / 2);
  const std::vector<VirtualLight> ordered = rig.trace({.paths = many, .vertices = 2}),
                                  numbered = rig.trace({.paths = many, .vertices = 2, .order = false});
  CHECK(std::memcmp(ordered.data(), numbered.data(), ordered.size() * sizeof ordered[0]) == 0);
}

TEST_CASE("light leaves a ball of glass with what absorption and Fresnel leave, and none of it from a point light") {
  // A lamp of radius .005 in the middle of a ball of radius 1/2, ior 1.5: light meets the glass at right angles, and
  // (1 - F) exp(-sigma r) of it leaves at once. What would be counted twice or not at all (eta^2 = 2.25, F, sigma)
  // shows at the walls.
  const auto ball = [](double sigma, bool punctual) {
    Scene scene = empty_scene();
    SceneMaterial glass = lambert(1);
    glass.ior = 1.5f;
    glass.roughness = 0;
    glass.transmission = 1;
    glass.thickness = 1;
    glass.attenuation_color = glm::vec3(static_cast<float>(std::exp(-sigma)));
    glass.attenuation_distance = 1;
    add_triangles(scene, sphere_triangles(glm::vec3(0), 0.5f, 5, false), add_material(scene, glass));
    if (punctual)
      add_light(scene, LightType::point, 1, glm::vec3(0), {0, -1, 0});
    else
      add_triangles(scene, sphere_triangles(glm::vec3(0), 0.005f, 2, false), add_material(scene, emitter(1000)));
    add_box(scene, glm::vec3(-1), glm::vec3(1), true, add_material(scene, lambert(0.5f)));
    return scene;
  };
  const double area = [] {
    double sum = 0;
    const auto corners = sphere_triangles(glm::vec3(0), 0.005f, 2, false);
    for (size_t i = 0; i < corners.size(); i += 3)
      sum += 0.5 * double{glm::length(glm::cross(corners[i + 1] - corners[i], corners[i + 2] - corners[i]))};
    return sum;
  }();
  for (const double sigma : {0.0, 2.0}) {
    CAPTURE(sigma);
    Rig rig(ball(sigma, false));
    const std::vector<double> flux = rig.fluxes({.paths = paths, .vertices = 2});
    CHECK(flux[0] == 0);  // the glass itself is no vertex
    const double a = std::exp(-sigma * 0.5), through = 0.96 * a;
    CHECK(flux[1] == test::relative(pi * area * 1000 * through, 0.015));
  }
  Rig rig(ball(0, true));
  CHECK(rig.fluxes({.paths = paths, .vertices = 2})[1] == 0);
}

TEST_CASE("leaning shading normals: light arrives and leaves as the path tracer reflects it") {
  // A narrow spot straight down at a floor whose shading normals lean by beta: it receives cos(beta) of the flux (the
  // ratio of the cosines) and sends rho times that over what both normals see, (1 + cos beta) / 2 of the hemisphere.
  const double beta = 0.6;
  Scene scene = empty_scene();
  add_horizontal(scene, 0, 0, 0, 0.4f, 0.4f, true, add_material(scene, lambert(0.8f)));
  for (glm::vec3& n : scene.meshes[0].normals)
    n = glm::vec3(static_cast<float>(std::sin(beta)), static_cast<float>(std::cos(beta)), 0);
  scene.meshes[0].flat_normals = false;
  add_box(scene, glm::vec3(-2), glm::vec3(2), true, add_material(scene, lambert(0.5f)));
  add_light(scene, LightType::spot, 1000, {0, 1, 0}, {0, 0, 0});
  scene.lights.back().inner_angle = 0.02f;
  scene.lights.back().outer_angle = 0.03f;
  Rig rig(std::move(scene));
  const Light light = rig.buffers.scene_lights.download().front();
  const double power = double{light.intensity.w};
  for (const bool diffuse : {true, false}) {
    CAPTURE(diffuse);
    const std::vector<double> flux = rig.fluxes({.paths = 4 * paths, .vertices = 2, .diffuse_only = diffuse});
    CHECK(flux[0] == test::relative(power * std::cos(beta), 2e-3));
    CHECK(flux[1] == test::relative(power * std::cos(beta) * 0.8 * (1 + std::cos(beta)) / 2, diffuse ? 0.01 : 0.03));
  }
}

TEST_CASE("BLEND and MASK surfaces stop as many light paths as they cover") {
  for (const AlphaMode mode : {AlphaMode::blend, AlphaMode::mask}) {
    Scene scene = empty_scene();
    SceneMaterial veil = lambert(0.5f);
    veil.alpha_mode = mode;
    veil.base_color.a = 0.25f;
    veil.alpha_cutoff = 0.5f;
    add_horizontal(scene, 0, 0, 0, 1, 1, true, add_material(scene, veil));
    add_light(scene, LightType::spot, 10, {0, 1, 0}, {0, 0, 0});
    scene.lights.back().outer_angle = 0.3f;
    Rig rig(std::move(scene));
    const std::vector<double> covered = rig.fluxes({.paths = paths, .diffuse_only = true}),
                              opaque = rig.fluxes({.paths = paths, .diffuse_only = true, .opaque_blend = true});
    const double power = double{rig.buffers.scene_lights.download().front().intensity.w};
    CHECK(covered[0] == test::within(mode == AlphaMode::blend ? 0.25 * power : 0, 0.03 * power));
    CHECK(opaque[0] == test::within(mode == AlphaMode::blend ? power : 0, 1e-3 * power));
  }
}

TEST_CASE("a light path that meets one BLEND sheet twice decides twice") {
  // A spot straight down at a floor, between both a veil that half of the paths pass; what the floor of albedo 1 sends
  // up meets the veil again, and half of that is stopped. Vertices on the veil's underside: 1/2 1/2 of the power, and
  // none where what has passed once passes again.
  Scene scene = empty_scene();
  SceneMaterial veil = lambert(0);
  veil.ior = 1;
  veil.alpha_mode = AlphaMode::blend;
  veil.base_color = glm::vec4(1, 1, 1, 0.5f);
  veil.double_sided = true;
  add_polygon(scene, {{-50, 0.01f, 50}, {50, 0.01f, 50}, {50, 0.01f, -50}}, add_material(scene, veil));
  add_horizontal(scene, 10, 0, 10, 1, 1, true, add_material(scene, lambert(1)));
  add_light(scene, LightType::spot, 1000, {10, 1, 10}, {10, 0, 10});
  scene.lights.back().inner_angle = 0.02f;
  scene.lights.back().outer_angle = 0.03f;
  Rig rig(std::move(scene));
  const double power = double{rig.buffers.scene_lights.download().front().intensity.w};
  double below = 0, above = 0;
  const uint32_t count = 4 * paths;
  const std::vector<VirtualLight> vertices = rig.trace({.paths = count, .vertices = 2, .diffuse_only = true});
  for (uint32_t i = 0; i < count; ++i) {
    above += double{vertices[i].position.y} > 0.005 ? double{vertices[i].flux.y} : 0;
    below += double{vertices[i].position.y} < 0.005 ? double{vertices[count + i].flux.y} : 0;
  }
  CHECK(above == test::relative(power / 2, 0.03));
  CHECK(below == test::relative(power / 4, 0.05));
}

TEST_CASE("points in a sphere: direct light, and one bounce of it by every single virtual light") {
  // In a sphere of radius R every point sees every other with cos cos / d^2 = 1 / 4 R^2: a light of intensity I in its
  // middle gives E = I / R^2, and each virtual light, of reflected flux Phi, Phi / (4 pi R^2).
  const double radius = 2, intensity = 3;
  Scene scene = empty_scene();
  add_triangles(scene, sphere_triangles(glm::vec3(0), static_cast<float>(radius), 5, true),
                add_material(scene, lambert(0.5f)));
  add_light(scene, LightType::point, static_cast<float>(intensity), glm::vec3(0), {0, -1, 0});
  Rig rig(std::move(scene));
  const std::vector<VirtualLight> lights = rig.trace({.paths = 64, .diffuse_only = true}, true);

  const uint32_t triangles = rig.buffers.info().triangle_count, count = 512;
  const auto corners = rig.buffers.scene_triangles.download();
  const auto vertices = rig.buffers.scene_vertices.download();
  std::vector<SurfacePoint> points(count);
  for (uint32_t i = 0; i < count; ++i) {
    SurfacePoint& p = points[i];
    p = {};
    p.triangle = i * (triangles / count);
    p.u = p.v = 1 / 3.f;
    const Triangle t = corners[p.triangle];
    const glm::vec3 middle =
        (vertices[t.v0].position.xyz() + vertices[t.v1].position.xyz() + vertices[t.v2].position.xyz()) / 3.f;
    p.position = float4(middle, 0);
    p.normal = float4(-glm::normalize(middle), 0);
  }
  const TypedBuffer<SurfacePoint> list(*test_device(), "test", "points", points);
  const TypedBuffer<VirtualLight> stored(*test_device(), "test", "virtual lights", lights);
  TypedBuffer<float4> sums(*test_device(), "test", "sums", count);
  const Program program(*test_device(), SourceLibrary(),
                        {"test/surface_points", {"lucarium/services/light_at_points/surface_points.cl"}, {}});
  const LightAtPoints light(
      *test_device(), rig.buffers, rig.bvh, program, count, [&](PassBuilder& pass) { pass.arg("points", list); },
      "test", "use fewer points");
  const auto bind_sums = [&](PassBuilder& pass) { pass.arg("irradiance", sums); };
  const auto mean = [&](Schedule& schedule, double& worst, double expected) {
    sums.fill_zero();
    REQUIRE(rig.scheduler.run(schedule) == RunResult::done);
    rig.scheduler.finish();
    double sum = 0;
    for (const float4& e : sums.download()) {
      CHECK(e.w == 1);
      worst = std::max(worst, std::abs(double{e.y} / expected - 1));
      sum += double{e.y} / count;
    }
    return sum;
  };

  ScheduleRecorder direct = rig.scheduler.record("direct light", "test");
  const Variable<uint32_t> sample = direct.variable("sample", 0u), seed = direct.variable("seed", 1u);
  light.record_samples(direct, sample, seed, bind_sums);
  Schedule direct_schedule = direct.compile();
  double worst = 0;
  const double expected = intensity / (radius * radius);
  CHECK(mean(direct_schedule, worst, expected) == test::relative(expected, 2e-3));  // facets
  CHECK(worst < 0.02);

  ScheduleRecorder recorder = rig.scheduler.record("virtual light", "test");
  const Variable<uint32_t> index = recorder.variable("light", 0u), shadow_seed = recorder.variable("seed", 1u);
  const Variable<float> bound = recorder.variable("bound", 1e30f);
  light.record_virtual_light(recorder, stored, index, shadow_seed, bound, bind_sums);
  Schedule schedule = recorder.compile();
  for (const uint32_t i : {0u, 17u}) {
    const double from_one = double{lights[i].flux.y} / (4 * pi * radius * radius);
    CHECK(double{lights[i].flux.y} == test::relative(0.5 * 4 * pi * intensity / 64, 1e-4));
    schedule.set(index, i);
    worst = 0;
    // Facets tilt by up to 1.5 degrees, which counts where the light is near.
    CHECK(mean(schedule, worst, from_one) == test::relative(from_one, 0.02));
  }
  // The bound holds: half of 1 / 4 R^2 is half the light.
  schedule.set(bound, static_cast<float>(0.5 / (4 * radius * radius)));
  const double halved = 0.5 * double{lights[17].flux.y} / (4 * pi * radius * radius);
  worst = 0;
  CHECK(mean(schedule, worst, halved) == test::relative(halved, 0.01));
}
