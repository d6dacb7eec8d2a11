// SPDX-License-Identifier: Apache-2.0
// LightTree: every light has its place, and nodes bound what is below them.
#include "lucarium/scene/device/light_tree.h"

#include <doctest/doctest.h>

#include <bit>
#include <cmath>
#include <glm/geometric.hpp>
#include <random>

#include "lucarium/base/numbers.h"
#include "lucarium/shared/light_tree.h"
#include "tolerance.h"

using namespace lucarium;

namespace {

constexpr float half_turn = static_cast<float>(pi);

struct Lights {
  std::vector<Light> lights;
  std::vector<LightBounds> bounds;
};

/// `where`: 0 all in one place, 1 spread, 2 in clusters of very different sizes.
Lights random_lights(size_t count, int where, uint kind = LUCARIUM_LIGHT_TRIANGLE) {
  Lights result;
  std::mt19937 random(static_cast<unsigned>(count) + 1);
  std::normal_distribution<float> normal;
  std::uniform_real_distribution<float> uniform(0.f, 1.f);
  const auto vector = [&] {
    const float x = normal(random), y = normal(random), z = normal(random);
    return glm::vec3(x, y, z);
  };
  for (size_t i = 0; i < count; ++i) {
    LightBounds b;
    const float scale = where == 2 ? std::pow(10.f, -3 * uniform(random)) : 3.f;
    const glm::vec3 center = where == 0 ? glm::vec3(1, 2, 3) : 7.f * static_cast<float>(i % 5) + scale * vector();
    const glm::vec3 half = kind == LUCARIUM_LIGHT_TRIANGLE ? 0.1f * glm::abs(vector()) : glm::vec3(0);
    b.lower = center - half, b.upper = center + half;
    b.axis = glm::normalize(i % 4 ? vector() : vector() * 0.01f + glm::vec3(0, 0, i % 8 ? 1 : -1));
    b.spread = i % 7 == 3 ? half_turn : 0.f;
    b.reach = kind == LUCARIUM_LIGHT_SPOT ? 0.2f + uniform(random) : 0.5f * half_turn;
    b.power = std::exp(normal(random));
    Light light{};
    light.kind = kind;
    result.lights.push_back(light);
    result.bounds.push_back(b);
  }
  return result;
}

float row(const LightTree& tree, uint node, uint offset, uint child) {
  return std::bit_cast<float>(tree.nodes[node + offset + child]);
}

/// Checks a child's bounds against a light below it.
void check_bounds(const LightTree& tree, uint node, uint child, const LightBounds& light) {
  const glm::vec3 center(row(tree, node, LUCARIUM_LIGHT_NODE_CENTER, child),
                         row(tree, node, LUCARIUM_LIGHT_NODE_CENTER + 8, child),
                         row(tree, node, LUCARIUM_LIGHT_NODE_CENTER + 16, child));
  const float radius = row(tree, node, LUCARIUM_LIGHT_NODE_RADIUS, child);
  for (int corner = 0; corner < 8; ++corner) {
    const glm::vec3 at(corner & 1 ? light.upper.x : light.lower.x, corner & 2 ? light.upper.y : light.lower.y,
                       corner & 4 ? light.upper.z : light.lower.z);
    REQUIRE(glm::length(at - center) <= radius * (1 + 1e-6f));
  }
  const glm::vec3 axis(row(tree, node, LUCARIUM_LIGHT_NODE_AXIS, child),
                       row(tree, node, LUCARIUM_LIGHT_NODE_AXIS + 8, child),
                       row(tree, node, LUCARIUM_LIGHT_NODE_AXIS + 16, child));
  const float cos_cone = row(tree, node, LUCARIUM_LIGHT_NODE_COS_CONE, child);
  const float sin_cone = row(tree, node, LUCARIUM_LIGHT_NODE_SIN_CONE, child);
  REQUIRE(glm::length(axis) == test::relative(1, 1e-5));
  REQUIRE(cos_cone * cos_cone + sin_cone * sin_cone == test::relative(1, 1e-5));
  const float cone = std::atan2(sin_cone, cos_cone);
  const float angle = 2 * std::asin(std::min(0.5f * glm::length(axis - light.axis), 1.f));
  if (light.spread >= half_turn)
    REQUIRE(cos_cone == -1);
  else
    REQUIRE(angle + light.spread <= cone + 1e-6f);
  REQUIRE(row(tree, node, LUCARIUM_LIGHT_NODE_COS_REACH, child) <= std::cos(light.reach));
}

}  // namespace

