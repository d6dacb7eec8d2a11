// SPDX-License-Identifier: Apache-2.0
// kernels/lucarium/lights.clh: samples follow their densities, densities agree with those of met light, lights are
// chosen as the table says.
#include <doctest/doctest.h>

#include <cmath>

#include "chi2.h"
#include "light_scenes.h"
#include "test_support.h"
#include "tolerance.h"

using namespace lucarium;
using namespace lucarium::test;

namespace {

/// A single-sided triangle above the origin, its black back on another side of it, and a double-sided one seen from
/// its back.
Scene triangle_scene() {
  Scene scene = empty_scene();
  add_triangle(scene, emitter(2), {-1, -1, 2}, {0.5f, 1.5f, 2}, {1.5f, -1, 2.5f});
  add_triangle(scene, two_sided(emitter(1)), {3, -1, -0.5f}, {2, -0.5f, -2}, {3, 1.5f, -0.8f});
  add_triangle(scene, emitter(3), {-3, 1, -1}, {-3, -1, 1}, {-3, -1, -1});
  return scene;
}

/// So many that a tree chooses, all facing the origin, none before another.
Scene dome_scene() {
  Scene scene = empty_scene();
  for (int i = 0; i < 24; ++i) {
    const float turn = 2.4f * static_cast<float>(i), height = 0.9f - 0.07f * static_cast<float>(i);
    const float ring = std::sqrt(1 - height * height), distance = 2 + 0.05f * static_cast<float>(i % 5);
    const glm::vec3 axis(ring * std::cos(turn), ring * std::sin(turn), height);
    const glm::vec3 side = 0.25f * glm::normalize(glm::cross(axis, glm::vec3(0.3f, 0.5f, 0.8f)));
    const glm::vec3 up = glm::cross(axis, side), center = distance * axis;
    add_triangle(scene, emitter(i % 3 ? 0.5f : 20.f), center + side, center - up, center - side + up);
  }
  return scene;
}

}  // namespace

TEST_CASE("light samples follow the density with which met light is weighted") {
  const int columns = full_run() ? 101 : 32, rows = full_run() ? 202 : 64;
  const uint n = full_run() ? 1u << 20 : 1u << 17;
  const std::pair<Scene, glm::vec3> cases[] = {{environment_scene(), glm::vec3(0)},
                                               {triangle_scene(), glm::vec3(0)},
                                               {triangle_scene(), glm::vec3(0.5f, 0.2f, 0.7f)}};
  for (const auto& [scene, position] : cases) {
    const SceneBuffers buffers(*test_device(), scene);
    const auto masses = test_buffer<float>(columns * rows);
    run_kernel(light_program(), "integrate_light_density", columns * rows, 1, [&](PassBuilder& pass) {
      buffers.bind(pass);
      pass.arg("position", float4(position, 0.f)).arg("columns", static_cast<uint>(columns));
      pass.arg("rows", static_cast<uint>(rows)).arg("masses", masses);
    });
    const LightSamples samples = sample(buffers, position, n);
    const std::vector<float4> met = meet(buffers, position, samples.directions);
    std::vector<uint64_t> observed(columns * rows);
    uint64_t different_density = 0, different_light = 0, lost = 0;
    for (uint i = 0; i < n; ++i) {
      const float4 d = samples.directions[i];
      if (!(d.w > 0)) {
        ++lost;
        continue;
      }
      const double turns = std::atan2(double(d.y), double(d.x)) / (2 * pi);
      const int a = std::clamp(static_cast<int>((1 - double(d.z)) * 0.5 * columns), 0, columns - 1);
      const int b = std::clamp(static_cast<int>((turns < 0 ? turns + 1 : turns) * rows), 0, rows - 1);
      ++observed[a * rows + b];
      different_density += !(std::abs(met[i].w - d.w) <= 2e-3f * d.w);
      const float green = samples.radiances[i].y;
      different_light += !(std::abs(met[i].y - green) <= 2e-3f * green + 1e-4f);
    }
    CHECK(lost == 0);
    // Directions on the edge of a texel or triangle may fall on its other side.
    CHECK(different_density <= n / 2000);
    CHECK(different_light <= n / 2000);
    double total = 0;
    std::vector<double> expected;
    for (const float mass : masses.download()) total += mass, expected.push_back(mass);
    CHECK(total == test::relative(1, 2e-3));
    for (double& e : expected) e *= n / total;
    const Chi2Result result = chi2_test(observed, expected);
    CHECK(result.stray == 0);
    CHECK(result.p >= sidak(0.01, 3));
  }
}

// How often each lamp is chosen light_tree_test compares; the grid above would miss slivers of so many triangles.
TEST_CASE("samples of many lamps have the density with which met light is weighted") {
  const SceneBuffers buffers(*test_device(), dome_scene());
  const uint n = full_run() ? 1u << 20 : 1u << 16;
  for (const glm::vec3& position : {glm::vec3(0), glm::vec3(0.1f, -0.2f, 0.15f)}) {
    const LightSamples samples = sample(buffers, position, n);
    const std::vector<float4> met = meet(buffers, position, samples.directions);
    uint64_t different_density = 0, different_light = 0, lost = 0;
    for (uint i = 0; i < n; ++i) {
      const float pdf = samples.directions[i].w, green = samples.radiances[i].y;
      lost += !(pdf > 0);
      different_density += !(std::abs(met[i].w - pdf) <= 2e-3f * pdf);
      different_light += !(std::abs(met[i].y - green) <= 2e-3f * green + 1e-4f);
    }
    CHECK(lost == 0);
    CHECK(different_density <= n / 2000);  // directions on the edge of a triangle, as above
    CHECK(different_light <= n / 2000);
  }
}

