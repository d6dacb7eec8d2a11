// SPDX-License-Identifier: Apache-2.0
// kernels/lucarium/sobol.clh, random.clh against plain host versions and against what makes them good.
#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <set>

#include "chi2.h"
#include "kernel_fixture.h"
#include "test_support.h"

using namespace lucarium;

namespace {

const Program& sobol_program() {
  static const Program instance = test::kernel_program("sampling");
  return instance;
}

std::vector<float4> sampler_points(uint seed, uint block, uint mode, uint first, uint count) {
  const auto points = test::test_buffer<float4>(count);
  test::run_kernel(sobol_program(), "sampler_points", count, 64, [&](PassBuilder& pass) {
    pass.arg("seed", seed)
        .arg("block", block)
        .arg("mode", mode)
        .arg("first", first)
        .arg("count", count)
        .arg("points", points);
  });
  return points.download();
}

float component(const float4& v, int i) { return i == 0 ? v.x : i == 1 ? v.y : i == 2 ? v.z : v.w; }

uint reversed(uint x) {
  uint y = 0;
  for (int i = 0; i < 32; ++i) y |= ((x >> i) & 1u) << (31 - i);
  return y;
}

/// Bit j of the result is bit j of x flipped by a hash of the bits above it: Owen scrambling by definition; here with
/// the hash that Laine and Karras's multiplications amount to, evaluated bit by bit.
uint owen_scramble(uint x, uint seed) {
  uint y = reversed(x);
  y ^= y * 0x3d20adeau;
  y += seed;
  y *= (seed >> 16) | 1u;
  y ^= y * 0x05526c56u;
  y ^= y * 0x53a22864u;
  return reversed(y);
}

/// Sobol's sequence from primitive polynomials and initial direction numbers (Joe and Kuo 2008, new-joe-kuo-6), by
/// its definition.
uint sobol(uint index, int dimension) {
  struct Polynomial {
    int degree;
    uint coefficients;
    std::array<uint, 3> m;
  };
  static const Polynomial polynomials[] = {{1, 0, {1}}, {2, 1, {1, 3}}, {3, 1, {1, 3, 1}}};
  std::array<uint, 32> v{};
  for (int i = 0; i < 32; ++i) {
    if (dimension == 0) {
      v[i] = 1u << (31 - i);
      continue;
    }
    const Polynomial& p = polynomials[dimension - 1];
    if (i < p.degree) {
      v[i] = p.m[i] << (31 - i);
      continue;
    }
    v[i] = v[i - p.degree] ^ (v[i - p.degree] >> p.degree);
    for (int k = 1; k < p.degree; ++k) {
      if ((p.coefficients >> (p.degree - 1 - k)) & 1u) v[i] ^= v[i - k];
    }
  }
  uint x = 0;
  for (int i = 0; i < 32; ++i) {
    if ((index >> i) & 1u) x ^= v[i];
  }
  return x;
}

uint pcg(uint x) {
  x = x * 747796405u + 2891336453u;
  const uint word = ((x >> ((x >> 28) + 4u)) ^ x) * 277803737u;
  return (word >> 22) ^ word;
}

std::array<uint, 4> pcg4d(std::array<uint, 4> v) {
  for (uint& x : v) x = x * 1664525u + 1013904223u;
  const auto round = [&] {
    v[0] += v[1] * v[3];
    v[1] += v[2] * v[0];
    v[2] += v[0] * v[1];
    v[3] += v[1] * v[2];
  };
  round();
  for (uint& x : v) x ^= x >> 16;
  round();
  return v;
}

float unit(uint x) { return static_cast<float>(x >> 8) * 0x1p-24f; }

}  // namespace

TEST_CASE("sampler blocks are the Owen-scrambled Sobol sequence of the host") {
  for (const auto& [seed, block, first] : {std::tuple{1u, 0u, 0u}, {99u, 5u, 60000u}, {0xdeadbeefu, 3u, 1u << 20}}) {
    const auto points = sampler_points(seed, block, 0, first, 8192);
    const std::array<uint, 4> seeds = pcg4d({seed, block, 0x68bc21ebu, 0x02e5be93u});
    int wrong = 0;
    for (uint i = 0; i < 8192; ++i) {
      const uint index = first + i;
      const uint shuffled =
          (index & 0xffff0000u) | (owen_scramble((index & 0xffffu) << 16, pcg(seeds[0] ^ seeds[3])) >> 16);
      for (int d = 0; d < 4; ++d) wrong += component(points[i], d) != unit(owen_scramble(sobol(shuffled, d), seeds[d]));
    }
    CHECK(wrong == 0);
  }
}

