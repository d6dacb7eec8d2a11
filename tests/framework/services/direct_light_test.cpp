// SPDX-License-Identifier: Apache-2.0
// G-buffer and DirectLight together are the path tracer's emission and direct layers.
#include "lucarium/services/direct_light/direct_light.h"

#include "lucarium/scene/builtin/scenes.h"
#include "test_render.h"
#include "tolerance.h"

using namespace lucarium;
using namespace lucarium::test;

namespace {

constexpr uint32_t kSide = 32;

/// Means of the red channel over the image for independent seeds.
struct LayerMeans {
  std::vector<double> emission, direct;
};

LayerMeans by_services(const Scene& scene, uint32_t seeds, uint32_t samples, uint32_t kinds = DirectLight::kAllLights) {
  PathIntegratorOptions unused;
  TestRender context(scene, scene.cameras.at(0), unused, kSide);
  GBuffer gbuffer(*test_device(), context.scheduler, context.buffers, context.bvh, context.frame, "test");
  DirectLight direct(*test_device(), context.scheduler, context.buffers, context.bvh, "test", kinds);
  TypedBuffer<float4> sums(*test_device(), "test", "sums", kSide * kSide);
  LayerMeans means;
  for (uint32_t seed = 1; seed <= seeds; ++seed) {
    Frame frame = context.frame;
    frame.seed = seed;
    gbuffer.set_frame(frame);
    sums.fill_zero();
    double emission = 0, reflected = 0;
    for (uint32_t sample = 0; sample < samples; ++sample) {
      REQUIRE(gbuffer.render(sample));
      context.scheduler.finish();
      for (const GBufferPoint& point : gbuffer.points().download()) emission += point.emission.x;
      REQUIRE(direct.accumulate_radiance(gbuffer.points(), sums, sample, seed));
    }
    context.scheduler.finish();
    for (const float4& sum : sums.download()) {
      CHECK(sum.w == samples);
      reflected += sum.x;
    }
    means.emission.push_back(emission / (kSide * kSide * samples));
    means.direct.push_back(reflected / (kSide * kSide * samples));
  }
  return means;
}

LayerMeans by_paths(const Scene& scene, uint32_t replicates, uint32_t samples, PathIntegratorOptions options = {}) {
  options.path_set.max_bounces = 0;
  LayerMeans means;
  options.path_set.direct = false;
  means.emission = replicate_means(scene, scene.cameras.at(0), options, {kSide, replicates, samples});
  options.path_set.direct = true;
  options.path_set.emission = false;
  means.direct = replicate_means(scene, scene.cameras.at(0), options, {kSide, replicates, samples});
  return means;
}

void check_same_mean(const std::string& what, const std::vector<double>& one, const std::vector<double>& other) {
  const Estimate a = estimate_of(one), b = estimate_of(other);
  const double error = std::sqrt(a.error * a.error + b.error * b.error);
  INFO(what, ": ", a.mean, " +- ", a.error, " and ", b.mean, " +- ", b.error);
  CHECK(b.mean > 0);
  CHECK(std::abs(a.mean - b.mean) <=
        student_t_quantile(sidak_level(0.01, 8), a.replicates - 1) * error + 1e-6 * b.mean);
  CHECK(error <= 0.03 * b.mean);
}

/// A mirror, glass, and lights of every kind.
Scene mixed_scene() {
  Scene scene = make_builtin_scene("cornell-mirror");
  set_environment(scene, 0.5f);
  const glm::vec3 center = scene.bounds().center();
  add_light(scene, LightType::point, 0.1f, center, center - glm::vec3(0, 1, 0));
  add_light(scene, LightType::spot, 0.2f, center + glm::vec3(0, .2f, 0), center - glm::vec3(0, 1, 0));
  add_light(scene, LightType::directional, 0.3f, center + glm::vec3(0, .2f, 1), center);
  SceneMaterial glass = clear_glass();
  const float size = 0.15f * scene.bounds().radius();
  add_box(scene, center - size, center + size, false, add_material(scene, glass));
  return scene;
}

}  // namespace

TEST_CASE("direct light: at the G-buffer's pixels it is the path tracer's direct layer") {
  for (const Scene& scene : {make_builtin_scene("cornell"), make_builtin_scene("cornell-glossy"), mixed_scene()}) {
    const LayerMeans services = by_services(scene, 8, 16), paths = by_paths(scene, 8, 16);
    check_same_mean(scene.source + " emission", services.emission, paths.emission);
    check_same_mean(scene.source + " direct", services.direct, paths.direct);
  }
}

