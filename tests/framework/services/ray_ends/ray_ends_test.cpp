// SPDX-License-Identifier: Apache-2.0
// Which surfaces rays leave and are to reach, as services say it to intersectors that want to know: every start must
// be the triangle off which the ray's origin lies, on the side that is said, and every end likewise.
#include "lucarium/services/ray_ends.h"

#include <glm/glm.hpp>
#include <random>

#include "end_keeper.h"
#include "lucarium/film/film.h"
#include "lucarium/scene/builtin/builder.h"
#include "lucarium/scene/builtin/scenes.h"
#include "lucarium/services/direct_light/direct_light.h"
#include "lucarium/services/gbuffer/gbuffer.h"
#include "lucarium/services/interior_surfaces/point_interior.h"
#include "lucarium/services/interior_surfaces/texel_interior.h"
#include "lucarium/services/light_at_points/light_at_points.h"
#include "lucarium/services/light_paths/light_paths.h"
#include "lucarium/services/path_integrator/path_integrator.h"
#include "lucarium/services/specular_chains/specular_chains.h"
#include "made_scene.h"

using namespace lucarium;
using namespace lucarium::test;

namespace {

// Farthest that rays begin and end from their triangles, over the largest coordinate: triangle_ray_offset() of a normal
// along the diagonal and a triangle through the whole scene, and an ulp of rounding.
const double kOffset = (16 * std::sqrt(3.0) + 3 + 1) / (1 << 20);
constexpr uint32_t kSide = 24, kPixels = kSide * kSide;

/// A scene with what built-in ones lack: glass, MASK and BLEND, emitters with two sides, and all kinds of lights.
Scene made_scene() {
  Scene scene;
  scene.source = "test:ray ends";
  test::add_box(scene, glm::vec3(-1), glm::vec3(1), true, add_material(scene, lambert(0.6f)));
  SceneMaterial glass = clear_glass();
  add_triangles(scene, sphere_triangles({0.3f, -0.5f, 0.2f}, 0.3f, 3, false), add_material(scene, glass));
  SceneMaterial frosted = glass;
  frosted.roughness = 0.4f;
  frosted.thickness = 0;
  add_horizontal(scene, -0.4f, -0.3f, 0.1f, 0.5f, 0.5f, true, add_material(scene, frosted));
  SceneMaterial veil = lambert(0.8f);
  veil.base_color.w = 0.5f;
  veil.alpha_mode = AlphaMode::blend;
  veil.double_sided = true;
  add_horizontal(scene, 0, 0.3f, 0, 1.2f, 1.2f, true, add_material(scene, veil));
  SceneMaterial lamp = emitter(3);
  lamp.double_sided = true;
  add_horizontal(scene, 0.1f, 0.7f, 0.2f, 0.4f, 0.3f, true, add_material(scene, lamp));
  test::add_light(scene, LightType::point, 2, {0.5f, 0.2f, -0.4f}, {0, -1, 0});
  test::add_light(scene, LightType::spot, 5, {-0.3f, 0.6f, 0.4f}, {0, -1, 0});
  test::add_light(scene, LightType::directional, 1, {0, 1, 0}, {0.2f, -1, 0.1f});
  set_environment(scene, 0.5f);
  scene.cameras.push_back(look_perspective({0.7f, 0.1f, -0.8f}, {0, -0.3f, 0.1f}, 1.2f));
  return scene;
}

std::vector<std::pair<std::string, Scene>> test_scenes() {
  std::vector<std::pair<std::string, Scene>> scenes;
  scenes.emplace_back("made", made_scene());
  for (const std::string& name : builtin_scene_names()) scenes.emplace_back(name, make_builtin_scene(name));
  return scenes;
}

/// Distance of a point from a triangle.
double distance_to(const glm::dvec3& p, const std::array<glm::dvec3, 3>& t) {
  const glm::dvec3 normal = glm::cross(t[1] - t[0], t[2] - t[0]);
  double nearest = INFINITY;
  bool inside = true;
  for (int i = 0; i < 3; ++i) {
    const glm::dvec3 a = t[i], edge = t[(i + 1) % 3] - a;
    const double along = glm::clamp(glm::dot(p - a, edge) / glm::dot(edge, edge), 0.0, 1.0);
    nearest = std::min(nearest, glm::length(p - a - along * edge));
    inside = inside && glm::dot(glm::cross(edge, p - a), normal) >= 0;
  }
  return inside ? std::abs(glm::dot(p - t[0], normal)) / glm::length(normal) : nearest;
}

/// What the ends of a service's rays are.
struct Ends {
  size_t rays = 0, any = 0, starts = 0, ends = 0;
  size_t far = 0, wrong_side = 0, ends_of_closest = 0;  ///< faults
  size_t back_starts = 0, back_ends = 0;
  double farthest = 0;  ///< of starts and ends from their triangles, over the largest coordinate [1]
};

/// A scene whose rays are looked at.
class Rig {
 public:
  explicit Rig(const Scene& scene)
      : scheduler(test_device()),
        buffers(*test_device(), scene),
        bvh(*test_device(), scene, buffers),
        keeper(bvh, 1 << 20),
        vertices_(buffers.scene_vertices.download()),
        triangles_(buffers.scene_triangles.download(0, buffers.info().triangle_count)) {
    frame.camera = make_camera(scene.cameras.at(0), 1);
    frame.width = frame.height = kSide;
    frame.seed = 7;
  }