TEST_CASE("every dimension is stratified and x, y form (0, m, 2)-nets") {
  for (uint trial = 0; trial < 6; ++trial) {
    const int m = 4 + static_cast<int>(trial) % 8;
    const uint n = 1u << m;
    // Also an aligned run away from the start.
    const auto points = sampler_points(trial * 77 + 5, trial, 0, trial % 2 ? 3 * n : 0, n);
    for (int d = 0; d < 4; ++d) {
      std::set<uint> strata;
      for (const float4& p : points) strata.insert(static_cast<uint>(component(p, d) * static_cast<float>(n)));
      CHECK(strata.size() == n);
    }
    for (int a = 0; a <= m; ++a) {
      std::set<std::pair<uint, uint>> boxes;
      for (const float4& p : points) {
        boxes.insert({static_cast<uint>(std::ldexp(p.x, a)), static_cast<uint>(std::ldexp(p.y, m - a))});
      }
      CHECK(boxes.size() == n);
    }
  }
}

TEST_CASE("blocks, samples and replicates of a pixel are independent over pixels") {
  // Scrambling makes every point uniform and points of different blocks independent, over the choice of the seed; so
  // count over pixels. (Over the samples of one pixel the counts of two scrambled nets are no multinomial.)
  struct Choice {
    uint block, index, replicate;
  };
  const uint n = test::full_run() ? 1u << 20 : 1u << 16;
  const auto points = [&](const Choice& c) {
    const auto buffer = test::test_buffer<float4>(n);
    test::run_kernel(sobol_program(), "pixel_points", n, 64, [&](PassBuilder& pass) {
      pass.arg("block", c.block)
          .arg("index", c.index)
          .arg("replicate", c.replicate)
          .arg("count", n)
          .arg("points", buffer);
    });
    return buffer.download();
  };
  const int cells = 16, tests = 5 * 16;
  const Choice first{1, 0, 0};
  const auto a = points(first);
  for (const Choice& other :
       {Choice{2, 0, 0}, Choice{3, 0, 0}, Choice{2, 1, 0}, Choice{1, 0, 1}, Choice{4, 77777, 0}}) {
    const auto b = points(other);
    for (int d = 0; d < 4; ++d) {
      for (int e = 0; e < 4; ++e) {
        std::vector<uint64_t> histogram(cells * cells);
        for (uint i = 0; i < n; ++i) {
          ++histogram[static_cast<int>(component(a[i], d) * cells) * cells +
                      static_cast<int>(component(b[i], e) * cells)];
        }
        const auto result = test::chi2_test(histogram, std::vector<double>(cells * cells, double(n) / (cells * cells)));
        CAPTURE(other.block);
        CAPTURE(other.index);
        CAPTURE(other.replicate);
        CHECK(result.p >= test::sidak(0.01, tests));
      }
    }
  }
}

TEST_CASE("random mode is uniform in four dimensions") {
  const uint n = test::full_run() ? 1u << 20 : 1u << 16;
  const auto points = sampler_points(17, 3, 1, 0, n);
  std::vector<uint64_t> histogram(8 * 8 * 8 * 8);
  for (const float4& p : points) {
    ++histogram[((static_cast<int>(p.x * 8) * 8 + static_cast<int>(p.y * 8)) * 8 + static_cast<int>(p.z * 8)) * 8 +
                static_cast<int>(p.w * 8)];
  }
  CHECK(test::chi2_test(histogram, std::vector<double>(4096, n / 4096.0)).p >= 0.01);
}

TEST_CASE("a path's decisions come from their own blocks") {
  const auto points = test::test_buffer<float4>(3);
  const auto seeds = test::test_buffer<uint>(1);
  const uint vertex = 2;
  test::run_kernel(sobol_program(), "path_dimensions", 1, 1,
                   [&](PassBuilder& pass) { pass.arg("vertex", vertex).arg("points", points).arg("seeds", seeds); });
  const uint seed = seeds.download()[0];
  CHECK(seed == pcg(3u + pcg(1u + pcg(7u))));
  const auto got = points.download();
  const uint blocks[] = {0, 1 + 2 * vertex, 2 + 2 * vertex};
  for (int i = 0; i < 3; ++i) {
    const float4 expected = sampler_points(seed, blocks[i], 0, 11, 1)[0];
    for (int d = 0; d < 4; ++d) CHECK(component(got[i], d) == component(expected, d));
  }
}