TEST_CASE("direct light: many lights on both sides of rough glass, chosen by place as by power") {
  Scene scene = make_builtin_scene("cornell");
  const Bounds bounds = scene.bounds();
  const glm::vec3 center = bounds.center(), half = bounds.max - center;
  SceneMaterial glass = clear_glass();
  glass.roughness = 0.5f;
  add_box(scene, center - 0.6f * half, center + 0.6f * half, false, add_material(scene, glass));
  for (int i = 0; i < 8; ++i) {
    const glm::vec3 place(0.2f * static_cast<float>(i % 4) - 0.3f, 0.1f, i < 4 ? 0.1f : 0.8f);
    add_light(scene, LightType::point, 0.02f, center + half * place, center);
    add_light(scene, LightType::point, 0.02f, center - half * place, center);
  }
  PathIntegratorOptions by_power;
  by_power.light_choice = LightChoice::power;
  const LayerMeans paths = by_paths(scene, 16, 64, by_power);
  check_same_mean("by services", by_services(scene, 16, 64).direct, paths.direct);
  check_same_mean("by paths", by_paths(scene, 16, 64).direct, paths.direct);
}

TEST_CASE("direct light: of some kinds of lights only") {
  const Scene scene = mixed_scene();
  PathIntegratorOptions punctual, others;
  punctual.path_set.emissive_triangles = punctual.path_set.environment = false;
  others.path_set.point_lights = others.path_set.spot_lights = others.path_set.directional_lights = false;
  check_same_mean("punctual", by_services(scene, 8, 16, DirectLight::kPunctualLights).direct,
                  by_paths(scene, 8, 16, punctual).direct);
  check_same_mean("others", by_services(scene, 8, 16, DirectLight::kAllLights & ~DirectLight::kPunctualLights).direct,
                  by_paths(scene, 8, 16, others).direct);
}

TEST_CASE("direct light: irradiance at surface points, against closed forms") {
  // A point light of 100 cd at height 2: E = 25 at its foot, and 100 * 2 / 8^1.5 at 2 m. A unit-square light of
  // radiance 10 at height 1 gives 7.52275 below its centre. The environment of radiance 1, alone, gives pi.
  Scene lamps, square, sky;
  for (Scene* scene : {&lamps, &square, &sky})
    add_horizontal(*scene, 0, 0, 0, 40, 40, true, add_material(*scene, lambert(0.5f)));
  add_light(lamps, LightType::point, 100, {0, 2, 0}, {0, 0, 0});
  add_horizontal(square, 0, 1, 0, 1, 1, false, add_material(square, emitter(10)));
  set_environment(sky, 1);
  const uint32_t samples = full_run() ? 256 : 64;
  ClosedForms table;
  struct Row {
    const Scene* scene;
    glm::vec2 at;
    double exact;
  };
  for (const Row& row : {Row{&lamps, {0, 0}, 25}, Row{&lamps, {2, 0}, 200 / std::pow(8, 1.5)},
                         Row{&square, {0, 0}, 7.52275}, Row{&sky, {3, 1}, M_PI}}) {
    PathIntegratorOptions unused;
    TestRender context(*row.scene, look_orthographic({0, 1, 0}, {0, 0, 0}, 1), unused, 8);
    SurfacePoint point{};
    // Barycentrics of the point within the floor's triangles (corners ±20 m).
    const float s = (row.at.x + 20) / 40, t = (20 - row.at.y) / 40;
    const bool first = s >= t;
    point.triangle = first ? 0 : 1;
    point.u = first ? s - t : s;
    point.v = first ? t : t - s;
    point.position = float4(row.at.x, 0, row.at.y, 0);
    point.normal = float4(0, 1, 0, 0);
    const std::vector<SurfacePoint> copies(64, point);
    TypedBuffer<SurfacePoint> points(*test_device(), "test", "points", copies);
    TypedBuffer<float4> sums(*test_device(), "test", "sums", copies.size());
    DirectLight direct(*test_device(), context.scheduler, context.buffers, context.bvh, "test");
    std::vector<double> means;
    for (uint32_t seed = 1; seed <= 8; ++seed) {
      sums.fill_zero();
      for (uint32_t sample = 0; sample < samples; ++sample)
        REQUIRE(direct.accumulate_irradiance(points, sums, sample, seed));
      context.scheduler.finish();
      double mean = 0;
      for (const float4& sum : sums.download()) mean += sum.x / sum.w / static_cast<double>(copies.size());
      means.push_back(mean);
    }
    table.add("at " + std::to_string(row.at.x), estimate_of(means), row.exact);
  }
  table.check(1e-3);
}

