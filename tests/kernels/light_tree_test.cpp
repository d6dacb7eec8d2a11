// SPDX-License-Identifier: Apache-2.0
// kernels/lucarium/light_tree.clh: lights are chosen with the probabilities that are said, these are what the
// bounds of the lights say, and no light that reaches a point has none.
#include "lucarium/shared/light_tree.h"

#include <doctest/doctest.h>

#include <bit>
#include <cmath>
#include <glm/trigonometric.hpp>
#include <numeric>

#include "chi2.h"
#include "light_scenes.h"
#include "test_support.h"
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

Chosen choose(const SceneBuffers& buffers, const Lit& point, uint count, uint seed) {
  const auto lights = test_buffer<uint>(count);
  const auto choices = test_buffer<float2>(count);
  run_kernel(tree_program(), "choose_lights_for", count, 64, [&](PassBuilder& pass) {
    buffers.bind(pass);
    pass.arg("position", point.place()).arg("normal", point.side()).arg("seed", seed).arg("count", count);
    pass.arg("lights", lights).arg("choices", choices);
  });
  return {lights.download(), choices.download()};
}

/// Probabilities, point by point.
std::vector<float> choices_for(const SceneBuffers& buffers, const std::vector<Lit>& points) {
  std::vector<float4> positions, normals;
  for (const Lit& p : points) positions.push_back(p.place()), normals.push_back(p.side());
  const uint lights = buffers.info().light_count;
  const auto places = test_buffer(positions), sides = test_buffer(normals);
  const auto choices = test_buffer<float>(points.size() * lights);
  run_kernel(tree_program(), "light_choices", points.size(), 1, [&](PassBuilder& pass) {
    buffers.bind(pass);
    pass.arg("positions", places).arg("normals", sides).arg("count", static_cast<uint>(points.size()));
    pass.arg("light_count", lights).arg("choices", choices);
  });
  return choices.download();
}

