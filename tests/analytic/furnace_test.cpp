// SPDX-License-Identifier: Apache-2.0
// Bodies under constant radiance 1: what they reflect is their albedo. The specular albedos E1 (F = 1), B and the
// cosine averages are those of docs/notation.md's BSDF, computed by quadrature to five digits.
#include "closed_form.h"

using namespace lucarium;
using namespace lucarium::test;

namespace {

Effort effort() { return full_run() ? Effort{64, 16, 64} : Effort{32, 16, 16}; }

PathIntegratorOptions direct_only() {
  PathIntegratorOptions options;
  options.path_set.max_bounces = 0;
  return options;
}

Scene plane_in_furnace(const SceneMaterial& material) {
  Scene scene;
  add_horizontal(scene, 0, 0, 0, 4, 4, true, add_material(scene, material));
  set_environment(scene, 1);
  return scene;
}

/// Looks at the origin with the given cosine to +y.
SceneCamera tilted(double cosine) {
  const double sine = std::sqrt(1 - cosine * cosine);
  return look_orthographic({static_cast<float>(sine), static_cast<float>(cosine), 0}, {0, 0, 0}, 1e-3f);
}

constexpr double kCosines[6] = {1, .8, .6, .4, .2, .1};
constexpr double kRoundingOfTables = 1e-5;

struct AlbedoRow {
  float roughness;
  double by_cosine[6];
};
constexpr AlbedoRow kE1[] = {{.1f, {.99990, .99987, .99981, .99962, .99859, .99412}},
                             {.2f, {.99830, .99778, .99664, .99324, .97515, .92899}},
                             {.3f, {.99067, .98768, .98129, .96456, .91403, .88432}},
                             {.5f, {.91581, .89727, .87172, .84427, .84816, .89162}},
                             {.7f, {.69775, .69055, .69455, .72107, .79272, .86191}},
                             {1.f, {.30685, .35126, .41150, .49889, .64165, .76021}}};
constexpr AlbedoRow kB[] = {{.2f, {.00000, .00046, .01113, .07729, .29695, .46966}},
                            {.5f, {.00003, .00151, .01095, .04019, .09826, .13969}},
                            {1.f, {.00003, .00043, .00169, .00508, .01403, .02387}}};
/// Cosine-averaged albedo at F0 = 0.04 of the roughnesses of kB.
constexpr double kAverage[] = {.0812, .0532, .0190};

}  // namespace

TEST_CASE("furnace: a convex Lambertian body reflects rho everywhere") {
  ClosedForms table;
  for (const float rho : {0.2f, 0.8f}) {
    Scene scene;
    add_triangles(scene, sphere_triangles({0, 0, 0}, 1, 3, false), add_material(scene, lambert(rho)));
    set_environment(scene, 1);
    PathIntegratorOptions options;  // no limit: a convex body scatters once
    // The inscribed square of the silhouette sees the body only.
    table.add("rho = " + std::to_string(rho), estimate(scene, look_orthographic({0, 0, 5}, {0, 0, 0}, 0.65f), options, effort()), rho);
  }
  table.check(5e-4);
}

TEST_CASE("furnace: a white conductor has the specular albedo E1") {
  ClosedForms table;
  for (const AlbedoRow& row : kE1)
    for (int i = 0; i < 6; ++i) {
      SceneMaterial metal;
      metal.roughness = row.roughness;
      table.add("r = " + std::to_string(row.roughness) + ", cos = " + std::to_string(kCosines[i]),
                estimate(plane_in_furnace(metal), tilted(kCosines[i]), direct_only(), effort()), row.by_cosine[i],
                kRoundingOfTables);
    }
  table.check(full_run() ? 5e-4 : 1e-3);
}

TEST_CASE("furnace: a conductor without colour has the specular albedo B") {
  // F0 = 0: the rows of B alone, which a dielectric shows only beside larger terms.
  ClosedForms table;
  for (const AlbedoRow& row : kB)
    for (int i = 0; i < 6; ++i) {
      SceneMaterial metal;
      metal.base_color = glm::vec4(0, 0, 0, 1);
      metal.roughness = row.roughness;
      table.add("r = " + std::to_string(row.roughness) + ", cos = " + std::to_string(kCosines[i]),
                estimate(plane_in_furnace(metal), tilted(kCosines[i]), direct_only(), effort()), row.by_cosine[i],
                kRoundingOfTables);
    }
  table.check(full_run() ? 5e-4 : 4e-3);
}

TEST_CASE("furnace: E1 at normal incidence and roughness 1 is 1 - ln 2") {
  SceneMaterial metal;
  metal.roughness = 1;
  ClosedForms table;
  table.add("1 - ln 2", estimate(plane_in_furnace(metal), tilted(1), direct_only(), effort()), 1 - std::log(2));
  table.check(full_run() ? 5e-4 : 1e-3);
}

TEST_CASE("furnace: a dielectric has albedo c (1 - average) + F0 (E1 - B) + B") {
  constexpr double f0 = 0.04, base = 0.8;
  ClosedForms table;
  for (int r = 0; r < 3; ++r)
    for (int i = 0; i < 6; ++i) {
      SceneMaterial plastic;
      plastic.metallic = 0;
      plastic.roughness = kB[r].roughness;
      plastic.base_color = glm::vec4(static_cast<float>(base));
      double e1 = 0;
      for (const AlbedoRow& row : kE1)
        if (row.roughness == kB[r].roughness) e1 = row.by_cosine[i];
      const double exact = base * (1 - kAverage[r]) + f0 * (e1 - kB[r].by_cosine[i]) + kB[r].by_cosine[i];
      // The average has four digits, B five.
      table.add("r = " + std::to_string(kB[r].roughness) + ", cos = " + std::to_string(kCosines[i]),
                estimate(plane_in_furnace(plastic), tilted(kCosines[i]), direct_only(), effort()), exact,
                5e-5 * base + 2 * kRoundingOfTables);
    }
  table.check(full_run() ? 5e-4 : 1e-3);
}
