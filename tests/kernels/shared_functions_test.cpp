// SPDX-License-Identifier: Apache-2.0
// Functions of kernels/lucarium/shared that C++ and OpenCL C compile from one source give the same bits in both.
#include <doctest/doctest.h>

#include <cstring>

#include "kernel_fixture.h"
#include "lucarium/shared/hash.h"
#include "lucarium/shared/radical_inverse.h"
#include "lucarium/shared/sobol_points.h"
#include "lucarium/shared/triangle_map.h"
#include "tolerance.h"

using namespace lucarium;

TEST_CASE("host and device compute the same hashes, Sobol and Halton points, and triangle weights") {
  std::vector<uint> words = {0u, 1u, 2u, 3u, 15u, 16u, 0xffffu, 0x10000u, 0x7fffffffu, 0x80000000u, 0xffffffffu};
  for (uint i = 0; i < 4096; ++i) words.push_back(i);
  for (uint i = 0; i < 4096; ++i) words.push_back(i * 2654435761u);
  const uint count = static_cast<uint>(words.size());
  const auto input = test::test_buffer(words);
  const auto results = test::test_buffer<uint4>(4 * words.size());
  const auto weights = test::test_buffer<float4>(words.size());
  test::run_kernel(test::kernel_program("shared_functions"), "call_shared_functions", count, 1, [&](PassBuilder& pass) {
    pass.arg("words", input).arg("count", count).arg("results", results).arg("weights", weights);
  });
  const std::vector<uint4> got = results.download();
  const std::vector<float4> got_weights = weights.download();
  size_t different = 0;
  for (uint i = 0; i < count; ++i) {
    const uint a = words[i], b = hash_uint(a);
    const uint4 expected[4] = {{b, hash_uint2(a, b), hash_uint3(a, b, i), reverse_bits(a)},
                               hash_uint4({a, b, i, 7u}),
                               owen_scramble_reversed(sobol_reversed(a), {b, a, i, 3u}),
                               reverse_bits4(sobol_reversed(a))};
    const float2 w = sample_triangle({uint_to_unit(a), uint_to_unit(b)});
    const float4 expected_weights(w.x, w.y, uint_to_unit(a), radical_inverse(a, 3u));
    different += std::memcmp(expected, &got[4 * size_t{i}], sizeof expected) != 0;
    different += std::memcmp(&expected_weights, &got_weights[i], sizeof expected_weights) != 0;
  }
  CHECK(different == 0);
  // Known answers, so that both are not wrong alike: the first Sobol points, and PCG of 0.
  CHECK(reverse_bits4(sobol_reversed(1)).x == 0x80000000u);
  CHECK(reverse_bits4(sobol_reversed(2)).x == 0x40000000u);
  CHECK(reverse_bits4(sobol_reversed(2)).y == 0xc0000000u);
  CHECK(hash_uint(0u) == 129708002u);
  CHECK(radical_inverse(6u, 2u) == 0.375f);
  CHECK(radical_inverse(5u, 3u) == test::relative(7.0 / 9, 1e-7));
}
