// SPDX-License-Identifier: Apache-2.0
// Values between the atlas's texel sides, as kernels interpolate them.
#include <cmath>

#include "context.h"
#include "lucarium/scene/builtin/scenes.h"
#include "made_scene.h"
#include "tolerance.h"

using namespace lucarium;
using namespace lucarium::test;

namespace {

/// Smooth over the scene: two waves of a fifth of its extent.
double wave(const glm::dvec3& p, double extent) {
  const double k = 2 * 3.14159265358979 / (0.2 * extent);
  return std::sin(k * (p.x + 0.4 * p.y + 0.3 * p.z)) + std::cos(k * (0.3 * p.x - 0.2 * p.y + p.z));
}

/// What kernels get between the texel sides' values at points of the fronts, or of the backs.
std::vector<float4> interpolate(AtlasContext& context, const std::vector<float4>& values, const Points& p,
                                bool front = true) {
  const auto sides = test_buffer(values), results = test_buffer<float4>(p.points.size());
  run_at(context, "interpolate_atlas", p,
         [&](PassBuilder& pass) { pass.arg("values", sides).arg("front", front ? 1u : 0u).arg("results", results); });
  return results.download();
}

struct InterpolationError {
  double interpolated, nearest;  ///< RMS over the wave's standard deviation
};

InterpolationError interpolation_error(AtlasContext& context) {
  const SurfaceAtlas& atlas = *context.atlas;
  const AtlasGeometry g = read_atlas_geometry(context.scene, context.buffers, false);
  const Bounds bounds = context.scene.bounds();
  const double extent = glm::length(glm::dvec3(bounds.max - bounds.min));
  std::vector<float4> values;
  for (const SurfacePoint& point : atlas.surface_points().download())
    values.emplace_back(float(wave(glm::dvec3(point.position.xyz()), extent)), 0.f, 0.f, 1.f);
  // Points uniform over the surface.
  std::mt19937 random(5);
  std::vector<double> areas;
  for (uint32_t t = 0; t < g.triangles.size(); ++t) areas.push_back(area_of(g, t));
  std::discrete_distribution<uint32_t> pick(areas.begin(), areas.end());
  std::uniform_real_distribution<float> unit(0.f, 1.f);
  Points p;
  for (int i = 0; i < 40000; ++i) {
    p.triangles.push_back(pick(random));
    const float u = unit(random), v = unit(random);
    p.points.emplace_back(u + v > 1 ? 1 - u : u, u + v > 1 ? 1 - v : v);
  }
  const uint32_t count = static_cast<uint32_t>(p.points.size());
  const auto found = interpolate(context, values, p);
  const auto records = atlas.triangles().download();
  const auto table = atlas.table().download();
  double sum = 0, sum2 = 0, error2 = 0, nearest2 = 0;
  for (uint32_t i = 0; i < count; ++i) {
    const double exact = wave(point_on(g, p.triangles[i], p.points[i].x, p.points[i].y), extent);
    const uint32_t texel = table[atlas_cell(records[p.triangles[i]], p.points[i].x, p.points[i].y)];
    CHECK(found[i].w == test::relative(1));
    sum += exact, sum2 += exact * exact;
    error2 += (double(found[i].x) - exact) * (double(found[i].x) - exact);
    nearest2 += (double(values[texel].x) - exact) * (double(values[texel].x) - exact);
  }
  const double variance = sum2 / count - sum / count * (sum / count);
  return {std::sqrt(error2 / count / variance), std::sqrt(nearest2 / count / variance)};
}

}  // namespace

TEST_CASE("interpolation follows a smooth function") {
  for (const char* name : {"cornell", "furnace", "room"}) {
    CAPTURE(name);
    AtlasContext context(make_builtin_scene(name), 20000);
    const InterpolationError error = interpolation_error(context);
    MESSAGE(std::string(name) << ": " << error.interpolated << ", nearest " << error.nearest);
    CHECK(error.interpolated < 0.04);
    CHECK(error.interpolated < 0.5 * error.nearest);
  }
}

