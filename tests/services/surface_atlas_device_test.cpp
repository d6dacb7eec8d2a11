// SPDX-License-Identifier: Apache-2.0
// The atlas on the device: kernels find what the host finds, slots know their surface, refits follow.
#include "lucarium/services/surface_atlas.h"

#include <cmath>

#include "../analytic/closed_form.h"
#include "surface_atlas_support.h"

const lucarium::EmbeddedSources& test_services_kernels();

using namespace lucarium;
using namespace lucarium::test;

namespace {

/// A scene with its atlas.
struct AtlasContext {
  AtlasContext(Scene scene_, uint64_t texels)
      : scene(std::move(scene_)), scheduler(atlas_device()), buffers(*atlas_device(), scene) {
    options.texel_count = texels;
    atlas = std::make_unique<SurfaceAtlas>(*atlas_device(), scheduler, scene, buffers, options, "test");
  }
  Scene scene;
  KernelScheduler scheduler;
  SceneBuffers buffers;
  SurfaceAtlasOptions options;
  std::unique_ptr<SurfaceAtlas> atlas;
};

/// Random points of random triangles.
struct Points {
  std::vector<uint32_t> triangles;
  std::vector<float2> points;
};
Points random_points(size_t triangle_count, size_t count) {
  std::mt19937 random(3);
  Points result;
  for (size_t i = 0; i < count; ++i) {
    result.triangles.push_back(static_cast<uint32_t>(random() % triangle_count));
    const RandomPoint p = random_point(random);
    result.points.emplace_back(p.b1, p.b2);
  }
  return result;
}

Program lookup_program() {
  SourceLibrary library;
  library.add(test_services_kernels());
  return Program(*atlas_device(), library, {"test_services/surface_atlas", {"test_services/surface_atlas.cl"}, {}});
}

}  // namespace

TEST_CASE("kernels find the texels that the host finds") {
  Scene scene = make_builtin_scene("cornell");
  scene.materials[0].double_sided = true;
  AtlasContext context(std::move(scene), 20000);
  const SurfaceAtlas& atlas = *context.atlas;
  const uint32_t k = atlas.info().double_sided_count;
  CHECK(k > 0);
  CHECK(2 * k < atlas.info().texel_count);
  const Points p = random_points(atlas.triangles().count(), 20000);
  const uint32_t count = static_cast<uint32_t>(p.points.size());
  Device& device = *atlas_device();
  const TypedBuffer<uint32_t> triangles(device, "test", "triangles", p.triangles);
  const TypedBuffer<float2> points(device, "test", "points", p.points);
  const TypedBuffer<uint32_t> fronts(device, "test", "fronts", count), backs(device, "test", "backs", count);
  const Program program = lookup_program();
  ScheduleRecorder recorder = context.scheduler.record("look up", "test");
  PassBuilder pass = recorder.pass("look up", program, "look_up_atlas");
  atlas.bind(pass, program, "look_up_atlas");
  pass.global(count).local(64).arg("triangles", triangles).arg("points", points).arg("count", count);
  pass.arg("fronts", fronts).arg("backs", backs);
  Schedule schedule = recorder.compile();
  context.scheduler.run(schedule);
  context.scheduler.finish();
  const auto records = atlas.triangles().download();
  const auto table = atlas.table().download();
  const auto front = fronts.download(), back = backs.download();
  uint32_t elsewhere = 0;
  for (uint32_t i = 0; i < count; ++i) {
    const uint32_t expected = table[atlas_cell(records[p.triangles[i]], p.points[i].x, p.points[i].y)];
    REQUIRE(front[i] < atlas.info().texel_count);
    // Fused operations may round a point on a border of cells to the other side.
    elsewhere += front[i] != expected;
    CHECK(back[i] == (front[i] < k ? front[i] + k : LUCARIUM_NONE));
  }
  CHECK(elsewhere < 20);
}

TEST_CASE("slots lie on their triangles and know what the surface does") {
  Scene scene = make_builtin_scene("cornell");
  scene.materials[0].double_sided = true;
  AtlasContext context(std::move(scene), 5000);
  const SurfaceAtlas& atlas = *context.atlas;
  const AtlasGeometry g = read_atlas_geometry(context.scene, context.buffers, false);
  const auto texels = atlas.texels().download();
  const auto points = atlas.surface_points().download();
  const auto materials = atlas.materials().download();
  const uint32_t k = atlas.info().double_sided_count;
  double area = 0;
  for (uint32_t slot = 0; slot < texels.size(); ++slot) {
    area += double(texels[slot].area);
    const uint32_t t = texels[slot].triangle;
    CHECK(points[slot].triangle == t);
    CHECK(glm::length(glm::dvec3(points[slot].position.xyz()) - point_on(g, t, texels[slot].b1, texels[slot].b2)) < 1e-6);
    const bool back = slot >= k && slot < 2 * k;
    const glm::dvec3 n = glm::normalize(glm::cross(corner(g, t, 1) - corner(g, t, 0), corner(g, t, 2) - corner(g, t, 0)));
    CHECK(glm::dot(glm::dvec3(points[slot].normal.xyz()), n) == doctest::Approx(back ? -1 : 1).epsilon(1e-5));
    const SceneMaterial& material = context.scene.materials[context.scene.instances[g.instance[t]].material];
    if (material.emits()) {
      CHECK(materials[slot].emission.x == doctest::Approx(material.emissive_factor.x * material.emissive_strength));
    } else {
      CHECK(materials[slot].emission.x == 0.f);
      CHECK(materials[slot].diffuse.x == doctest::Approx(material.base_color.x).epsilon(1e-4));
    }
  }
  CHECK(area == doctest::Approx(side_area(g)).epsilon(1e-6));
}

namespace {

/// Smooth over the scene: two waves of a fifth of its extent.
double wave(const glm::dvec3& p, double extent) {
  const double k = 2 * 3.14159265358979 / (0.2 * extent);
  return std::sin(k * (p.x + 0.4 * p.y + 0.3 * p.z)) + std::cos(k * (0.3 * p.x - 0.2 * p.y + p.z));
}

struct InterpolationError {
  double interpolated, nearest;  ///< RMS over the wave's standard deviation
};

InterpolationError interpolation_error(AtlasContext& context) {
  const SurfaceAtlas& atlas = *context.atlas;
  Device& device = *atlas_device();
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
  const TypedBuffer<uint32_t> triangles(device, "test", "triangles", p.triangles);
  const TypedBuffer<float2> points(device, "test", "points", p.points);
  const TypedBuffer<float4> slots(device, "test", "values", values), results(device, "test", "results", count);
  const Program program = lookup_program();
  ScheduleRecorder recorder = context.scheduler.record("interpolate", "test");
  PassBuilder pass = recorder.pass("interpolate", program, "interpolate_atlas");
  atlas.bind(pass, program, "interpolate_atlas");
  pass.global(count).local(64).arg("triangles", triangles).arg("points", points).arg("count", count);
  pass.arg("values", slots).arg("front", 1u).arg("results", results);
  Schedule schedule = recorder.compile();
  context.scheduler.run(schedule);
  context.scheduler.finish();
  const auto found = results.download();
  const auto records = atlas.triangles().download();
  const auto table = atlas.table().download();
  double sum = 0, sum2 = 0, error2 = 0, nearest2 = 0;
  for (uint32_t i = 0; i < count; ++i) {
    const double exact = wave(point_on(g, p.triangles[i], p.points[i].x, p.points[i].y), extent);
    const uint32_t texel = table[atlas_cell(records[p.triangles[i]], p.points[i].x, p.points[i].y)];
    CHECK(found[i].w == doctest::Approx(1));
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
