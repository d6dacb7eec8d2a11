// SPDX-License-Identifier: Apache-2.0
// Order of the leaves: what nodes must not mix.
#include "micro_rendering/tree/tree_order.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <random>

using namespace lucarium::micro;

namespace {

SampledPoint point(float x, float y, float z, float facing) {
  SampledPoint p;
  p.position = {x, y, z};
  p.normal = {0, 0, facing};
  return p;
}

/// Share of the nodes of 2^level leaves that hold points of both kinds.
double mixed(const std::vector<uint32_t>& order, size_t leaves, const std::vector<int>& kind) {
  size_t count = 0;
  for (size_t i = 0; i < order.size(); i += leaves) {
    size_t ones = 0;
    for (size_t k = i; k < i + leaves; ++k) ones += static_cast<size_t>(kind[order[k]]);
    count += ones > 0 && ones < leaves;
  }
  return static_cast<double>(count * leaves) / static_cast<double>(order.size());
}

/// Largest extent of the nodes of 2^level leaves in the plane.
float widest(const std::vector<uint32_t>& order, size_t leaves, const std::vector<SampledPoint>& points) {
  float most = 0;
  for (size_t i = 0; i < order.size(); i += leaves) {
    glm::vec2 low(INFINITY), high(-INFINITY);
    for (size_t k = i; k < i + leaves; ++k) {
      low = glm::min(low, glm::vec2(points[order[k]].position));
      high = glm::max(high, glm::vec2(points[order[k]].position));
    }
    most = std::max({most, high.x - low.x, high.y - low.y});
  }
  return most;
}

}  // namespace

TEST_CASE("nodes do not mix parallel layers nor the sides of a sheet, however many points each has") {
  for (const float facing : {1.f, -1.f}) {
    for (const size_t front : {2048u, 1024u, 3700u}) {
      CAPTURE(facing);
      CAPTURE(front);
      std::mt19937 random(3);
      std::uniform_real_distribution<float> u(0, 1);
      std::vector<SampledPoint> points;
      std::vector<int> kind;
      for (size_t i = 0; i < 4096; ++i) {
        kind.push_back(i < front);
        points.push_back(i < front ? point(u(random), u(random), 0, 1) : point(u(random), u(random), 0.02f, facing));
      }
      const std::vector<uint32_t> order = tree_order(points, 1);
      // At most one mixed node per size; without parting all of them are.
      CHECK(mixed(order, 64, kind) <= 64. / 4096);
      CHECK(mixed(order, 16, kind) <= 16. / 4096);
      // As compact as 64 of the rarer layer's points can be, within 3.
      const double density = static_cast<double>(std::min(front, 4096 - front));
      CHECK(widest(order, 64, points) < 3 * std::sqrt(64 / density));
    }
  }
}

TEST_CASE("nodes do not mix two faces along the edge where they meet, however many points each has") {
  for (const size_t top : {2048u, 1024u, 3700u}) {
    CAPTURE(top);
    const glm::mat3 turn(glm::rotate(glm::mat4(1), 0.5f, glm::normalize(glm::vec3(1, 2, 3))));
    std::mt19937 random(11);
    std::uniform_real_distribution<float> u(0, 1);
    std::vector<SampledPoint> points;
    std::vector<int> kind;
    for (size_t i = 0; i < 4096; ++i) {
      kind.push_back(i < top);
      SampledPoint p = i < top ? point(u(random), u(random), 0, 1) : point(1, u(random), -u(random), 0);
      if (i >= top) p.normal = {1, 0, 0};
      p.position = turn * p.position;
      p.normal = turn * p.normal;
      points.push_back(p);
    }
    const std::vector<uint32_t> order = tree_order(points, 1);
    // A few mixed nodes per size; halved by place alone all those along the edge are.
    CHECK(mixed(order, 64, kind) <= 1. / 64);
    CHECK(mixed(order, 16, kind) <= 3. / 256);
  }
}

TEST_CASE("one layer is halved along its longest axis, though points of a curved or tilted one differ in height") {
  std::vector<SampledPoint> points;
  std::mt19937 random(5);
  std::uniform_real_distribution<float> u(0, 1);
  for (size_t i = 0; i < 1024; ++i) {
    const float x = u(random);
    points.push_back(point(x, 0.5f * u(random), x < 0.3f ? 0.f : 0.05f, 1));  // a step, not a layer over another
  }
  const std::vector<uint32_t> order = tree_order(points, 1);
  float left = -INFINITY, right = INFINITY;
  for (size_t i = 0; i < 512; ++i) left = std::max(left, points[order[i]].position.x);
  for (size_t i = 512; i < 1024; ++i) right = std::min(right, points[order[i]].position.x);
  CHECK(left <= right);
}

TEST_CASE("a median within a layer that lies across the longest axis parts it along itself, and no two nodes overlap") {
  // Three layers of 2 m, 1 m apart: some nodes hold all of one and a half of another. Two such halves over one place,
  // which split a layer's points at random, each drawn with its own area, left a tenth of it open.
  // 1 km from the origin, where floats are 0.06 mm apart, the same.
  constexpr size_t leaves = 64;
  float away = 0;
  SUBCASE("at the origin") {}
  SUBCASE("far away") { away = 1000; }
  std::mt19937 random(7);
  std::uniform_real_distribution<float> u(-1, 1);
  std::vector<SampledPoint> points;
  for (size_t i = 0; i < 8192; ++i)
    points.push_back(point(away + u(random), away + u(random), away + static_cast<float>(i % 3), 1));
  const std::vector<uint32_t> order = tree_order(points, 1);
  double covered = 0;
  for (size_t i = 0; i < order.size(); i += leaves)
    for (int layer = 0; layer < 3; ++layer) {
      glm::vec2 low(INFINITY), high(-INFINITY);
      for (size_t k = i; k < i + leaves; ++k) {
        const glm::vec3& p = points[order[k]].position;
        if (static_cast<int>(p.z - away) != layer) continue;
        low = glm::min(low, glm::vec2(p)), high = glm::max(high, glm::vec2(p));
      }
      if (high.x > low.x) covered += static_cast<double>((high.x - low.x) * (high.y - low.y));
    }
  CHECK(covered <= 3 * 4);
}
