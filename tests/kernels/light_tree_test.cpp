// SPDX-License-Identifier: Apache-2.0
// kernels/lucarium/light_tree.clh: lights are chosen with the probabilities that are said, these are what the bounds of
// the lights say, and no light that reaches a point has none.
#include "lucarium/shared/light_tree.h"

#include <doctest/doctest.h>

#include <cmath>
#include <numeric>

#include "chi2.h"
#include "light_scenes.h"
#include "tolerance.h"

using namespace lucarium;
using namespace lucarium::test;

namespace {

const Program& tree_program() {
  static const Program instance = kernel_program("light_tree");
  return instance;
}

struct Chosen {
  std::vector<uint> lights;
  std::vector<float2> choices;
};

Chosen choose(const SceneBuffers& buffers, const glm::vec3& position, uint count, uint seed) {
  const auto lights = test_buffer<uint>(count);
  const auto choices = test_buffer<float2>(count);
  run_kernel(tree_program(), "choose_lights_for", count, 64, [&](PassBuilder& pass) {
    buffers.bind(pass);
    pass.arg("position", float4(position, 0.f)).arg("seed", seed).arg("count", count);
    pass.arg("lights", lights).arg("choices", choices);
  });
  return {lights.download(), choices.download()};
}

/// Probabilities, point by point.
std::vector<float> choices_for(const SceneBuffers& buffers, const std::vector<glm::vec3>& points) {
  std::vector<float4> positions;
  for (const glm::vec3& p : points) positions.emplace_back(p, 0.f);
  const uint lights = buffers.info().light_count;
  const auto places = test_buffer(positions);
  const auto choices = test_buffer<float>(points.size() * lights);
  run_kernel(tree_program(), "light_choices", points.size(), 1, [&](PassBuilder& pass) {
    buffers.bind(pass);
    pass.arg("positions", places).arg("count", static_cast<uint>(points.size()));
    pass.arg("light_count", lights).arg("choices", choices);
  });
  return choices.download();
}

class Random {
 public:
  explicit Random(uint seed) : engine_(seed) {}
  float number(float from, float to) { return std::uniform_real_distribution<float>(from, to)(engine_); }
  glm::vec3 point(float extent) {
    const float x = number(-extent, extent), y = number(-extent, extent), z = number(-extent, extent);
    return {x, y, z};
  }
  glm::vec3 direction() {
    for (;;) {
      const glm::vec3 p = point(1);
      if (glm::length(p) > 0.1f && glm::length(p) < 1) return glm::normalize(p);
    }
  }