  /// Looks at the rays since the last call; none may be wrong.
  Ends check(const std::string& service) {
    scheduler.finish();
    Ends found;
    for (const KeptRay& kept : keeper.take()) {
      ++found.rays;
      found.any += kept.any;
      const glm::dvec3 origin(kept.ray.origin.xyz()), direction(kept.ray.direction.xyz());
      if (kept.ends.start != LUCARIUM_NONE) {
        ++found.starts;
        found.back_starts += look_at(kept.ends.start, origin, found);
      }
      if (kept.ends.end != LUCARIUM_NONE) {
        ++found.ends;
        found.ends_of_closest += !kept.any;
        found.back_ends += look_at(kept.ends.end, origin + double{kept.ray.direction.w} * direction, found);
      }
    }
    INFO(service, ": ", found.rays, " rays, ", found.starts, " starts, ", found.ends, " ends, farthest ",
         found.farthest);
    CHECK(found.rays > 0);
    CHECK(found.far == 0);
    CHECK(found.wrong_side == 0);
    CHECK(found.ends_of_closest == 0);
    return found;
  }

  KernelScheduler scheduler;
  SceneBuffers buffers;
  Bvh bvh;
  EndKeeper keeper;
  Frame frame{};

 private:
  /// Whether the triangle's back is meant.
  bool look_at(uint32_t end, const glm::dvec3& point, Ends& found) const {
    const uint32_t index = end & ~LUCARIUM_RAY_END_BACK;
    REQUIRE(index < triangles_.size());
    const Triangle& triangle = triangles_[index];
    const std::array<glm::dvec3, 3> corners = {glm::dvec3(vertices_[triangle.v0].position.xyz()),
                                               glm::dvec3(vertices_[triangle.v1].position.xyz()),
                                               glm::dvec3(vertices_[triangle.v2].position.xyz())};
    double size = 0;
    for (const glm::dvec3& corner : corners)
      for (int axis = 0; axis < 3; ++axis) size = std::max(size, std::abs(corner[axis]));
    const double away = distance_to(point, corners) / size;
    found.farthest = std::max(found.farthest, away);
    found.far += !(away <= kOffset);
    const bool back = end & LUCARIUM_RAY_END_BACK;
    const glm::dvec3 normal = glm::cross(corners[1] - corners[0], corners[2] - corners[0]);
    found.wrong_side += (glm::dot(point - corners[0], normal) < 0) != back;
    return back;
  }
  std::vector<Vertex> vertices_;
  std::vector<Triangle> triangles_;
};

bool only_lamps(const Scene& scene) { return scene.lights.empty() && !scene.environment; }

}  // namespace

