// SPDX-License-Identifier: Apache-2.0
// G-buffer and DirectLight against closed forms: absorption, surfaces with an ideal and a diffuse lobe, veils, the sky
// behind mirrors and glass.
#include "lucarium/services/direct_light/direct_light.h"
#include "lucarium/services/gbuffer/gbuffer.h"
#include "test_render.h"
#include "tolerance.h"

using namespace lucarium;
using namespace lucarium::test;

namespace {

constexpr uint32_t kPixelLightSide = 16;

/// Means over the image of emission and direct light (green) for independent seeds.
struct PixelMeans {
  std::vector<double> emission, direct;
};

struct PixelRender {
  PixelRender(const Scene& scene, const SceneCamera& camera)
      : context(scene, camera, PathIntegratorOptions(), kPixelLightSide),
        gbuffer(*test_device(), context.scheduler, context.buffers, context.bvh, context.frame, "test"),
        sums(*test_device(), "test", "sums", kPixelLightSide * kPixelLightSide) {}

  /// The points of one sample.
  std::vector<GBufferPoint> points(uint32_t sample = 0) {
    REQUIRE(gbuffer.render(sample));
    context.scheduler.finish();
    return gbuffer.points().download();
  }
  /// Sums of direct light at the points of the last sample.
  std::vector<float4> direct(uint32_t kinds, uint32_t sample, uint32_t seed) {
    DirectLight service(*test_device(), context.scheduler, context.buffers, context.bvh, "test", kinds);
    sums.fill_zero();
    REQUIRE(service.accumulate_radiance(gbuffer.points(), sums, sample, seed));
    context.scheduler.finish();
    return sums.download();
  }
  /// `times_in_full`: how many times as many samples a full run takes, whose errors must be less (ClosedForms::check).
  PixelMeans means(uint32_t seeds, uint32_t samples, uint32_t times_in_full = 1) {
    if (full_run()) samples *= times_in_full;
    DirectLight service(*test_device(), context.scheduler, context.buffers, context.bvh, "test");
    PixelMeans result;
    const double count = static_cast<double>(samples) * kPixelLightSide * kPixelLightSide;
    for (uint32_t seed = 1; seed <= seeds; ++seed) {
      Frame frame = context.frame;
      frame.seed = seed;
      gbuffer.set_frame(frame);
      sums.fill_zero();
      double emission = 0, direct = 0;
      for (uint32_t sample = 0; sample < samples; ++sample) {
        for (const GBufferPoint& point : points(sample)) emission += point.emission.y;
        REQUIRE(service.accumulate_radiance(gbuffer.points(), sums, sample, seed));
      }
      context.scheduler.finish();
      for (const float4& sum : sums.download()) direct += sum.y;
      result.emission.push_back(emission / count);
      result.direct.push_back(direct / count);
    }
    return result;
  }

  TestRender context;
  GBuffer gbuffer;
  TypedBuffer<float4> sums;
};

/// Nearly a single ray straight down from `height` at (x, 0).
SceneCamera look_down(float height, float x = 0) { return look_orthographic({x, height, 0}, {x, 0, 0}, 0.002f); }

/// A volume of ior 1, at whose surface nothing is reflected or bent, which keeps 1/2 of green light per metre.
SceneMaterial tinted_air() {
  SceneMaterial material = lambert(1);
  material.roughness = 0;
  material.transmission = material.thickness = 1;
  material.attenuation_distance = 1;
  material.attenuation_color = glm::vec3(0.25f, 0.5f, 1);
  return material;
}

/// A volume with a rough surface, which keeps `kept` of all light per metre.
SceneMaterial frosted_glass(float kept) {
  SceneMaterial frosted = lambert(1);
  frosted.ior = 1.5f;
  frosted.roughness = 0.6f;
  frosted.transmission = frosted.thickness = 1;
  frosted.attenuation_distance = 1;
  frosted.attenuation_color = glm::vec3(kept);
  return frosted;
}

/// Illuminance below the centre of a parallel unit square of radiance 1 at height 1 [lx], when 2^-d is left of light
/// after d metres.
double absorbed_square_light() {
  double sum = 0;
  const int n = 200;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      const double x = (i + 0.5) / n - 0.5, y = (j + 0.5) / n - 0.5, d2 = 1 + x * x + y * y;
      sum += std::exp2(-std::sqrt(d2)) / (d2 * d2) / (n * n);
    }
  return sum;
}

}  // namespace

