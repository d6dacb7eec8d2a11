// SPDX-License-Identifier: Apache-2.0
// Bodies under constant radiance 1: what they reflect is their albedo. The specular albedos E1 (F = 1), B and the
// cosine averages are those of docs/notation.md's BSDF, computed by quadrature to five digits.
#include "albedo_values.h"
#include "test_render.h"

using namespace lucarium;
using namespace lucarium::test;

namespace {

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

}  // namespace

TEST_CASE("furnace: a convex Lambertian body reflects rho everywhere") {
  ClosedForms table;
  for (const float rho : {0.2f, 0.8f}) {
    Scene scene;
    add_triangles(scene, sphere_triangles({0, 0, 0}, 1, 3, false), add_material(scene, lambert(rho)));
    set_environment(scene, 1);
    PathIntegratorOptions options;  // no limit: a convex body scatters once
    // The inscribed square of the silhouette sees the body only.
    table.add("rho = " + std::to_string(rho),
              estimate(scene, look_orthographic({0, 0, 5}, {0, 0, 0}, 0.65f), options, usual_effort()), rho);
  }
  table.check();
}

TEST_CASE("furnace: a white conductor has the specular albedo E1") {
  ClosedForms table;
  for (const AlbedoRow& row : e1_rows)
    for (int i = 0; i < 6; ++i) {
      SceneMaterial metal;
      metal.roughness = row.roughness;
      table.add("r = " + std::to_string(row.roughness) + ", cos = " + std::to_string(albedo_cosines[i]),
                estimate(plane_in_furnace(metal), tilted(albedo_cosines[i]), direct_only(), usual_effort()),
                row.values[i], albedo_rounding);
    }
  table.check(1e-3);
}

TEST_CASE("furnace: a conductor without colour has the specular albedo B") {
  // F0 = 0: the rows of B alone, which a dielectric shows only beside larger terms.
  ClosedForms table;
  for (const AlbedoRow& row : b_rows)
    for (int i = 0; i < 6; ++i) {
      SceneMaterial metal;
      metal.base_color = glm::vec4(0, 0, 0, 1);
      metal.roughness = row.roughness;
      table.add("r = " + std::to_string(row.roughness) + ", cos = " + std::to_string(albedo_cosines[i]),
                estimate(plane_in_furnace(metal), tilted(albedo_cosines[i]), direct_only(), usual_effort()),
                row.values[i], albedo_rounding);
    }
  table.check(4e-3);
}

TEST_CASE("furnace: E1 at normal incidence and roughness 1 is 1 - ln 2") {
  SceneMaterial metal;
  metal.roughness = 1;
  ClosedForms table;
  table.add("1 - ln 2", estimate(plane_in_furnace(metal), tilted(1), direct_only(), usual_effort()), 1 - std::log(2));
  table.check(1e-3);
}

TEST_CASE("furnace: a dielectric has albedo c (1 - average) + F0 (E1 - B) + B") {
  constexpr double base = 0.8;
  ClosedForms table;
  for (const AlbedoRow& row : b_rows)
    for (int i = 0; i < 6; ++i) {
      SceneMaterial plastic;
      plastic.metallic = 0;
      plastic.roughness = row.roughness;
      plastic.base_color = glm::vec4(static_cast<float>(base));
      // The average has four digits, B five.
      table.add("r = " + std::to_string(row.roughness) + ", cos = " + std::to_string(albedo_cosines[i]),
                estimate(plane_in_furnace(plastic), tilted(albedo_cosines[i]), direct_only(), usual_effort()),
                dielectric_albedo(base, row.roughness, i), 5e-5 * base + 2 * albedo_rounding);
    }
  table.check(1e-3);
}