TEST_CASE("ray ends: of paths, and pictures do not depend on them") {
  for (const auto& [name, scene] : test_scenes()) {
    CAPTURE(name);
    Rig rig(scene);
    PathIntegratorOptions options;
    options.path_set.max_bounces = 3;
    options.samples_per_iteration = 2;
    Film films[2] = {Film(kSide, kSide), Film(kSide, kSide)};
    const Intersector* intersectors[2] = {&rig.keeper, &rig.bvh};
    for (int i = 0; i < 2; ++i) {
      PathIntegrator integrator(*test_device(), rig.scheduler, rig.buffers, *intersectors[i], rig.frame, options,
                                "test");
      REQUIRE(integrator.iterate());
      integrator.resolve(films[i]);
    }
    for (const char* layer : {"emission", "direct", "indirect"})
      CHECK(films[0].find(layer)->pixels == films[1].find(layer)->pixels);
    const Ends found = rig.check("paths");
    // All but the camera's own rays leave surfaces; lamps are ends, the other lights have none.
    CHECK(found.rays - found.starts == size_t{kPixels} * options.samples_per_iteration);
    if (only_lamps(scene)) CHECK(found.ends == found.any);
    if (name == "made") {
      CHECK(found.back_starts > 100);
      CHECK(found.back_ends > 100);
      CHECK(found.ends > 100);
      CHECK(found.ends < found.any);
    }
  }
}

TEST_CASE("ray ends: of the G-buffer, and of direct light at its pixels and at points") {
  for (const auto& [name, scene] : test_scenes()) {
    CAPTURE(name);
    Rig rig(scene);
    GBuffer gbuffer(*test_device(), rig.scheduler, rig.buffers, rig.keeper, rig.frame, "test");
    REQUIRE(gbuffer.render(0));
    const Ends seen = rig.check("G-buffer");
    CHECK(seen.rays - seen.starts == kPixels);
    CHECK(seen.ends == 0);

    DirectLight direct(*test_device(), rig.scheduler, rig.buffers, rig.keeper, "test");
    const TypedBuffer<float4> sums(*test_device(), "test", "sums", kPixels);
    REQUIRE(direct.accumulate_radiance(gbuffer.points(), sums, 0, 3));
    const Ends pixels = rig.check("direct light at pixels");
    CHECK(pixels.starts == pixels.rays);
    if (only_lamps(scene)) CHECK(pixels.ends == pixels.any);

    std::vector<SurfacePoint> points;
    for (const GBufferPoint& p : gbuffer.points().download()) {
      if (p.state != LUCARIUM_GBUFFER_SURFACE) continue;
      SurfacePoint point{};
      point.position = p.position;
      point.normal = p.normal;
      point.triangle = p.triangle;
      point.u = p.u;
      point.v = p.v;
      points.push_back(point);
    }
    const TypedBuffer<SurfacePoint> list(*test_device(), "test", "points", points);
    const TypedBuffer<float4> irradiance(*test_device(), "test", "irradiance", points.size());
    REQUIRE(direct.accumulate_irradiance(list, irradiance, 0, 3));
    const Ends at_points = rig.check("direct light at points");
    CHECK(at_points.starts == at_points.rays);
    if (only_lamps(scene)) CHECK(at_points.ends == at_points.any);
  }
}

