// SPDX-License-Identifier: Apache-2.0
// kernels/lucarium/packing.clh: what packing loses is what the formats say.
#include <doctest/doctest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <glm/glm.hpp>
#include <limits>
#include <random>

#include "kernel_fixture.h"
#include "tolerance.h"

using namespace lucarium;

namespace {

const Program& packing_program() {
  static const Program instance = test::kernel_program("packing");
  return instance;
}

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

std::vector<float4> round_trip(const std::string& kernel, const std::vector<float4>& in, uint bits = 0) {
  const auto input = test::test_buffer(in), output = test::test_buffer<float4>(in.size());
  const auto count = static_cast<uint>(in.size());
  test::run_kernel(packing_program(), kernel, count, 1, [&](PassBuilder& pass) {
    pass.arg("in", input).arg("count", count).arg("out", output);
    if (bits) pass.arg("bits", bits);
  });
  return output.download();
}

}  // namespace

TEST_CASE("packed directions are as precise as their grid, and keep the axes") {
  std::mt19937 random(11);
  std::vector<float4> in;
  for (int i = 0; i < 1 << 15; ++i) in.push_back(float4(unit_vector(random), 0));
  const glm::vec3 axes[] = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  for (const glm::vec3& axis : axes) in.push_back(float4(axis, 0));
  for (const uint bits : {32u, 20u}) {
    CAPTURE(bits);
    const std::vector<float4> out = round_trip("round_trip_directions", in, bits);
    double worst = 0;
    for (size_t i = 0; i < in.size(); ++i) worst = std::max(worst, angle(in[i].xyz(), out[i].xyz()));
    const double bound = octahedral_error(bits == 32 ? 65534 : 1022);
    CHECK(worst < bound);
    CHECK(worst > 0.4 * bound);
    for (size_t i = in.size() - 6; i < in.size(); ++i) CHECK(glm::distance(in[i].xyz(), out[i].xyz()) < 2e-7f);
  }
}

TEST_CASE("RGB9E5 rounds to the nearest mantissa, keeps what it can hold, and clamps the rest") {
  std::mt19937 random(3);
  std::uniform_real_distribution<float> uniform;
  std::vector<float4> in;
  for (int i = 0; i < 1 << 15; ++i) {
    const float scale = std::exp2(-14.f + 29.9f * uniform(random));
    in.push_back(float4(scale * glm::vec3(uniform(random), uniform(random), uniform(random)), 0));
  }
  std::vector<float4> out = round_trip("round_trip_colors", in);
  size_t off = 0, moved = 0;
  for (size_t i = 0; i < in.size(); ++i) {
    const float largest = std::max({in[i].x, in[i].y, in[i].z});
    // The largest component has a mantissa of 256 to 511.
    float step = std::exp2(std::max(std::floor(std::log2(largest)), -16.f) - 8);
    if (std::rint(largest / step) > 511) step *= 2;
    for (int c = 0; c < 3; ++c) off += std::abs((&in[i].x)[c] - (&out[i].x)[c]) > 0.5f * step;
    out[i].w = 0;
  }
  CHECK(off == 0);
  const std::vector<float4> again = round_trip("round_trip_colors", out);
  for (size_t i = 0; i < in.size(); ++i) moved += again[i].xyz() != out[i].xyz();
  CHECK(moved == 0);

  const float nan = std::numeric_limits<float>::quiet_NaN(), infinity = std::numeric_limits<float>::infinity();
  const std::vector<float4> ends = {{0, 0, 0, 0},       {-1, 1, nan, 0},      {infinity, 1e9f, 65408, 0},
                                    {1, 0.5f, 2, 0},    {65408, 128, 127, 0}, {0x1p-24f, 0x1p-25f, 0x1p-26f, 0},
                                    {1023.5f, 0, 0, 0}, {0x1p-16f, 0, 0, 0}};
  const std::vector<float4> got = round_trip("round_trip_colors", ends);
  const glm::vec3 expected[] = {{0, 0, 0},         {0, 1, 0},        {65408, 65408, 65408}, {1, 0.5f, 2},
                                {65408, 128, 128}, {0x1p-24f, 0, 0}, {1024, 0, 0},          {0x1p-16f, 0, 0}};
  for (size_t i = 0; i < ends.size(); ++i) {
    CAPTURE(i);
    CHECK(got[i].xyz() == expected[i]);
  }
  CHECK(std::bit_cast<uint32_t>(got[0].w) == 0u);
}

TEST_CASE("halfs are rounded up, by less than a step") {
  std::vector<float> in = {0, 1, 65504, 0x1p-24f, 0x1p-25f, 1.0001f, 2049, 3.14159265f};
  std::mt19937 random(5);
  std::uniform_real_distribution<float> exponent(-20, 15.9f);
  for (int i = 0; i < 4096; ++i) in.push_back(std::exp2(exponent(random)));
  const auto input = test::test_buffer(in), output = test::test_buffer<float>(in.size());
  const auto of_eight = test::test_buffer<float>(in.size());
  const auto count = static_cast<uint>(in.size());
  test::run_kernel(packing_program(), "round_up", count, 1, [&](PassBuilder& pass) {
    pass.arg("in", input).arg("count", count).arg("out", output).arg("of_eight", of_eight);
  });
  const std::vector<float> out = output.download();
  CHECK(of_eight.download() == out);
  size_t below = 0, far = 0;
  for (size_t i = 0; i < in.size(); ++i) {
    below += out[i] < in[i];
    far += out[i] - in[i] >= std::max(in[i] / 1024, 0x1p-24f);
  }
  CHECK(below == 0);
  CHECK(far == 0);
  for (size_t i = 0; i < 4; ++i) CHECK(out[i] == in[i]);
}