 private:
  std::mt19937 engine_;
};

void add_random_triangles(Scene& scene, Random& random, int count) {
  for (int i = 0; i < count; ++i) {
    const glm::vec3 center = random.point(5);
    const glm::vec3 a = center + random.point(0.4f), b = center + random.point(0.4f), c = center + random.point(0.4f);
    const SceneMaterial material = emitter(std::exp(random.number(-2, 2)));
    add_triangle(scene, i % 5 == 0 ? two_sided(material) : material, a, b, c);
  }
}

void add_random_lights(Scene& scene, Random& random, LightType type, int count) {
  for (int i = 0; i < count; ++i) {
    const glm::vec3 position = random.point(5);
    add_light(scene, type, std::exp(random.number(-2, 2)), position, position + random.direction());
    scene.lights.back().inner_angle = random.number(0, 0.4f);
    scene.lights.back().outer_angle = scene.lights.back().inner_angle + random.number(0.05f, 1.1f);
  }
}

/// Lights of all kinds, so many that their trees have several levels.
Scene many_lights(uint seed = 11) {
  Scene scene = empty_scene();
  Random random(seed);
  add_random_triangles(scene, random, 90);
  add_random_lights(scene, random, LightType::point, 20);
  add_random_lights(scene, random, LightType::spot, 70);
  add_random_lights(scene, random, LightType::directional, 3);
  set_environment(scene, 0.02f);
  return scene;
}

std::vector<glm::vec3> points_among(uint seed, int count) {
  Random random(seed);
  std::vector<glm::vec3> points;
  for (int i = 0; i < count; ++i) points.push_back(random.point(i % 3 == 0 ? 12.f : 5.f));
  return points;
}

/// What a light may send to a point, from the definition in light_tree.clh, by angles [lx].
double value_of(const SceneBuffers& buffers, const Light& light, const glm::dvec3& point) {
  const glm::dvec3 intensity(light.intensity.xyz());
  const double mean = (intensity.x + intensity.y + intensity.z) / 3;
  glm::dvec3 center(light.position.xyz()), axis(light.direction.xyz());
  double power = mean, radius = 0;
  if (light.kind == LUCARIUM_LIGHT_TRIANGLE) {
    const Triangle t = buffers.scene_triangles.download(light.triangle, 1).at(0);
    std::vector<glm::dvec3> corners;
    for (const uint v : {t.v0, t.v1, t.v2})
      corners.emplace_back(buffers.scene_vertices.download(v, 1)[0].position.xyz());
    const glm::dvec3 lower = glm::min(corners[0], glm::min(corners[1], corners[2]));
    const glm::dvec3 upper = glm::max(corners[0], glm::max(corners[1], corners[2]));
    center = 0.5 * (lower + upper), radius = 0.5 * glm::length(upper - lower);
    const glm::dvec3 across = glm::cross(corners[1] - corners[0], corners[2] - corners[0]);
    axis = glm::normalize(across);
    power = mean * 0.5 * glm::length(across);
  }
  const glm::dvec3 away = point - center;
  const double distance = glm::length(away), value = power / (distance * distance + radius * radius);
  if (light.kind == LUCARIUM_LIGHT_POINT || distance <= radius) return value;
  const double angle = std::acos(std::clamp(glm::dot(away, axis) / distance, -1.0, 1.0));
  const double least = std::max(angle - std::asin(radius / distance), 0.0);
  if (light.kind == LUCARIUM_LIGHT_TRIANGLE) return value * std::max(std::cos(least), 0.0);
  return std::cos(least) > static_cast<double>(light.spot_cos_outer) ? value : 0;
}

/// Parts of what each sends, with a part that is the same for all that send anything.
std::vector<double> shares_of(const std::vector<double>& values, double even) {
  const double sum = std::accumulate(values.begin(), values.end(), 0.0);
  const auto present = std::count_if(values.begin(), values.end(), [](double v) { return v > 0; });
  std::vector<double> shares;
  for (const double v : values)
    shares.push_back(v > 0 ? (1 - even) * v / sum + even / static_cast<double>(present) : 0);
  return shares;
}

}  // namespace

TEST_CASE("lights are chosen for a point with the probabilities that are said") {
  const SceneBuffers buffers(*test_device(), many_lights());
  const uint lights = buffers.info().light_count, n = full_run() ? 1u << 20 : 1u << 16;
  REQUIRE(lights == 184);
  const std::vector<glm::vec3> points = points_among(3, 6);
  const std::vector<float> choices = choices_for(buffers, points);
  for (size_t p = 0; p < points.size(); ++p) {
    CAPTURE(p);
    const Chosen chosen = choose(buffers, points[p], n, 5 + static_cast<uint>(p));
    std::vector<uint64_t> observed(lights + 1);
    uint64_t different = 0;
    for (uint i = 0; i < n; ++i) {
      const bool any = chosen.lights[i] != LUCARIUM_NONE;
      ++observed[any ? chosen.lights[i] : lights];
      different += !(std::abs(chosen.choices[i].x - chosen.choices[i].y) <= 1e-5f * chosen.choices[i].y);
    }
    CHECK(different == 0);
    // Whoever goes down to lights that send nothing chooses none.
    std::vector<double> expected;
    double none = 1;
    for (uint i = 0; i < lights; ++i) {
      expected.push_back(n * double{choices[p * lights + i]});
      none -= double{choices[p * lights + i]};
    }
    CHECK(none > -1e-5);
    expected.push_back(n * std::max(none, 1e-7));
    const Chi2Result result = chi2_test(observed, expected);
    CHECK(result.p >= sidak(0.01, static_cast<int>(points.size())));
  }
}