TEST_CASE("ray ends: of light paths, and of the light of their vertices") {
  for (const auto& [name, scene] : test_scenes()) {
    CAPTURE(name);
    Rig rig(scene);
    const LightPaths paths(*test_device(), rig.buffers, rig.keeper, {.paths = 4096, .vertices = 3}, "test");
    const TypedBuffer<VirtualLight> lights(*test_device(), "test", "vertices", paths.virtual_lights(0));
    ScheduleRecorder recorder = rig.scheduler.record("light paths", "test");
    const Variable<uint32_t> run = recorder.variable("run", 3u), seed = recorder.variable("seed", 5u);
    paths.record_virtual_lights(recorder, run, seed, lights, 0, true);
    Schedule schedule = recorder.compile();
    REQUIRE(rig.scheduler.run(schedule) == RunResult::done);
    const Ends found = rig.check("light paths");
    CHECK(found.ends == 0);
    if (only_lamps(scene)) CHECK(found.starts == found.rays);
    if (name == "made") {
      CHECK(found.starts > 1000);
      CHECK(found.starts < found.rays);
      CHECK(found.back_starts > 100);
    }
  }
}

TEST_CASE("ray ends: of specular chains") {
  for (const auto& [name, scene] : test_scenes()) {
    CAPTURE(name);
    Rig rig(scene);
    GBuffer gbuffer(*test_device(), rig.scheduler, rig.buffers, rig.keeper, rig.frame, "test");
    REQUIRE(gbuffer.render(0));
    rig.check("G-buffer");
    const auto bind = [](PassBuilder& pass) { pass.arg("unused", 0u); };
    SpecularChains chains(*test_device(), rig.scheduler, rig.buffers, rig.keeper, {kPixels, true, "test", "pixels"},
                          {rig.keeper.program(), "advance_kept_chains", "add_kept_light", bind, bind});
    ScheduleRecorder recorder = rig.scheduler.record("begin", "test");
    PassBuilder begin = recorder.pass("begin", rig.keeper.program(), "begin_kept_chains");
    rig.buffers.bind(begin);
    begin.global(kPixels)
        .arg("points", gbuffer.points())
        .arg("count", kPixels)
        .arg("chains", chains.chains())
        .arg("ends", chains.first_ends())
        .arg("rays", chains.first_rays())
        .arg("queue", chains.queue())
        .arg("active", chains.active());
    Schedule schedule = recorder.compile();
    REQUIRE(rig.scheduler.run(schedule) == RunResult::done);
    ChainSettings settings{};
    settings.seed = 11;
    settings.lit = 1;
    settings.first_light = 1;
    settings.limit = LUCARIUM_NONE;
    settings.max_vertices = 16;
    REQUIRE(chains.follow(settings));
    const Ends found = rig.check("chains");
    CHECK(found.starts == found.rays);
    CHECK(found.ends == 0);  // punctual lights alone are sampled
    if (name == "made") CHECK(found.any > 0);
    if (name == "made") CHECK(found.back_starts > 100);
  }
}

TEST_CASE("ray ends: of walks from points and texels") {
  for (const auto& [name, scene] : test_scenes()) {
    if (name == "atrium") continue;  // walks from all its texels take long
    CAPTURE(name);
    Rig rig(scene);
    const uint32_t triangles = std::min(rig.buffers.info().triangle_count, 200u);
    std::vector<InteriorPoint> points;
    for (uint32_t t = 0; t < triangles; ++t) {
      points.push_back({t, 0.3f, 0.4f});
      points.push_back({t | INTERIOR_BACK, 0.2f, 0.1f});
    }
    const PointInterior interior(*test_device(), rig.scheduler, rig.buffers, rig.keeper, {.steps = 3}, "test", "");
    for (const auto side : {PointInterior::Side::own, PointInterior::Side::behind}) {
      interior.are_open(points, {}, side, 4, {});
      const Ends found = rig.check("points");
      CHECK(found.starts == found.rays);
      CHECK(found.back_starts > 0);
    }
    SurfaceAtlasOptions options;
    options.texel_count = 2000;
    options.samples = 4;
    const SurfaceAtlas atlas(*test_device(), rig.scheduler, scene, rig.buffers, options, "test");
    TexelInterior texels(*test_device(), rig.scheduler, rig.buffers, rig.keeper, atlas, "test", "");
    REQUIRE(texels.advance());
    const Ends found = rig.check("texels");
    CHECK(found.starts == found.rays);
  }
}