TEST_CASE("shadow rays end in front of the light's surface") {
  const SceneBuffers buffers(*test_device(), triangle_scene());
  const auto triangles = buffers.scene_triangles.download();
  const auto vertices = buffers.scene_vertices.download();
  const LightSamples samples = sample(buffers, glm::vec3(0), 4096);
  for (size_t i = 0; i < samples.ends.size(); ++i) {
    double nearest = 1e30;
    for (const Triangle& t : triangles) {
      const glm::dvec3 a(vertices[t.v0].position.xyz()), b(vertices[t.v1].position.xyz()),
          c(vertices[t.v2].position.xyz());
      const glm::dvec3 normal = glm::normalize(glm::cross(b - a, c - a));
      // Height of the end over the plane, positive on the origin's side; only of the plane it belongs to.
      const double height =
          glm::dot(glm::dvec3(samples.ends[i].xyz()) - a, normal) * (glm::dot(-a, normal) > 0 ? 1 : -1);
      if (std::abs(height) < std::abs(nearest)) nearest = height;
    }
    REQUIRE(nearest > 0);
    REQUIRE(nearest < 1e-3);
  }
}

// A float's 24 bits leave 64 places inside each of 2^18 columns; these intensities put the alias threshold where
// rounding to them favoured the dim light by 3 %.
TEST_CASE("dim lights among a quarter of a million are chosen no more often than the table says") {
  Scene scene = triangle_scene();
  scene.lights.resize(1 << 18);
  for (size_t i = 0; i < scene.lights.size(); ++i) {
    scene.lights[i].intensity = glm::vec3(i % 2 ? 1.0f : 9.766f);
    scene.lights[i].world_from_light[3] = glm::vec4(0, 0, 1, 1);
  }
  const SceneBuffers buffers(*test_device(), scene);
  const uint n = 1 << 22;
  const auto lights = test_buffer<uint>(n);
  run_kernel(light_program(), "choose_lights_at_random", n, 64, [&](PassBuilder& pass) {
    buffers.bind(pass);
    pass.arg("count", n).arg("lights", lights);
  });
  const auto table = buffers.scene_light_table.download();
  const auto is_dim = [&](uint light) { return table[light].pmf < 1.0f / static_cast<float>(table.size()); };
  const double threshold = 64.0 * table[scene.lights.size() - 1].probability;
  REQUIRE(threshold - std::floor(threshold) < 0.25);
  double expected = 0, chosen = 0;
  for (uint i = 0; i < table.size(); ++i) expected += is_dim(i) ? table[i].pmf : 0;
  for (const uint light : lights.download()) chosen += is_dim(light) ? 1 : 0;
  REQUIRE(expected > 0.05);
  REQUIRE(expected < 0.5);
  const double standard_error = std::sqrt(expected * (1 - expected) / n);
  CHECK(std::abs(chosen / n - expected) < 4 * standard_error);
}

TEST_CASE("lights are chosen as the table says; kinds can be left out") {
  Scene scene = triangle_scene();
  SceneLight light;
  light.intensity = glm::vec3(30);
  light.world_from_light[3] = glm::vec4(0, 0, 1, 1);
  scene.lights = {light};
  scene.environment = Environment{};
  const SceneBuffers buffers(*test_device(), scene);
  const uint n = 1 << 16;
  const auto lights = test_buffer<uint>(n);
  const auto pmfs = test_buffer<float>(n);
  run_kernel(light_program(), "choose_lights", n, 64, [&](PassBuilder& pass) {
    buffers.bind(pass);
    pass.arg("count", n).arg("lights", lights).arg("pmfs", pmfs);
  });
  const auto table = buffers.scene_light_table.download();
  const auto chosen = lights.download();
  const auto pmf = pmfs.download();
  REQUIRE(buffers.info().light_count == 5);
  std::vector<double> share(5);
  for (uint i = 0; i < n; ++i) {
    share[chosen[i]] += 1.0 / n;
    REQUIRE(pmf[i] == table[chosen[i]].pmf);
  }
  for (int i = 0; i < 5; ++i) CHECK(share[i] == test::relative(table[i].pmf, 1e-3));

  const LightSamples no_triangles = sample(buffers, glm::vec3(0), 4096, all_kinds & ~(1u << LUCARIUM_LIGHT_TRIANGLE));
  const LightSamples punctual_only = sample(buffers, glm::vec3(0), 4096, 1u << LUCARIUM_LIGHT_POINT);
  uint punctual = 0, infinite = 0, finite_area = 0, others = 0;
  for (size_t i = 0; i < 4096; ++i) {
    const int flags = static_cast<int>(no_triangles.radiances[i].w);
    if (no_triangles.directions[i].w > 0) ++(flags == 1 ? punctual : flags == 2 ? infinite : finite_area);
    others += punctual_only.directions[i].w > 0 && static_cast<int>(punctual_only.radiances[i].w) != 1;
  }
  CHECK(punctual > 0);
  CHECK(infinite > 0);
  CHECK(finite_area == 0);
  CHECK(others == 0);
}