TEST_CASE("direct light: schedules of buffers that are no longer used are not kept") {
  const Scene scene = make_builtin_scene("cornell");
  PathIntegratorOptions unused;
  TestRender context(scene, scene.cameras.at(0), unused, kSide);
  GBuffer gbuffer(*test_device(), context.scheduler, context.buffers, context.bvh, context.frame, "test");
  DirectLight direct(*test_device(), context.scheduler, context.buffers, context.bvh, "test");
  const auto used_after = [&](int pairs) {
    for (int i = 0; i < pairs; ++i) {
      const TypedBuffer<float4> sums(*test_device(), "test", "sums", kSide * kSide);
      const TypedBuffer<SurfacePoint> points(*test_device(), "test", "points", std::vector<SurfacePoint>(kSide));
      REQUIRE(direct.accumulate_radiance(gbuffer.points(), sums, 0, 1));
      REQUIRE(direct.accumulate_irradiance(points, sums, 0, 1));
      context.scheduler.finish();
    }
    return test_device()->memory().used_bytes();
  };
  REQUIRE(gbuffer.render(0));
  const size_t few = used_after(3);
  CHECK(used_after(5) == few);
}

TEST_CASE("G-buffer: first surfaces behind mirrors and glass, and what is seen of them") {
  // A mirror at 45 degrees shows the emitter above it; the chain has one event and no surface is kept behind the light.
  Scene scene;
  SceneMaterial mirror;
  mirror.roughness = 0;
  mirror.base_color = glm::vec4(0.5f, 0.5f, 0.5f, 1);
  add_polygon(scene, {{-1, -1, 1}, {1, -1, 1}, {1, 1, -1}, {-1, 1, -1}}, add_material(scene, mirror));
  add_horizontal(scene, 0, 3, 0, 8, 8, false, add_material(scene, emitter(2, 0.25f)));
  PathIntegratorOptions unused;
  TestRender context(scene, look_orthographic({0, 0, 5}, {0, 0, 0}, 0.5f), unused, 16);
  GBuffer gbuffer(*test_device(), context.scheduler, context.buffers, context.bvh, context.frame, "test");
  REQUIRE(gbuffer.render(0));
  context.scheduler.finish();
  const double fresnel = 0.5 + 0.5 * std::pow(1 - std::sqrt(0.5), 5);
  for (const GBufferPoint& point : gbuffer.points().download()) {
    CHECK(point.state == LUCARIUM_GBUFFER_SURFACE);
    CHECK(point.throughput.w == 1);
    CHECK(point.throughput.x == test::relative(fresnel, 1e-5));
    CHECK(point.emission.x == test::relative(2 * fresnel, 1e-5));
    CHECK(point.albedo.x == test::relative(0.25, 1e-5));
    CHECK(point.position.y == test::relative(3, 1e-5));
    CHECK(point.normal.y == test::relative(-1));
    CHECK(point.position.w == test::relative(8, 1e-5));
  }
  Film film(16, 16);
  gbuffer.resolve(film);
  for (const char* name : {"Albedo", "P", "N", "Ns"}) CHECK(film.find(name) != nullptr);
}

TEST_CASE("G-buffer: light that total reflection keeps in facets of glass comes out") {
  SceneMaterial glass;
  glass.metallic = glass.roughness = 0;
  glass.transmission = glass.thickness = 1;
  Scene scene;
  add_triangles(scene, sphere_triangles({0, 0, 0}, 1, 5, false), add_material(scene, glass));
  set_environment(scene, 1);
  PathIntegratorOptions unused;
  TestRender context(scene, look_orthographic({0, 0, 3}, {0, 0, 0}, 1.1f), unused, 64);
  GBuffer gbuffer(*test_device(), context.scheduler, context.buffers, context.bvh, context.frame, "test");
  for (uint32_t sample = 0; sample < 8; ++sample) {
    REQUIRE(gbuffer.render(sample));
    context.scheduler.finish();
    uint32_t dark = 0;
    for (const GBufferPoint& point : gbuffer.points().download()) dark += std::abs(point.emission.x - 1) > 1e-5;
    CHECK(dark == 0);
  }
}
