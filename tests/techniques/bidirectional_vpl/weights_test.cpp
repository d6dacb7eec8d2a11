// SPDX-License-Identifier: Apache-2.0
// Weights of random paths: each as its own strategy computes it, by sums along both sides, against the products of
// densities in double precision; they sum to 1.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "device_fixture.h"
#include "lucarium/compute/program/source_library.h"
#include "test_support.h"

const lucarium::EmbeddedSources& test_bidirectional_vpl_kernels();
const lucarium::EmbeddedSources& bidirectional_vpl_kernels();

using namespace lucarium;
using namespace lucarium::test;

namespace {

constexpr int kMaxK = 6, kFloats = 49;

/// As TestPath of weights.cl.
struct RandomPath {
  float forward[7], backward[7], towards_light[7], towards_eye[7], distance[7], ideal[7];
  float light, emission, eye, samples[4];
};
static_assert(sizeof(RandomPath) == kFloats * sizeof(float));

/// `metres`: length of a segment, about.
RandomPath random_path(std::mt19937& random, int k, float metres) {
  std::uniform_real_distribution<float> unit(0.05f, 1), exponent(-2, 2);
  RandomPath path{};
  for (int j = 0; j <= kMaxK; ++j) {
    path.forward[j] = std::exp(exponent(random));
    path.backward[j] = std::exp(exponent(random));
    path.towards_light[j] = unit(random);
    path.towards_eye[j] = unit(random);
    path.distance[j] = metres * std::exp(0.5f * exponent(random));
    path.ideal[j] = j > 0 && j < k && unit(random) < 0.25f ? 1.f : 0.f;
  }
  path.light = std::exp(exponent(random));
  path.emission = std::exp(exponent(random));
  path.eye = std::exp(exponent(random));
  path.samples[0] = path.samples[1] = 1;
  path.samples[2] = std::round(1 + 63 * unit(random));
  path.samples[3] = std::round(1 + 63 * unit(random));
  return path;
}

/// Samples times density of strategy s (Veach and Guibas 1995), 0 where it cannot find the path.
double strategy_density(const RandomPath& p, int k, int s, int light_vertices) {
  const auto squared = [&](int j) { return double{p.distance[j]} * double{p.distance[j]}; };
  const auto found_by_light = [&](int j) { return double{p.forward[j - 1]} * double{p.towards_light[j]} / squared(j); };
  const auto found_by_eye = [&](int j) {
    return j == k ? double{p.eye} : double{p.backward[j + 1]} * double{p.towards_eye[j]} / squared(j + 1);
  };
  const bool splat = s == k && s > 0;
  if (splat ? k < 2 || k > light_vertices : s > std::min(light_vertices, k - 1)) return 0;
  if (s >= 0 && !splat && ((s > 0 && p.ideal[s] > 0) || p.ideal[s + 1] > 0)) return 0;
  double density = s == -1 ? found_by_eye(0) : s == 0 ? double{p.light} : double{p.emission};
  density *= double{p.samples[s == -1 ? 0 : s == 0 ? 1 : splat ? 3 : 2]};
  for (int j = 1; j <= k; ++j) density *= j <= s ? found_by_light(j) : found_by_eye(j);
  return density;
}

Program weights_program(int light_vertices, int beta) {
  SourceLibrary library;
  library.add(bidirectional_vpl_kernels());
  library.add(test_bidirectional_vpl_kernels());
  return Program(
      *test_device(), library,
      {"test_bidirectional_vpl/weights",
       {"test_bidirectional_vpl/weights.cl"},
       {{"LIGHT_VERTICES", std::to_string(light_vertices)}, {"LUCARIUM_PATH_MIS_POWER", std::to_string(beta)}}});
}

}  // namespace

TEST_CASE("weights: sums along both sides are the products of densities, and all weights of a path sum to 1") {
  const size_t count = full_run() ? 100'000 : 4'000;
  for (const int light_vertices : full_run() ? std::vector<int>{1, 2, 3, 4, 5} : std::vector<int>{1, 3}) {
    for (const int beta : {1, 2}) {
      CAPTURE(light_vertices);
      CAPTURE(beta);
      std::mt19937 random(7);
      std::vector<RandomPath> paths;
      std::vector<uint32_t> lengths;
      std::vector<float> values;
      for (size_t i = 0; i < count; ++i) {
        lengths.push_back(1 + static_cast<uint32_t>(i % kMaxK));
        paths.push_back(random_path(random, static_cast<int>(lengths.back()), i % 2 == 0 ? 1.f : 1000.f));
        const auto* first = reinterpret_cast<const float*>(&paths.back());
        values.insert(values.end(), first, first + kFloats);
      }
      const auto device_paths = test_buffer(values);
      const auto device_lengths = test_buffer(lengths);
      const auto device_weights = test_buffer<float>(8 * count);
      run_kernel(weights_program(light_vertices, beta), "weigh_paths", count, 64, [&](PassBuilder& pass) {
        pass.arg("count", static_cast<uint32_t>(count)).arg("paths", device_paths).arg("lengths", device_lengths);
        pass.arg("weights", device_weights);
      });
      const std::vector<float> weights = device_weights.download();
      double worst_weight = 0, worst_sum = 0;
      for (size_t i = 0; i < count; ++i) {
        const int k = static_cast<int>(lengths[i]);
        double all = 0, sum = 0;
        for (int s = -1; s <= k; ++s) all += std::pow(strategy_density(paths[i], k, s, light_vertices), beta);
        for (int s = -1; s <= k; ++s) {
          const double expected = std::pow(strategy_density(paths[i], k, s, light_vertices), beta) / all;
          const auto found = static_cast<double>(weights[8 * i + static_cast<size_t>(s + 1)]);
          worst_weight = std::max(worst_weight, std::abs(found - expected));
          sum += found;
        }
        worst_sum = std::max(worst_sum, std::abs(sum - 1));
      }
      CHECK(worst_weight <= 1e-4);
      CHECK(worst_sum <= 1e-4);
    }
  }
}
