// SPDX-License-Identifier: Apache-2.0
// kernels/lucarium/bsdf.clh: sampled directions follow pdf_bsdf, whose integral is the share of samples that leave the
// surface.
#include <doctest/doctest.h>

#include <cmath>

#include "bsdf_scene.h"
#include "chi2.h"
#include "test_support.h"
#include "tolerance.h"

using namespace lucarium;
using namespace lucarium::test;

namespace {

std::vector<NamedMaterial> make_materials() {
  std::vector<NamedMaterial> list = {
      {"Lambert", dielectric(0.8f, 0.5f, 1.f)},
      {"metal .05", metal(0.9f, 0.05f)},
      {"metal .2", metal(0.9f, 0.2f)},
      {"metal .5", metal(0.9f, 0.5f)},
      {"metal 1", metal(0.9f, 1.f)},
      {"dielectric .05", dielectric(0.5f, 0.05f)},
      {"dielectric .3", dielectric(0.5f, 0.3f)},
      {"dielectric 1", dielectric(0.5f, 1.f)},
      {"polished dielectric", dielectric(0.5f, 0.f)},
      {"thin .1", glass(0.9f, 0.1f, 1.f, false)},
      {"thin half .5", glass(0.9f, 0.5f, 0.5f, false)},
      {"volume .1", glass(0.9f, 0.1f, 1.f, true)},
      {"volume half .4", glass(0.9f, 0.4f, 0.5f, true)},
      {"volume 1", glass(0.9f, 1.f, 1.f, true)},
      {"bumped dielectric .3", dielectric(0.5f, 0.3f), glm::vec3(0.3f, -0.2f, 1)},
      {"bumped volume .3", glass(0.5f, 0.3f, 1.f, true), glm::vec3(0.3f, -0.2f, 1)},
  };
  if (full_run()) {
    for (const float r : {0.1f, 0.3f, 0.7f}) list.push_back({"metal " + std::to_string(r), metal(0.9f, r)});
    for (const float r : {0.1f, 0.2f, 0.5f, 0.7f}) {
      list.push_back({"dielectric " + std::to_string(r), dielectric(0.5f, r)});
      list.push_back({"thin " + std::to_string(r), glass(0.9f, r, 0.7f, false)});
      list.push_back({"volume " + std::to_string(r), glass(0.9f, r, 0.7f, true)});
    }
  }
  return list;
}

const std::vector<NamedMaterial>& materials() {
  static const std::vector<NamedMaterial> list = make_materials();
  return list;
}

std::vector<glm::vec3> views(const NamedMaterial& material) {
  std::vector<glm::vec3> list = {direction_at(0.95, 0.1), direction_at(0.5, 0.7)};
  if (full_run()) {
    list.push_back(direction_at(1, 0));
    list.push_back(direction_at(0.75, 0.35));
    list.push_back(direction_at(0.1, 0.9));
  }
  if (material.material.transmission > 0) {  // from behind: for volumes inside, below and above the critical angle
    list.push_back(direction_at(-0.9, 0.3));
    list.push_back(direction_at(-0.4, 0.6));
  }
  return list;
}

int cell_of(const float4& d, int columns, int rows) {
  const double turns = std::atan2(double(d.y), double(d.x)) / (2 * 3.14159265358979323846);
  int i = std::clamp(static_cast<int>((1 - double(d.z)) * 0.5 * columns), 0, columns - 1);
  // (1 - z) rounds; the horizon is an edge of the grid that no direction crosses.
  i = d.z > 0 ? std::min(i, columns / 2 - 1) : std::max(i, columns / 2);
  const int j = std::clamp(static_cast<int>((turns < 0 ? turns + 1 : turns) * rows), 0, rows - 1);
  return i * rows + j;
}

}  // namespace

TEST_CASE("sampled directions follow the density of the mixture of lobes") {
  const BsdfProbe probe(materials());
  const uint n = full_run() ? 1000000 : 100000;
  const int columns = full_run() ? 102 : 40, rows = full_run() ? 202 : 80;
  int tests = 0;
  for (const NamedMaterial& m : materials()) tests += static_cast<int>(views(m).size());
  for (size_t m = 0; m < materials().size(); ++m) {
    for (const glm::vec3& view : views(materials()[m])) {
      CAPTURE(materials()[m].name);
      CAPTURE(view.x);
      CAPTURE(view.z);
      const auto triangle = static_cast<uint>(m);
      const auto masses = test_buffer<float>(columns * rows);
      probe.run("integrate_density", columns * rows, 1, [&](PassBuilder& pass) {
        pass.arg("triangle", triangle).arg("view", float4(view, 0.f));
        pass.arg("columns", static_cast<uint>(columns)).arg("rows", static_cast<uint>(rows)).arg("masses", masses);
      });
      const auto samples = probe.sample(triangle, view, n, 1 + triangle);

      std::vector<uint64_t> observed(columns * rows);
      uint lost = 0;  // ended the path or ideal
      for (uint i = 0; i < n; ++i) {
        if (samples.directions[i].w > 0 && (static_cast<int>(samples.weights[i].w) & 1) == 0) {
          ++observed[cell_of(samples.directions[i], columns, rows)];
        } else {
          ++lost;
        }
      }
      double total = 0;
      std::vector<double> expected;
      for (const float mass : masses.download()) total += mass, expected.push_back(mass);
      // What the density lacks to 1 is the share of lost samples; 3e-4 is the quadrature's tolerance.
      CHECK(total > 0.04);
      CHECK(total < 1 + 3e-4);
      const double expected_loss = std::max(0.0, 1 - total);
      CHECK(std::abs(lost / double(n) - expected_loss) < 5 * std::sqrt(expected_loss / n) + 3e-4);
      for (double& e : expected) e *= (n - lost) / total;
      const Chi2Result result = chi2_test(observed, expected);
      CHECK(result.stray == 0);
      CHECK(result.p >= sidak(0.01, tests));
    }
  }
}

TEST_CASE("every sample's density is the one that pdf_bsdf gives for its direction") {
  const BsdfProbe probe(materials());
  for (const uint m : {2u, 6u, 10u, 12u}) {
    const auto samples = probe.sample(m, direction_at(0.6, 0.2), 64, 3);
    for (uint i = 0; i < 64; i += 8) {
      const float4 d = samples.directions[i], w = samples.weights[i];
      if (d.w == 0) continue;
      const float4 value = probe.evaluate(m, direction_at(0.6, 0.2), d.xyz());
      CHECK(value.w == test::relative(d.w, 1e-3));
      CHECK(value.y / value.w == test::relative(w.y, 1e-3));
    }
  }
}