TEST_CASE("direct light: through tinted glass, of lamps in it and at things in it") {
  // A block from y = 0 to 2, above it a thin pane, which has no inside and absorbs nothing. In the block a plate at
  // y = 0.5 that shines, or is lit by a point light or a square lamp 1 m above it.
  Scene scene;
  SceneMaterial pane = tinted_air();
  pane.thickness = 0;
  add_horizontal(scene, 0, 3, 0, 30, 10, true, add_material(scene, pane));
  add_box(scene, {-15, 0, -5}, {15, 2, 5}, false, add_material(scene, tinted_air()));
  const int plate = add_material(scene, lambert(0.5f));
  const double way_in = std::exp2(-1.5);
  SUBCASE("a lamp in the block") {
    add_horizontal(scene, 0, 0.5f, 0, 1, 1, true, add_material(scene, emitter(2)));
    PixelRender render(scene, look_down(5));
    for (const GBufferPoint& point : render.points()) CHECK(point.emission.y == test::relative(2 * way_in, 1e-4));
  }
  SUBCASE("a point light in the block") {
    add_horizontal(scene, 0, 0.5f, 0, 1, 1, true, plate);
    add_light(scene, LightType::point, 100, {0, 1.5f, 0}, {0, 0, 0});
    PixelRender render(scene, look_down(5));
    render.points();
    for (const float4& sum : render.direct(DirectLight::kAllLights, 0, 1))
      CHECK(sum.y == test::relative(way_in * 0.5 / M_PI * 100 * 0.5, 1e-4));
  }
  SUBCASE("a square lamp in the block") {
    add_horizontal(scene, 0, 0.5f, 0, 1, 1, true, plate);
    add_horizontal(scene, 0, 1.5f, 0, 1, 1, false, add_material(scene, emitter(10)));
    // Past the lamp at 45 degrees.
    PixelRender render(scene, look_orthographic({3, 3.5f, 0}, {0, 0.5f, 0}, 0.002f));
    const PixelMeans means = render.means(8, 16, 4);
    const double inside = std::sqrt(2.0) * 1.5;
    ClosedForms table;
    table.add("lamp", estimate_of(means.direct), std::exp2(-inside) * 0.5 / M_PI * 10 * absorbed_square_light());
    table.check(5e-3);
  }
  SUBCASE("points on the block's own walls, seen from inside") {
    // The bottom's inner side, 1 m below a point light.
    add_light(scene, LightType::point, 100, {0, 1, 0}, {0, 0, 0});
    PixelRender render(scene, look_down(5));
    uint32_t bottom = 0;
    const std::vector<Vertex> vertices = render.context.buffers.scene_vertices.download();
    const std::vector<Triangle> triangles = render.context.buffers.scene_triangles.download();
    const auto at = [&](uint32_t vertex) { return vertices[vertex].position.xyz(); };
    SurfacePoint point{};
    for (uint32_t t = 0; t < triangles.size(); ++t) {
      const glm::vec3 a = at(triangles[t].v0), e1 = at(triangles[t].v1) - a, e2 = at(triangles[t].v2) - a;
      if (a.y != 0 || e1.y != 0 || e2.y != 0) continue;
      ++bottom;
      point.triangle = t;
      point.u = point.v = 0.25f;
      point.position = float4(a + 0.25f * (e1 + e2), 0);
      point.normal = float4(0, 1, 0, 0);
    }
    REQUIRE(bottom == 2);
    TypedBuffer<SurfacePoint> points(*test_device(), "test", "points", std::vector<SurfacePoint>(64, point));
    TypedBuffer<float4> sums(*test_device(), "test", "sums", 64);
    sums.fill_zero();
    DirectLight service(*test_device(), render.context.scheduler, render.context.buffers, render.context.bvh, "test",
                        DirectLight::kPunctualLights);
    REQUIRE(service.accumulate_irradiance(points, sums, 0, 1));
    render.context.scheduler.finish();
    const double d2 = glm::dot(point.position.xyz(), point.position.xyz()) + 1, d = std::sqrt(d2);
    for (const float4& sum : sums.download()) CHECK(sum.y == test::relative(100 / d2 / d * std::exp2(-d), 1e-4));
  }
}