/// What a light may send to a point, from the definition in light_tree.clh, by angles [lx].
double value_of(const SceneBuffers& buffers, const Light& light, const Lit& lit) {
  const glm::dvec3 point(lit.position);
  // As pack_lit_side() rounds it, which leaves it no unit vector.
  const glm::dvec3 normal = glm::round(glm::dvec3(lit.normal) * 511.0 + 511.0) / 511.0 - 1.0;
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
  const glm::dvec3 away = light.kind == LUCARIUM_LIGHT_DIRECTIONAL ? axis : point - center;
  const double distance = glm::length(away);
  double value = light.kind == LUCARIUM_LIGHT_DIRECTIONAL ? power : power / (distance * distance + radius * radius);
  if (lit.side().w > 0) {
    // The sphere's direction nearest to the normal; LIGHT_COSINE_SLACK.
    const double length = glm::length(normal);
    const double to_center = std::acos(std::clamp(-glm::dot(away, normal) / (distance * length), -1.0, 1.0));
    const double nearest = distance > radius ? std::max(to_center - std::asin(radius / distance), 0.0) : 0;
    const double cosine = (nearest > 0 ? length * std::cos(nearest) : 1) + 4e-3;
    value *= cosine > 0 ? 0.1 + 0.9 * cosine : 0;
  }
  if (light.kind == LUCARIUM_LIGHT_DIRECTIONAL) return value;
  if (light.kind == LUCARIUM_LIGHT_POINT || distance <= radius) return value;
  const double angle = std::acos(std::clamp(glm::dot(away, axis) / distance, -1.0, 1.0));
  const double wider = light.kind == LUCARIUM_LIGHT_TRIANGLE ? 1e-3 : 0;  // the cones of triangles
  const double least = std::max(angle - std::asin(radius / distance) - wider, 0.0);
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
  REQUIRE(lights > 170);  // 184, less slivers that nothing can hit
  const std::vector<Lit> points = points_among(3, 6);
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
    const std::vector<Lit> points = points_among(seed + 7, 60);
    const std::vector<float> choices = choices_for(buffers, points);
    const std::vector<Triangle> triangles = buffers.scene_triangles.download();
    const std::vector<Vertex> vertices = buffers.scene_vertices.download();
    const std::vector<Material> materials = buffers.scene_materials.download();
    const std::vector<Instance> instances = buffers.scene_instances.download();
    int reaching = 0, left_out = 0, wasted = 0;
    for (size_t p = 0; p < points.size(); ++p) {
      for (size_t i = 0; i < lights.size(); ++i) {
        const Light& light = lights[i];
        const glm::vec3 point = points[p].position, normal = points[p].normal;
        const auto before = [&](const glm::vec3& to) { return points[p].side().w == 0 || glm::dot(normal, to) > 0; };
        bool reaches = true;
        if (light.kind == LUCARIUM_LIGHT_DIRECTIONAL) reaches = before(-glm::vec3(light.direction.xyz()));
        if (light.kind <= LUCARIUM_LIGHT_SPOT) reaches = before(glm::vec3(light.position.xyz()) - point);
        if (light.kind == LUCARIUM_LIGHT_SPOT) {
          const glm::vec3 away = glm::normalize(point - glm::vec3(light.position.xyz()));
          reaches = reaches && glm::dot(away, glm::vec3(light.direction.xyz())) > light.spot_cos_outer;
        } else if (light.kind == LUCARIUM_LIGHT_TRIANGLE) {
          const Triangle& t = triangles[light.triangle];
          const glm::vec3 a(vertices[t.v0].position.xyz()), b(vertices[t.v1].position.xyz()),
              c(vertices[t.v2].position.xyz());
          const bool both = materials[instances[t.instance].material].flags & LUCARIUM_MATERIAL_DOUBLE_SIDED;
          const glm::vec3 across = glm::cross(b - a, c - a);
          if (glm::length(across) < 1e-4f) continue;  // a sliver, of which rounding decides where it shines
          reaches = both || glm::dot(across, point - a) > 0;
          reaches = reaches && (before(a - point) || before(b - point) || before(c - point));
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
    std::vector<Lit> points = points_among(32, 60);
    for (const SceneInstance& lamp : scene.instances) {
      const std::vector<glm::vec3>& corners = scene.meshes[lamp.mesh].positions;
      const glm::vec3 middle = (corners[0] + corners[1] + corners[2]) / 3.f;
      for (int i = 0; i < 6; ++i) {
        const glm::vec3 position = middle + 0.05f * random.direction(), normal = random.direction();
        points.push_back({position, i % 2 ? normal : glm::vec3(0)});
      }
    }
    const std::vector<float> choices = choices_for(buffers, points);
    int compared = 0;
    for (size_t p = 0; p < points.size(); ++p) {
      std::vector<double> values;
      for (const Light& light : lights) values.push_back(value_of(buffers, light, points[p]));
      if (*std::max_element(values.begin(), values.end()) == 0) continue;
      const std::vector<double> shares = shares_of(values, 0.01);
      for (size_t i = 0; i < lights.size(); ++i, ++compared)
        CHECK(double{choices[7 * p + i]} == test::relative(shares[i], 3e-3));
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
  const std::vector<Lit> points = points_among(42, 30);
  const std::vector<float> choices = choices_for(buffers, points);
  for (size_t p = 0; p < points.size(); ++p) {
    std::vector<double> near, far;
    for (size_t i = 0; i < 6; ++i) near.push_back(value_of(buffers, lights[i], points[p]));
    for (size_t i = 6; i < 8; ++i) far.push_back(value_of(buffers, lights[i], points[p]));
    const double all_near = std::accumulate(near.begin(), near.end(), 0.0);
    // Of all planes the environment lights one by pi L in the mean.
    const std::vector<double> kinds = shares_of({all_near, far[0] + far[1], pi * 0.05}, 0.1);
    const std::vector<double> of_near = shares_of(near, 0.01), of_far = shares_of(far, 0.01);
    for (size_t i = 0; i < 9; ++i) {
      const double expected = i < 6 ? kinds[0] * of_near[i] : i < 8 ? kinds[1] * of_far[i - 6] : kinds[2];
      CHECK(double{choices[9 * p + i]} == test::relative(expected, 1e-4));
    }
  }
}

// Packed normals are not of unit length; near the horizon that would count.
TEST_CASE("what rises a little above a point's horizon is not left out") {
  const auto value = [](uint kind, float radius, const glm::vec3& axis, float cone, const Lit& point) {
    std::vector<uint> node(LUCARIUM_LIGHT_NODE_WORDS);
    const auto set = [&node](uint row, float x) { node[row] = std::bit_cast<uint>(x); };
    for (uint k = 0; k < 3; ++k) set(LUCARIUM_LIGHT_NODE_AXIS + 8 * k, axis[static_cast<int>(k)]);
    set(LUCARIUM_LIGHT_NODE_RADIUS, radius);
    set(LUCARIUM_LIGHT_NODE_POWER, 1);
    set(LUCARIUM_LIGHT_NODE_COS_CONE, std::cos(cone));
    set(LUCARIUM_LIGHT_NODE_SIN_CONE, std::sin(cone));
    const auto words = test_buffer(node);
    const auto result = test_buffer<float>(1);
    run_kernel(tree_program(), "value_of_node", 1, 1, [&](PassBuilder& pass) {
      pass.arg("node", words).arg("kind", kind).arg("position", point.place()).arg("normal", point.side());
      pass.arg("value", result);
    });
    return result.download().at(0);
  };
  // Lamps in a sphere of 1 m, 1.5 mm of which are above the plane of a point beside it that looks away.
  const Lit beside = {{.7273436f, .4750952f, .4956730f}, glm::normalize(glm::vec3(.687869f, .490255f, .535244f))};
  REQUIRE(glm::dot(beside.position, beside.normal) < 0.999f);
  CHECK(value(LUCARIUM_LIGHT_POINT, 1, {0, 0, 1}, 0, beside) > 0);
  // Suns in the east and the west, 1 degree above the horizon, and a surface 2.5 degrees from facing down.
  const Lit below = {glm::vec3(0), {std::sin(glm::radians(2.5f)), 0, -std::cos(glm::radians(2.5f))}};
  CHECK(value(LUCARIUM_LIGHT_DIRECTIONAL, 0, {0, 0, -1}, glm::radians(89.f), below) > 0);
  // What stays below it.
  CHECK(value(LUCARIUM_LIGHT_DIRECTIONAL, 0, {0, 0, -1}, glm::radians(85.f), below) == 0);
  CHECK(value(LUCARIUM_LIGHT_POINT, 0.5f, {0, 0, 1}, 0, beside) == 0);
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

// Found by search: sums of three, added in two ways, differ by more than this number leaves.
TEST_CASE("who sends nothing is not chosen where sums are rounded") {
  const auto values = test_buffer(std::vector<float>{3.07442737f, 11.6135740f, 1.50554228f, 0, 0.157238275f, 0, 0, 0});
  const auto chosen = test_buffer<float2>(1);
  for (const int number : {16615874, 16615875, 16615876, 16615877}) {
    const float u = static_cast<float>(number) * 0x1p-24f;
    run_kernel(tree_program(), "choose_one", 1, 1,
               [&](PassBuilder& pass) { pass.arg("values", values).arg("u", u).arg("chosen", chosen); });
    const float2 result = chosen.download().at(0);
    CHECK((result.x == 2 || result.x == 4));
    CHECK(result.y > 0);
  }
}

TEST_CASE("few lights of one kind are chosen from the table") {
  Scene scene = empty_scene();
  Random random(51);
  const auto kinds_of_tree = [&](LightChoice choice) {
    return SceneBuffers(*test_device(), scene, choice).scene_light_trees.download()[LUCARIUM_LIGHT_TREES_KINDS];
  };
  add_random_lights(scene, random, LightType::point, 4);
  CHECK(kinds_of_tree(LightChoice::tree) == 0);
  add_random_lights(scene, random, LightType::point, 1);
  CHECK(kinds_of_tree(LightChoice::tree) == 1u << LUCARIUM_LIGHT_POINT);
  scene.lights.resize(1);
  add_random_lights(scene, random, LightType::directional, 1);
  CHECK(kinds_of_tree(LightChoice::tree) == (1u << LUCARIUM_LIGHT_POINT | 1u << LUCARIUM_LIGHT_DIRECTIONAL));
  CHECK(kinds_of_tree(LightChoice::power) == 0);
}