TEST_CASE("film positions of eight pixels at once are those of each alone") {
  const auto together = test::test_buffer<float2>(8), alone = test::test_buffer<float2>(8);
  for (const uint index : {0u, 1u, 77u, 65535u, 65536u, 0x12345678u, 0xffffffffu})
    for (const uint first : {0u, 8u, 123456u}) {
      test::run_kernel(sobol_program(), "film_points", 1, 1, [&](PassBuilder& pass) {
        pass.arg("index", index).arg("first", first).arg("together", together).arg("alone", alone);
      });
      const auto got = together.download(), expected = alone.download();
      CAPTURE(index);
      CAPTURE(first);
      for (int k = 0; k < 8; ++k) CHECK((got[k].x == expected[k].x && got[k].y == expected[k].y));
    }
}

TEST_CASE("blocks of eight samplers at once are those of each alone, and so are directions by them") {
  const auto together = test::test_buffer<float4>(8), alone = test::test_buffer<float4>(8);
  const auto directions_together = test::test_buffer<float4>(8), directions_alone = test::test_buffer<float4>(8);
  for (const uint mode : {0u, 1u})
    for (const uint index : {0u, 5u, 65535u, 65536u, 0x12345678u, 0xffff0000u})
      for (const uint block : {0u, 1u, 2u, 37u}) {
        test::run_kernel(sobol_program(), "blocks_of_eight", 1, 1, [&](PassBuilder& pass) {
          pass.arg("seed", 99u)
              .arg("index", index)
              .arg("block", block)
              .arg("mode", mode)
              .arg("together", together)
              .arg("alone", alone)
              .arg("directions_together", directions_together)
              .arg("directions_alone", directions_alone);
        });
        const auto got = together.download(), expected = alone.download();
        const auto got_direction = directions_together.download(), direction = directions_alone.download();
        CAPTURE(mode);
        CAPTURE(index);
        CAPTURE(block);
        for (int k = 0; k < 8; ++k) {
          for (int d = 0; d < 4; ++d) CHECK(component(got[k], d) == component(expected[k], d));
          // Compilers are free to join products and sums.
          CHECK(std::abs(got_direction[k].x - direction[k].x) < 1e-6f);
          CHECK(std::abs(got_direction[k].y - direction[k].y) < 1e-6f);
          CHECK(std::abs(got_direction[k].z * got_direction[k].z - direction[k].z * direction[k].z) < 1e-6f);
        }
      }
}

TEST_CASE("blocks of a run of eight sample numbers at once are those of each alone") {
  const auto together = test::test_buffer<float4>(8), alone = test::test_buffer<float4>(8);
  for (const uint index : {0u, 8u, 65528u, 65536u, 0x30008u, 0x12345678u, 0xffff0000u})
    for (const uint block : {0u, 1u, 37u}) {
      test::run_kernel(sobol_program(), "blocks_of_run", 1, 1, [&](PassBuilder& pass) {
        pass.arg("seed", 99u).arg("index", index).arg("block", block).arg("together", together).arg("alone", alone);
      });
      const auto got = together.download(), expected = alone.download();
      CAPTURE(index);
      CAPTURE(block);
      for (int k = 0; k < 8; ++k)
        for (int d = 0; d < 4; ++d) CHECK(component(got[k], d) == component(expected[k], d));
    }
}

TEST_CASE("Halton points are radical inverses; scrambled ones keep the strata") {
  const int primes[] = {2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37, 41, 43, 47, 53};
  for (uint d = 0; d < 16; ++d) {
    const int base = primes[d];
    uint n = static_cast<uint>(base);
    while (n * static_cast<uint>(base) < 4000) n *= static_cast<uint>(base);
    const auto buffer = test::test_buffer<float2>(n), other = test::test_buffer<float2>(n);
    for (const auto& [seed, target] : {std::pair{5u, &buffer}, {6u, &other}}) {
      test::run_kernel(sobol_program(), "halton_points", n, 64, [&](PassBuilder& pass) {
        pass.arg("dimension", d).arg("seed", seed).arg("count", n).arg("points", *target);
      });
    }
    const auto points = buffer.download(), others = other.download();
    std::set<uint> strata;
    double largest = 0;
    int same = 0;
    for (uint i = 0; i < n; ++i) {
      double inverse = 0, scale = 1.0 / base;
      for (uint k = i; k; k /= static_cast<uint>(base), scale /= base) inverse += (k % static_cast<uint>(base)) * scale;
      largest = std::max(largest, std::abs(inverse - points[i].x));
      strata.insert(static_cast<uint>(points[i].y * static_cast<float>(n)));
      same += points[i].y == others[i].y;
    }
    CAPTURE(base);
    CHECK(largest < 1e-6);
    CHECK(strata.size() == n);
    CHECK(same < static_cast<int>(n) / 4);
  }
}