TEST_CASE("direct light: through tinted glass with a rough surface it is the path tracer's") {
  // A lamp in a block of frosted glass: light samples and hits cross the surface into the medium.
  Scene scene;
  add_box(scene, {-5, 0, -5}, {5, 2, 5}, false, add_material(scene, frosted_glass(0.25f)));
  add_horizontal(scene, 0, 1, 0, 2, 2, true, add_material(scene, emitter(10)));
  const SceneCamera camera = look_down(5);
  PathIntegratorOptions options = direct_only();
  options.path_set.emission = false;
  const Estimate paths = estimate(scene, camera, options, {kPixelLightSide, 16, 64});
  PixelRender render(scene, camera);
  const Estimate services = estimate_of(render.means(8, 64).direct);
  const double error = std::sqrt(paths.error * paths.error + services.error * services.error);
  INFO(paths.mean, " +- ", paths.error, " and ", services.mean, " +- ", services.error);
  CHECK(error < 0.01 * paths.mean);
  CHECK(std::abs(paths.mean - services.mean) < 4 * error);
}

TEST_CASE("direct light: through tinted glass, of a point light below its rough surface") {
  // Light samples alone find it. Sample by sample, a block that keeps 1/4 per metre shows it 4^-d as bright as a clear
  // one does. The path tracer is no judge here, since it takes the same light samples.
  const glm::vec3 light(0.5f, 1, 0);
  const auto sums = [&](float kept, std::vector<GBufferPoint>* points) {
    Scene scene;
    add_box(scene, {-5, 0, -5}, {5, 2, 5}, false, add_material(scene, frosted_glass(kept)));
    add_light(scene, LightType::point, 100, light, glm::vec3(0));
    PixelRender render(scene, look_down(5));
    *points = render.points();
    return render.direct(DirectLight::kAllLights, 0, 1);
  };
  std::vector<GBufferPoint> points;
  const std::vector<float4> clear = sums(1, &points), tinted = sums(0.25f, &points);
  for (size_t i = 0; i < points.size(); ++i) {
    const float distance = glm::length(light - points[i].position.xyz());
    CHECK(distance == test::relative(std::sqrt(1.25), 1e-2));
    CHECK(clear[i].y > 0);
    CHECK(tinted[i].y == test::relative(clear[i].y * std::pow(0.25, distance), 1e-4));
  }
}

TEST_CASE("direct light: of surfaces with an ideal and a diffuse lobe") {
  // Polished plastic 1 m below a square lamp, seen from just below the lamp: the lamp's mirror image is emission, what
  // the diffuse lobe sends is direct light. Its albedo is 0.6 (1 - Ebar) with Ebar of F0 = 0.04 and an ideal lobe.
  Scene scene;
  SceneMaterial plastic = lambert(0.6f);
  plastic.ior = 1.5f;
  plastic.roughness = 0;
  add_horizontal(scene, 0, 0, 0, 4, 4, true, add_material(scene, plastic));
  add_horizontal(scene, 0, 1, 0, 1, 1, false, add_material(scene, emitter(10)));
  PixelRender render(scene, look_down(0.9f));
  const PixelMeans means = render.means(8, 32, 64);
  ClosedForms table;
  table.add("mirror image", estimate_of(means.emission), 0.4);
  table.add("diffuse lobe", estimate_of(means.direct), 0.6 * (1 - (0.04 * (1 - 1 / 21.) + 1 / 21.)) / M_PI * 7.52275);
  table.check(0.02);
}