TEST_CASE("no light that reaches a point is left out") {
  for (const uint seed : {21u, 22u, 23u}) {
    const Scene scene = many_lights(seed);
    const SceneBuffers buffers(*test_device(), scene);
    const std::vector<Light> lights = buffers.scene_lights.download(0, buffers.info().light_count);
    const std::vector<glm::vec3> points = points_among(seed + 7, 40);
    const std::vector<float> choices = choices_for(buffers, points);
    const std::vector<Triangle> triangles = buffers.scene_triangles.download();
    const std::vector<Vertex> vertices = buffers.scene_vertices.download();
    const std::vector<Material> materials = buffers.scene_materials.download();
    const std::vector<Instance> instances = buffers.scene_instances.download();
    int reaching = 0, left_out = 0, wasted = 0;
    for (size_t p = 0; p < points.size(); ++p) {
      for (size_t i = 0; i < lights.size(); ++i) {
        const Light& light = lights[i];
        bool reaches = true;
        if (light.kind == LUCARIUM_LIGHT_SPOT) {
          const glm::vec3 away = glm::normalize(points[p] - glm::vec3(light.position.xyz()));
          reaches = glm::dot(away, glm::vec3(light.direction.xyz())) > light.spot_cos_outer;
        } else if (light.kind == LUCARIUM_LIGHT_TRIANGLE) {
          const Triangle& t = triangles[light.triangle];
          const glm::vec3 a(vertices[t.v0].position.xyz()), b(vertices[t.v1].position.xyz()),
              c(vertices[t.v2].position.xyz());
          const bool both = materials[instances[t.instance].material].flags & LUCARIUM_MATERIAL_DOUBLE_SIDED;
          reaches = both || glm::dot(glm::cross(b - a, c - a), points[p] - a) > 0;
        }
        const bool chosen = choices[p * lights.size() + i] > 0;
        reaching += reaches;
        left_out += reaches && !chosen;
        wasted += !reaches && chosen;
      }
    }
    CHECK(left_out == 0);
    // Few others: triangles that are seen under a large angle, spots just beyond their cone.
    CHECK(reaching > 3000);
    CHECK(wasted < reaching / 20);
  }
}

TEST_CASE("the lights of one node share as their bounds say") {
  Random random(31);
  for (const uint kind : {LUCARIUM_LIGHT_POINT, LUCARIUM_LIGHT_SPOT, LUCARIUM_LIGHT_TRIANGLE}) {
    CAPTURE(kind);
    Scene scene = empty_scene();
    if (kind == LUCARIUM_LIGHT_TRIANGLE) {
      for (int i = 0; i < 7; ++i) {
        const glm::vec3 center = random.point(5);
        const glm::vec3 a = center + random.point(0.4f), b = center + random.point(0.4f);
        add_triangle(scene, emitter(std::exp(random.number(-2, 2))), a, b, center + random.point(0.4f));
      }
    } else {
      add_random_lights(scene, random, kind == LUCARIUM_LIGHT_SPOT ? LightType::spot : LightType::point, 7);
    }
    const SceneBuffers buffers(*test_device(), scene);
    const std::vector<Light> lights = buffers.scene_lights.download(0, buffers.info().light_count);
    REQUIRE(lights.size() == 7);
    // Also points so near to a lamp that they are in its sphere, on both sides.
    std::vector<glm::vec3> points = points_among(32, 60);
    for (const SceneInstance& lamp : scene.instances) {
      const std::vector<glm::vec3>& corners = scene.meshes[lamp.mesh].positions;
      const glm::vec3 middle = (corners[0] + corners[1] + corners[2]) / 3.f;
      for (int i = 0; i < 6; ++i) points.push_back(middle + 0.05f * random.direction());
    }
    const std::vector<float> choices = choices_for(buffers, points);
    int compared = 0;
    for (size_t p = 0; p < points.size(); ++p) {
      std::vector<double> values;
      for (const Light& light : lights) values.push_back(value_of(buffers, light, glm::dvec3(points[p])));
      if (*std::max_element(values.begin(), values.end()) == 0) continue;
      const std::vector<double> shares = shares_of(values, 0.01);
      for (size_t i = 0; i < lights.size(); ++i, ++compared)
        CHECK(static_cast<double>(choices[7 * p + i]) == test::relative(shares[i], 2e-3));
    }
    CHECK(compared > 200);
  }
}

