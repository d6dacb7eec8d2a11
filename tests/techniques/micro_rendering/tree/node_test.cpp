// SPDX-License-Identifier: Apache-2.0
// Packed nodes: what a node loses by rounding it must gain in radius and cone, and no more than the format's steps.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <glm/glm.hpp>
#include <random>

#include "lucarium/shared/dialect.h"
#include "micro_fixture.h"
#include "micro_rendering/shared/micro_types.h"

using namespace lucarium;

namespace {

glm::dvec3 unit_vector(std::mt19937& random) {
  std::normal_distribution<double> normal;
  return glm::normalize(glm::dvec3(normal(random), normal(random), normal(random)));
}

double angle(const glm::dvec3& a, const glm::dvec3& b) {
  return 2 * std::atan2(glm::length(a - b), glm::length(a + b));
}

/// Largest angle [rad] by which rounding the octahedron to `steps` per coordinate turns a direction: half a cell's
/// diagonal, times 3, which is how much the centre of a face (1/√3 from the middle, tilted by √3) stretches lengths
/// into angles.
double octahedral_error(double steps) { return 3 * std::sqrt(0.5) * 2 / steps; }

struct Node {
  float4 sphere, cone, flags;  ///< centre and radius, axis and half angle, x flags
};
static_assert(sizeof(Node) == 48);

std::vector<Node> random_nodes(size_t count) {
  std::mt19937 random(7);
  std::uniform_real_distribution<float> uniform;
  std::vector<Node> nodes(count);
  for (size_t i = 0; i < count; ++i) {
    // Radii of all magnitudes, down to 0 and up to what contains the whole grid; cones from points to everything.
    const float radius = i % 16 == 0 ? 0.f : std::exp2(-14.f + 31.f * uniform(random));
    const float cone = i % 8 == 0 ? 0.f : 3.14159265f * uniform(random) * uniform(random);
    glm::vec3 normal = unit_vector(random);
    if (i % 32 == 1) normal = glm::vec3(0, 0, -1);
    nodes[i].sphere = float4(65535.f * uniform(random), 65535.f * uniform(random), 65535.f * uniform(random), radius);
    nodes[i].cone = float4(normal, cone);
    nodes[i].flags = float4(static_cast<float>(i % 16), 0, 0, 0);
  }
  return nodes;
}

std::vector<Node> packed_and_unpacked(const std::vector<Node>& nodes) {
  std::vector<float4> in(3 * nodes.size());
  std::memcpy(static_cast<void*>(in.data()), nodes.data(), nodes.size() * sizeof(Node));
  const auto input = test::test_buffer(in), output = test::test_buffer<float4>(in.size());
  const uint32_t count = static_cast<uint32_t>(nodes.size());
  test::run_kernel(test::micro_program("test_micro_rendering/tree/node.cl"), "round_trip_nodes", count, 64,
                   [&](PassBuilder& pass) { pass.arg("in", input).arg("count", count).arg("out", output); });
  const std::vector<float4> out = output.download();
  std::vector<Node> result(nodes.size());
  std::memcpy(static_cast<void*>(result.data()), out.data(), nodes.size() * sizeof(Node));
  return result;
}

}  // namespace

TEST_CASE("a packed sphere contains the given one and is hardly larger") {
  const std::vector<Node> nodes = random_nodes(1 << 16), packed = packed_and_unpacked(nodes);
  size_t outside = 0, loose = 0;
  for (size_t i = 0; i < nodes.size(); ++i) {
    const double moved = glm::distance(glm::dvec3(nodes[i].sphere.xyz()), glm::dvec3(packed[i].sphere.xyz()));
    const double needed = moved + nodes[i].sphere.w;
    // The largest radius that a node can have contains the whole grid from any centre, and is finite.
    outside += packed[i].sphere.w < std::min(needed, static_cast<double>(MICRO_LARGEST_RADIUS));
    loose += !std::isfinite(packed[i].sphere.w);
    // One step of the half, and half a diagonal of the grid.
    loose += packed[i].sphere.w > (nodes[i].sphere.w + 0.8661) * (1 + 1. / 1023) || moved > 0.8661;
  }
  CHECK(outside == 0);
  CHECK(loose == 0);
}

TEST_CASE("a packed cone contains the given one and is hardly wider") {
  const std::vector<Node> nodes = random_nodes(1 << 16), packed = packed_and_unpacked(nodes);
  const double step = 3.14159265358979 / 255;
  size_t outside = 0, loose = 0;
  double max_turned = 0;
  for (size_t i = 0; i < nodes.size(); ++i) {
    const double turned = angle(nodes[i].cone.xyz(), packed[i].cone.xyz());
    max_turned = std::max(max_turned, turned);
    const double needed = std::min(turned + nodes[i].cone.w, 3.14159265);
    outside += packed[i].cone.w < needed * (1 - 1e-6);
    loose += packed[i].cone.w > needed + 1.01 * step;
  }
  CHECK(outside == 0);
  CHECK(loose == 0);
  CHECK(max_turned < octahedral_error(1022));
}

TEST_CASE("axes and flags are kept") {
  const std::vector<Node> nodes = random_nodes(4096), packed = packed_and_unpacked(nodes);
  for (size_t i = 0; i < nodes.size(); ++i) {
    CHECK(packed[i].flags.x == nodes[i].flags.x);
    if (i % 32 == 1) CHECK(packed[i].cone.z == -1.f);
  }
}