TEST_CASE("direct light: through veils that let half of it pass") {
  // A veil of alpha 1/2 between a point light and a floor. Every shadow ray decides by itself.
  Scene scene;
  SceneMaterial veil = lambert(0);
  veil.alpha_mode = AlphaMode::blend;
  veil.base_color.a = 0.5f;
  add_horizontal(scene, 0, 0, 0, 4, 4, true, add_material(scene, lambert(0.5f)));
  add_horizontal(scene, 0, 1, 0, 4, 4, true, add_material(scene, veil));
  // Beside the edge that the veil's triangles share.
  add_light(scene, LightType::point, 100, {0.3f, 2, 0}, {0, 0, 0});
  PixelRender render(scene, look_down(0.5f));
  const uint32_t samples = 16;
  double at_pixels = 0, at_points = 0;
  DirectLight service(*test_device(), render.context.scheduler, render.context.buffers, render.context.bvh, "test");
  for (uint32_t sample = 0; sample < samples; ++sample) {
    render.points(sample);
    for (const float4& sum : render.direct(DirectLight::kAllLights, sample, 1)) at_pixels += sum.y;
  }
  // Every pixel shows the middle of the floor.
  const GBufferPoint middle = render.gbuffer.points().download()[0];
  SurfacePoint point{};
  point.u = middle.u, point.v = middle.v;
  point.triangle = middle.triangle;
  point.position = middle.position;
  point.normal = float4(0, 1, 0, 0);
  TypedBuffer<SurfacePoint> points(*test_device(), "test", "points", std::vector<SurfacePoint>(256, point));
  TypedBuffer<float4> sums(*test_device(), "test", "sums", 256);
  sums.fill_zero();
  for (uint32_t sample = 0; sample < samples; ++sample) REQUIRE(service.accumulate_irradiance(points, sums, sample, 1));
  render.context.scheduler.finish();
  for (const float4& sum : sums.download()) at_points += sum.y;
  // 4096 decisions of probability 1/2: 5 standard deviations.
  const double count = 256.0 * samples, allowed = 5 * 0.5 / std::sqrt(count), without = 100 * 2 / std::pow(4.09, 1.5);
  CHECK(std::abs(at_points / count / without - 0.5) < allowed);
  CHECK(std::abs(at_pixels / count / (without * 0.5 / M_PI) - 0.5) < allowed);
}

TEST_CASE("direct light: that of each kind of lights adds up to that of all, sample by sample") {
  Scene scene;
  SceneMaterial glossy = lambert(0.5f);
  glossy.ior = 1.5f;
  glossy.roughness = 0.4f;
  add_horizontal(scene, 0, 0, 0, 4, 4, true, add_material(scene, glossy));
  add_horizontal(scene, 0, 1, 0, 1, 1, false, add_material(scene, emitter(10)));
  add_light(scene, LightType::point, 10, {1, 1, 0}, {0, 0, 0});
  set_environment(scene, 3);
  PixelRender render(scene, look_orthographic({2, 1.5f, 0}, {0, 0, 0}, 0.2f));
  render.points();
  const std::vector<float4> all = render.direct(DirectLight::kAllLights, 0, 1);
  std::vector<float4> added(all.size(), float4(0, 0, 0, 0));
  for (const uint32_t kinds :
       {uint32_t{DirectLight::kPunctualLights}, 1u << LUCARIUM_LIGHT_TRIANGLE, 1u << LUCARIUM_LIGHT_ENVIRONMENT}) {
    const std::vector<float4> some = render.direct(kinds, 0, 1);
    double mean = 0;
    for (size_t i = 0; i < all.size(); ++i) added[i].y += some[i].y, mean += some[i].y;
    CHECK(mean > 0);
  }
  for (size_t i = 0; i < all.size(); ++i) CHECK(added[i].y == test::within(all[i].y, 1e-5 * (1 + double(all[i].y))));
}