TEST_CASE("kinds of lights share as they send") {
  Scene scene = empty_scene();
  Random random(41);
  add_random_lights(scene, random, LightType::point, 6);
  add_random_lights(scene, random, LightType::directional, 2);
  set_environment(scene, 0.05f);
  const SceneBuffers buffers(*test_device(), scene);
  const std::vector<Light> lights = buffers.scene_lights.download(0, buffers.info().light_count);
  REQUIRE(lights.size() == 9);
  const std::vector<glm::vec3> points = points_among(42, 20);
  const std::vector<float> choices = choices_for(buffers, points);
  const auto mean = [&](size_t i) { return double{lights[i].intensity.x}; };  // all are white
  for (size_t p = 0; p < points.size(); ++p) {
    std::vector<double> near;
    for (size_t i = 0; i < 6; ++i) near.push_back(value_of(buffers, lights[i], glm::dvec3(points[p])));
    const double all_near = std::accumulate(near.begin(), near.end(), 0.0);
    // The environment's light from all directions: 4 pi L.
    const std::vector<double> kinds = shares_of({all_near, mean(6) + mean(7), 4 * pi * 0.05}, 0.1);
    const std::vector<double> of_near = shares_of(near, 0.01), of_far = shares_of({mean(6), mean(7)}, 0.01);
    for (size_t i = 0; i < 9; ++i) {
      const double expected = i < 6 ? kinds[0] * of_near[i] : i < 8 ? kinds[1] * of_far[i - 6] : kinds[2];
      CHECK(static_cast<double>(choices[9 * p + i]) == test::relative(expected, 1e-4));
    }
  }
}

// A float's 24 bits leave 16 numbers in a part of 2^-20, by which the choices below it would be made.
TEST_CASE("what a choice among lights leaves of its number is as random as before") {
  const uint n = 1 << 16, bins = 256;
  const auto left = test_buffer<float2>(n);
  run_kernel(tree_program(), "numbers_left", n, 64, [&](PassBuilder& pass) { pass.arg("count", n).arg("left", left); });
  std::vector<uint64_t> observed(bins);
  for (const float2& number : left.download()) {
    REQUIRE(number.x >= 0);
    REQUIRE(number.x < 1);
    REQUIRE(number.y == test::relative(0x1p-20, 1e-6));
    ++observed[static_cast<size_t>(number.x * static_cast<float>(bins))];
  }
  CHECK(chi2_test(observed, std::vector<double>(bins, double{n} / bins)).p >= 0.01);
}

TEST_CASE("few lights are chosen from the table, whatever the point") {
  Scene scene = empty_scene();
  Random random(51);
  add_random_lights(scene, random, LightType::point, 4);
  add_random_lights(scene, random, LightType::directional, 3);
  const SceneBuffers few(*test_device(), scene);
  add_random_lights(scene, random, LightType::point, 1);
  const SceneBuffers more(*test_device(), scene), by_power(*test_device(), scene, LightChoice::power);
  CHECK(few.scene_light_tree.download()[LUCARIUM_LIGHT_TREE_KINDS] == 0);
  CHECK(by_power.scene_light_tree.download()[LUCARIUM_LIGHT_TREE_KINDS] == 0);
  CHECK(more.scene_light_tree.download()[LUCARIUM_LIGHT_TREE_KINDS] ==
        (1u << LUCARIUM_LIGHT_POINT | 1u << LUCARIUM_LIGHT_DIRECTIONAL));
}
