// SPDX-License-Identifier: Apache-2.0
#include <doctest/doctest.h>

#include <random>
#include <set>
#include <utility>

#include "lucarium/compute/schedule/dependency_graph.h"

using namespace lucarium;

namespace {

using Steps = std::vector<std::vector<MemoryAccess>>;
constexpr bool kRead = false, kWrite = true;

std::set<std::pair<int, int>> pairs(const std::vector<Dependency>& dependencies) {
  std::set<std::pair<int, int>> result;
  for (const Dependency& dependency : dependencies) result.insert({dependency.from, dependency.to});
  return result;
}

DependencyGraph graph_of(const Steps& steps) {
  return DependencyGraph(static_cast<int>(steps.size()), derive_dependencies(steps));
}

bool conflict(const std::vector<MemoryAccess>& a, const std::vector<MemoryAccess>& b) {
  for (const MemoryAccess& x : a) {
    for (const MemoryAccess& y : b) {
      if (x.memory == y.memory && x.begin < y.end && y.begin < x.end && (x.writes || y.writes)) return true;
    }
  }
  return false;
}

Steps random_steps(std::mt19937& random, int count) {
  Steps steps(static_cast<size_t>(count));
  for (auto& step : steps) {
    const size_t accesses = random() % 4;
    for (size_t i = 0; i < accesses; ++i) {
      const size_t begin = random() % 12, length = 1 + random() % 6;
      step.push_back({static_cast<int>(random() % 3), begin, begin + length, random() % 2 == 0});
    }
  }
  return steps;
}

}  // namespace

TEST_CASE("the three hazards are found and distinguished") {
  const Steps steps = {{{0, 0, 8, kWrite}}, {{0, 0, 8, kRead}}, {{0, 0, 8, kWrite}}, {{0, 0, 8, kWrite}}};
  const std::vector<Dependency> found = derive_dependencies(steps);
  REQUIRE(found.size() == 4);
  CHECK(found[0].from == 0);
  CHECK(found[0].to == 1);
  CHECK(found[0].hazard == Hazard::read_after_write);
  CHECK(pairs(found) == std::set<std::pair<int, int>>{{0, 1}, {0, 2}, {1, 2}, {2, 3}});
  for (const Dependency& dependency : found) {
    if (dependency.from == 1) CHECK(dependency.hazard == Hazard::write_after_read);
    if (dependency.from == 2) CHECK(dependency.hazard == Hazard::write_after_write);
  }
  CHECK(pairs(graph_of(steps).dependencies()) == std::set<std::pair<int, int>>{{0, 1}, {1, 2}, {2, 3}});
}

TEST_CASE("reads do not order each other and disjoint ranges do not meet") {
  const Steps steps = {
      {{0, 0, 16, kWrite}}, {{0, 0, 8, kRead}}, {{0, 8, 16, kRead}}, {{0, 0, 8, kWrite}}, {{0, 8, 16, kRead}}};
  const DependencyGraph graph = graph_of(steps);
  CHECK(pairs(graph.dependencies()) == std::set<std::pair<int, int>>{{0, 1}, {0, 2}, {1, 3}, {0, 4}});
  CHECK(graph.independent(1, 2));
  CHECK(graph.independent(3, 4));
  CHECK(graph.depends(3, 0));
  CHECK_FALSE(graph.depends(0, 3));
}

TEST_CASE("on random steps exactly the conflicting pairs are ordered, and no edge is redundant") {
  std::mt19937 random(1);
  for (int trial = 0; trial < 300; ++trial) {
    const Steps steps = random_steps(random, 2 + static_cast<int>(random() % 70));
    const DependencyGraph graph = graph_of(steps);
    const int count = graph.step_count();
    // Reference: transitive closure over all conflicting pairs.
    std::vector<std::vector<bool>> before(static_cast<size_t>(count),
                                          std::vector<bool>(static_cast<size_t>(count), false));
    for (size_t b = 0; b < steps.size(); ++b) {
      for (size_t a = 0; a < b; ++a) {
        if (!conflict(steps[a], steps[b])) continue;
        before[b][a] = true;
        for (size_t c = 0; c < a; ++c) before[b][c] = before[b][c] || before[a][c];
      }
    }
    for (int b = 0; b < count; ++b) {
      for (int a = 0; a < b; ++a)
        REQUIRE(graph.depends(b, a) == before[static_cast<size_t>(b)][static_cast<size_t>(a)]);
    }
    for (const Dependency& edge : graph.dependencies()) {
      for (int middle = edge.from + 1; middle < edge.to; ++middle) {
        REQUIRE_FALSE((graph.depends(middle, edge.from) && graph.depends(edge.to, middle)));
      }
    }
  }
}