TEST_CASE("G-buffer: two mirrors that shine at each other show 1 / (1 - F) of themselves") {
  // Of F = 0.98 most light comes after many events, from which on chance decides whether a path goes on.
  Scene scene;
  SceneMaterial mirror;
  mirror.roughness = 0;
  mirror.base_color = glm::vec4(0.98f, 0.98f, 0.98f, 1);
  mirror.emissive_factor = glm::vec3(1);
  const int material = add_material(scene, mirror);
  add_horizontal(scene, 0, 0, 0, 1, 1, true, material);
  add_horizontal(scene, 0, 1, 0, 1, 1, false, material);
  const PixelMeans means = PixelRender(scene, look_down(0.5f)).means(8, 4, 400);
  ClosedForms table;
  table.add("mirrors", estimate_of(means.emission), 50);
  table.check(0.03);
}

TEST_CASE("G-buffer: the sky through mirrors and glass, of which no two directions are alike") {
  // Rows from the top: 4, then two rows with a lighter half about +x, then 1.
  Scene scene;
  Environment& sky = scene.environment.emplace();
  sky.width = sky.height = 4;
  for (const float radiance : {4.f, 4.f, 4.f, 4.f, 2.f, 3.f, 3.f, 2.f, 2.f, 3.f, 3.f, 2.f, 1.f, 1.f, 1.f, 1.f})
    sky.radiance.emplace_back(radiance);
  SUBCASE("a pane of index 1.5: (1 - R) / (1 + R) of the sky below, the rest of the one above") {
    SceneMaterial glass = lambert(1);
    glass.ior = 1.5f;
    glass.roughness = 0;
    glass.transmission = glass.thickness = 1;
    add_box(scene, {-2, 0, -2}, {2, 0.2f, 2}, false, add_material(scene, glass));
    const PixelMeans means = PixelRender(scene, look_down(3)).means(8, 32, 24);
    ClosedForms table;
    table.add("sky", estimate_of(means.emission), 0.923077 * 1 + 0.076923 * 4, 1e-3);
    table.check(0.01);
  }
  SUBCASE("a mirror at 45 degrees") {
    SceneMaterial mirror;
    mirror.roughness = 0;
    mirror.base_color = glm::vec4(0.5f, 0.5f, 0.5f, 1);
    add_polygon(scene, {{-1, -1, 1}, {1, 1, 1}, {1, 1, -1}, {-1, -1, -1}}, add_material(scene, mirror));
    PixelRender render(scene, look_down(3));
    const double fresnel = 0.5 + 0.5 * std::pow(1 - std::sqrt(0.5), 5);
    for (const GBufferPoint& point : render.points()) CHECK(point.emission.y == test::relative(2 * fresnel, 1e-4));
  }
  SUBCASE("sides and albedos of what stays: a double-sided plate from behind, frosted white glass") {
    SceneMaterial plate = lambert(0.25f);
    plate.double_sided = true;
    add_horizontal(scene, 0, 0, 0, 1, 1, false, add_material(scene, plate));
    for (const GBufferPoint& point : PixelRender(scene, look_down(3)).points()) {
      CHECK(point.normal.w == 1);
      CHECK(point.normal.y == test::relative(1));
      CHECK(point.albedo.y == test::relative(0.25, 1e-4));
    }
    SceneMaterial frosted = lambert(1);
    frosted.ior = 1.5f;
    frosted.roughness = 0.5f;
    frosted.transmission = 1;
    add_horizontal(scene, 0, 1, 0, 1, 1, true, add_material(scene, frosted));
    for (const GBufferPoint& point : PixelRender(scene, look_down(3)).points()) {
      CHECK(point.normal.w == 0);
      CHECK(point.albedo.y == test::relative(1, 1e-4));
    }
  }
}