TEST_CASE("light tree: every light has one place, below bounds that hold it") {
  for (const size_t count : {1u, 2u, 8u, 9u, 64u, 1000u}) {
    for (int where = 0; where < 3; ++where) {
      for (const uint kind : {LUCARIUM_LIGHT_POINT, LUCARIUM_LIGHT_SPOT, LUCARIUM_LIGHT_TRIANGLE}) {
        CAPTURE(count);
        CAPTURE(where);
        CAPTURE(kind);
        const Lights lights = random_lights(count, where, kind);
        const LightTree tree = make_light_tree(lights.lights, lights.bounds, true);
        REQUIRE(tree.nodes.size() <= light_tree_capacity(count));
        REQUIRE(tree.places.size() == count);
        const uint root = tree.header[LUCARIUM_LIGHT_TREES_ROOTS + kind];
        std::vector<double> below(tree.nodes.size());  // per place: power of the lights that have come by
        for (uint i = 0; i < count; ++i) {
          uint place = tree.places[i], steps = 0;
          REQUIRE(tree.nodes[(place & ~7u) + LUCARIUM_LIGHT_NODE_CHILD + (place & 7u)] == (LUCARIUM_LIGHT_LEAF | i));
          for (;;) {
            const uint node = place & ~7u, child = place & 7u;
            check_bounds(tree, node, child, lights.bounds[i]);
            below[place] += static_cast<double>(lights.bounds[i].power);
            REQUIRE(++steps < 64);
            if (node == root) break;
            place = tree.nodes[node + LUCARIUM_LIGHT_NODE_PLACE];
            REQUIRE(tree.nodes[(place & ~7u) + LUCARIUM_LIGHT_NODE_CHILD + (place & 7u)] == node);
          }
          REQUIRE(tree.nodes[root + LUCARIUM_LIGHT_NODE_PLACE] == LUCARIUM_NONE);
        }
        // A child's power is that of the lights below it; where there are none there is no child.
        for (uint node = 0; node < tree.nodes.size(); node += LUCARIUM_LIGHT_NODE_WORDS)
          for (uint child = 0; child < 8; ++child)
            REQUIRE(static_cast<double>(row(tree, node, LUCARIUM_LIGHT_NODE_POWER, child)) ==
                    test::relative(below[node + child], 1e-4));
      }
    }
  }
}

TEST_CASE("light tree: lights beside each other, and those that shine the same way, stay together") {
  // Two rooms far from each other with 16 lamps each; in each half of them shine up, half of them down, crosswise.
  Lights lights;
  for (int i = 0; i < 32; ++i) {
    LightBounds b;
    const glm::vec3 place(0.1f * static_cast<float>(i % 4), 0.1f * static_cast<float>(i / 4 % 4), 0);
    b.lower = b.upper = place + glm::vec3(i < 16 ? 0 : 100, 0, 0);
    b.axis = glm::vec3(0, 0, i / 8 % 2 ? 1 : -1);
    b.reach = 0.5f * half_turn;
    b.power = 1;
    Light light{};
    light.kind = LUCARIUM_LIGHT_TRIANGLE;
    lights.lights.push_back(light);
    lights.bounds.push_back(b);
  }
  const LightTree tree = make_light_tree(lights.lights, lights.bounds, true);
  const uint root = tree.header[LUCARIUM_LIGHT_TREES_ROOTS + LUCARIUM_LIGHT_TRIANGLE];
  int children = 0;
  for (uint child = 0; child < 8; ++child) {
    if (row(tree, root, LUCARIUM_LIGHT_NODE_POWER, child) == 0) continue;
    ++children;
    CHECK(row(tree, root, LUCARIUM_LIGHT_NODE_RADIUS, child) < 1);
    CHECK(row(tree, root, LUCARIUM_LIGHT_NODE_COS_CONE, child) > 0.99f);
  }
  CHECK(children >= 4);
}

TEST_CASE("light tree: lights in a row are as few steps away as others") {
  Lights lights = random_lights(1000, 1, LUCARIUM_LIGHT_POINT);
  for (size_t i = 0; i < lights.bounds.size(); ++i)
    lights.bounds[i].lower = lights.bounds[i].upper = glm::vec3(static_cast<float>(i), 2, 0);
  const LightTree tree = make_light_tree(lights.lights, lights.bounds, true);
  for (const uint first : tree.places) {
    int steps = 1;
    for (uint place = first; (place = tree.nodes[(place & ~7u) + LUCARIUM_LIGHT_NODE_PLACE]) != LUCARIUM_NONE;) ++steps;
    REQUIRE(steps <= 6);
  }
}

TEST_CASE("light tree: without a tree nothing is in use; lights at infinity need no node") {
  Lights lights = random_lights(20, 1);
  const LightTree none = make_light_tree(lights.lights, lights.bounds, false);
  CHECK(none.header[LUCARIUM_LIGHT_TREES_KINDS] == 0);
  CHECK(none.nodes.empty());
  Light sky{};
  sky.kind = LUCARIUM_LIGHT_ENVIRONMENT;
  LightBounds of_sky;
  of_sky.power = 3;
  lights.lights.push_back(sky);
  lights.bounds.push_back(of_sky);
  const LightTree both = make_light_tree(lights.lights, lights.bounds, true);
  CHECK(both.header[LUCARIUM_LIGHT_TREES_KINDS] == (1u << LUCARIUM_LIGHT_TRIANGLE | 1u << LUCARIUM_LIGHT_ENVIRONMENT));
  CHECK(std::bit_cast<float>(both.header[LUCARIUM_LIGHT_TREES_POWERS + LUCARIUM_LIGHT_ENVIRONMENT]) == 3);
  CHECK(both.places.back() == LUCARIUM_NONE);
}