TEST_CASE("interpolation does not reach across a slit") {
  // One connected sheet around a slit narrower than a texel; its lips hold 0 and 1.
  for (const float gap : {0.0001f, 0.03f, 0.08f}) {
    CAPTURE(gap);
    Scene scene;
    const int material = add_material(scene, lambert(0.5f));
    const std::vector<glm::vec3> p = {{0, 0, 0},       {0, 0, 2}, {1, 0, 2}, {1, 0, 1},
                                      {1 + gap, 0, 2}, {2, 0, 2}, {2, 0, 0}, {1, 0, 0}};
    std::vector<glm::vec3> corners;
    for (const glm::uvec3& t :
         std::vector<glm::uvec3>{{0, 1, 3}, {1, 2, 3}, {0, 3, 7}, {7, 3, 6}, {3, 5, 6}, {3, 4, 5}})
      corners.insert(corners.end(), {p[t.x], p[t.y], p[t.z]});
    add_triangles(scene, corners, material);
    AtlasContext context(std::move(scene), 400);
    const SurfaceAtlas& atlas = *context.atlas;
    REQUIRE(double(atlas.info().texel_edge) > 0.09);
    std::vector<float4> values;
    for (const SurfacePoint& point : atlas.surface_points().download())
      values.emplace_back(point.position.x < 1 + 0.1f * gap ? 0.f : 1.f, 0.f, 0.f, 0.f);
    const AtlasGeometry g = read_atlas_geometry(context.scene, context.buffers, false);
    const Points points = random_points(g.triangles.size(), 20000);
    const std::vector<float4> found = interpolate(context, values, points);
    uint32_t beside = 0;
    for (size_t i = 0; i < found.size(); ++i) {
      const glm::dvec3 at = point_on(g, points.triangles[i], points.points[i].x, points.points[i].y);
      // Two texels from the slit's end on the lips are apart.
      if (at.z < 1.25 || std::abs(at.x - 1) > 0.2) continue;
      CHECK(std::abs(found[i].x - (at.x < 1 + 0.1 * double(gap) ? 0.f : 1.f)) < 1e-6f);
      ++beside;
    }
    CHECK(beside > 500);
  }
}

TEST_CASE("interpolation of a sheet's back takes nothing from its front, and single-sided ones have none") {
  // Fronts hold 100, backs 1 + x; beside them a single-sided sheet.
  Scene scene;
  SceneMaterial sheet = lambert(0.5f);
  sheet.double_sided = true;
  add_horizontal(scene, 0, 0, 0, 2, 2, true, add_material(scene, sheet));
  add_horizontal(scene, 5, 0, 0, 2, 2, true, add_material(scene, lambert(0.5f)));
  AtlasContext context(std::move(scene), 600);
  const uint32_t k = context.atlas->info().double_sided_count;
  CHECK(k > 100);
  std::vector<float4> values;
  for (const SurfacePoint& point : context.atlas->surface_points().download()) {
    const bool back = values.size() >= k && values.size() < 2 * k;
    values.emplace_back(back ? 1 + point.position.x : 100.f, 0.f, 0.f, 1.f);
  }
  const AtlasGeometry g = read_atlas_geometry(context.scene, context.buffers, false);
  const Points points = random_points(g.triangles.size(), 4000);
  const std::vector<float4> fronts = interpolate(context, values, points),
                            backs = interpolate(context, values, points, false);
  const double edge = double(context.atlas->info().texel_edge);
  for (size_t i = 0; i < points.points.size(); ++i) {
    const glm::dvec3 at = point_on(g, points.triangles[i], points.points[i].x, points.points[i].y);
    CHECK(fronts[i].x == test::relative(100));
    CHECK(std::abs(double(backs[i].x) - (at.x < 2 ? 1 + at.x : 0)) < edge);
    CHECK(backs[i].w == (at.x < 2 ? test::relative(1) : test::within(0, 0)));
  }
}
