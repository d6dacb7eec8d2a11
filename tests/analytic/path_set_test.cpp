// SPDX-License-Identifier: Apache-2.0
// Limits of the path set: layers are disjoint and complete, and switched-off sources leave nothing behind.
#include "lucarium/base/error.h"
#include "lucarium/scene/builtin/scenes.h"
#include "test_render.h"
#include "tolerance.h"

using namespace lucarium;
using namespace lucarium::test;

namespace {

constexpr Effort kEffort{32, 4, 4};

double mean_with(const Scene& scene, const PathSet& set) {
  PathIntegratorOptions options;
  options.path_set = set;
  return estimate(scene, scene.cameras.at(0), options, kEffort).mean;
}

PathSet layers(bool emission, bool direct, bool indirect, int max_bounces) {
  PathSet set;
  set.emission = emission;
  set.direct = direct;
  set.indirect = indirect;
  set.max_bounces = max_bounces;
  return set;
}

}  // namespace

TEST_CASE("path set: each layer alone is what it is among the others, bit for bit") {
  for (const char* name : {"cornell", "cornell-mirror"}) {
    const Scene scene = make_builtin_scene(name);
    PathIntegratorOptions options;
    options.path_set.max_bounces = 3;
    TestRender all(scene, scene.cameras[0], options, 32);
    REQUIRE(all.integrator->iterate());
    Film film(32, 32);
    all.integrator->resolve(film);
    for (int layer = 0; layer < 3; ++layer) {
      options.path_set = layers(layer == 0, layer == 1, layer == 2, 3);
      TestRender one(scene, scene.cameras[0], options, 32);
      REQUIRE(one.integrator->iterate());
      Film alone(32, 32);
      one.integrator->resolve(alone);
      for (const FilmLayer& other : alone.layers()) {
        const bool wanted = other.name == std::array{"emission", "direct", "indirect"}[layer];
        INFO(name, " ", other.name, " alone ", layer);
        CHECK(other.pixels == (wanted ? film.find(other.name)->pixels : std::vector<float>(other.pixels.size(), 0.f)));
      }
    }
  }
}

TEST_CASE("path set: an excluded kind of light gives nothing") {
  Scene scene = make_builtin_scene("cornell");
  PathSet set;
  set.max_bounces = 2;
  CHECK(mean_with(scene, set) > 0);
  set.emissive_triangles = false;
  CHECK(mean_with(scene, set) == 0);

  set = PathSet();
  set.max_bounces = 1;
  Scene open;
  open.cameras.push_back(look_perspective({0, 1, 2}, {0, 0, 0}, 0.8f));
  add_horizontal(open, 0, 0, 0, 4, 4, true, add_material(open, lambert(0.5f)));
  set_environment(open, 1);
  CHECK(mean_with(open, set) > 0);
  set.environment = false;
  CHECK(mean_with(open, set) == 0);
}

TEST_CASE("path set: the sum over kinds of light is the whole") {
  Scene scene = make_builtin_scene("cornell");
  add_light(scene, LightType::point, 0.1f, scene.bounds().center(), scene.bounds().center() - glm::vec3(0, 1, 0));
  PathIntegratorOptions options;
  options.path_set.max_bounces = 2;
  const Effort effort = full_run() ? Effort{64, 16, 64} : Effort{32, 16, 32};
  const Estimate whole = estimate(scene, scene.cameras[0], options, effort, 1);
  options.path_set.point_lights = false;
  const Estimate area = estimate(scene, scene.cameras[0], options, effort, 2);
  options.path_set.point_lights = true;
  options.path_set.emissive_triangles = false;
  const Estimate point = estimate(scene, scene.cameras[0], options, effort, 3);
  CHECK(area.mean > 0);
  CHECK(point.mean > 0);
  const double error = std::sqrt(whole.error * whole.error + area.error * area.error + point.error * point.error);
  CHECK(std::abs(whole.mean - area.mean - point.mean) <= student_t_quantile(0.01, effort.replicates - 1) * error);
  CHECK(error <= 0.01 * whole.mean);
}

TEST_CASE("path set: with only diffuse surfaces, Lambert-only secondary vertices change nothing") {
  const Scene scene = make_builtin_scene("room");
  PathSet set;
  set.max_bounces = 2;
  const double full = mean_with(scene, set);
  set.secondary_lambert_only = true;
  CHECK(mean_with(scene, set) == test::relative(full, 1e-5));
}

TEST_CASE("path set: a clamp bounds the indirect layer and only that") {
  const Scene scene = make_builtin_scene("cornell");
  PathIntegratorOptions options;
  options.path_set.max_bounces = 2;
  options.path_set.indirect_clamp = 0.01;
  TestRender render(scene, scene.cameras[0], options, 32);
  REQUIRE(render.integrator->iterate());
  Film film(32, 32);
  render.integrator->resolve(film);
  const auto largest = [&](const char* layer) {
    return *std::max_element(film.find(layer)->pixels.begin(), film.find(layer)->pixels.end());
  };
  CHECK(largest("indirect") <= 0.01f);
  CHECK(largest("indirect") > 0.f);
  CHECK(largest("direct") > 0.01f);
}

TEST_CASE("path set: without light-side delta events the light from mirrors to other surfaces is gone, and only that") {
  // An emitter that faces up lights a floor that faces up by way of a ceiling mirror only.
  Scene scene;
  scene.cameras.push_back(look_orthographic({0, 0.5f, 0}, {0, 0, 0}, 0.2f));
  SceneMaterial mirror;
  mirror.roughness = 0;
  add_horizontal(scene, 0, 0, 0, 1, 1, true, add_material(scene, lambert(0.5f)));
  add_horizontal(scene, 2, 0.1f, 0, 1, 1, true, add_material(scene, emitter(10)));
  add_horizontal(scene, 0, 1, 0, 10, 10, false, add_material(scene, mirror));
  PathSet set;
  CHECK(mean_with(scene, set) > 0);
  set.light_delta = false;
  CHECK(mean_with(scene, set) == 0);
  // The mirror itself, seen by the eye, still shows the emitter.
  scene.cameras[0] = look_orthographic({1, 0.5f, 0}, {1.5f, 1, 0}, 0.05f);
  CHECK(mean_with(scene, set) > 0);
  set.eye_deltas = 0;
  CHECK(mean_with(scene, set) == 0);
}

TEST_CASE("path set: delta events on the eye's side are followed up to their number") {
  // Between two mirrors that face each other a ray climbs to an emitter after three reflections.
  Scene scene;
  SceneMaterial mirror;
  mirror.roughness = 0;
  const int silver = add_material(scene, mirror);
  add_polygon(scene, {{0, -1, 1}, {0, -1, -1}, {0, 4, -1}, {0, 4, 1}}, silver);
  add_polygon(scene, {{1, -1, -1}, {1, -1, 1}, {1, 4, 1}, {1, 4, -1}}, silver);
  scene.materials[silver].double_sided = true;
  add_horizontal(scene, 0.5f, 3.5f, 0, 1, 2, false, add_material(scene, emitter(2)));
  scene.cameras.push_back(look_orthographic({0.5f, 0, 0}, {1, 0.5f, 0}, 0.02f));  // meets mirrors at y = 0.5, 1.5, 2.5
  PathSet set;
  for (const int events : {-1, 3, 4}) {
    set.eye_deltas = events;
    CHECK(mean_with(scene, set) > 0);
  }
  for (const int events : {0, 1, 2}) {
    set.eye_deltas = events;
    CHECK(mean_with(scene, set) == 0);
  }
  CHECK(PathSet::parse("eye_deltas=2").eye_deltas == 2);
  CHECK_THROWS_AS(PathSet::parse("eye_deltas=-2"), Error);
  CHECK_THROWS_AS(PathSet::parse("eye_deltas=4096"), Error);
}

TEST_CASE("path set: geometric normals change smooth surfaces and not flat ones") {
  Scene flat = make_builtin_scene("cornell");
  PathSet shading, geometric;
  shading.max_bounces = geometric.max_bounces = 1;
  geometric.geometric_normals = true;
  CHECK(mean_with(flat, geometric) == test::relative(mean_with(flat, shading), 1e-4));

  // One triangle whose vertex normals all lean to one side, lit along its true normal: cos 60 degrees against 1.
  Scene leaning;
  leaning.cameras.push_back(look_orthographic({0, 1, 0}, {0, 0, 0}, 0.1f));
  add_horizontal(leaning, 0, 0, 0, 2, 2, true, add_material(leaning, lambert(0.5f)));
  leaning.meshes[0].flat_normals = false;
  for (glm::vec3& normal : leaning.meshes[0].normals) normal = glm::normalize(glm::vec3(std::sqrt(3.f), 1, 0));
  add_light(leaning, LightType::directional, 1, {0, 1, 0}, {0, 0, 0});
  CHECK(mean_with(leaning, geometric) == test::relative(0.5 / M_PI, 1e-5));
  CHECK(mean_with(leaning, shading) == test::relative(0.25 / M_PI, 1e-5));
}

TEST_CASE("path set: BLEND surfaces can be taken as opaque") {
  // A plate of alpha 0.25 above an emitter: three quarters of it show, or nothing.
  Scene scene;
  scene.cameras.push_back(look_orthographic({0, 1, 0}, {0, 0, 0}, 0.2f));
  SceneMaterial plate = lambert(0);
  plate.alpha_mode = AlphaMode::blend;
  plate.base_color.w = 0.25f;
  plate.double_sided = true;
  add_horizontal(scene, 0, 0.5f, 0, 2, 2, true, add_material(scene, plate));
  add_horizontal(scene, 0, 0, 0, 2, 2, true, add_material(scene, emitter(1)));
  PathSet set;
  ClosedForms table;
  PathIntegratorOptions options;
  table.add("alpha 0.25",
            estimate(scene, scene.cameras.at(0), options, full_run() ? Effort{64, 16, 64} : Effort{32, 16, 16}), 0.75);
  table.check(2e-3);
  set.blend = false;
  CHECK(mean_with(scene, set) == 0);
}

TEST_CASE("path set: what changes nothing on a scene is left out, and the picture keeps its bits") {
  PathSet declared;
  declared.max_bounces = 2;
  declared.light_delta = declared.blend = declared.point_lights = declared.environment = false;
  declared.secondary_lambert_only = true;
  declared.eye_deltas = 0;
  PathSet all;
  all.max_bounces = 2;

  const Scene lambert = make_builtin_scene("cornell");
  CHECK(declared.simplified(lambert).to_string() == all.to_string());
  const auto picture = [](const Scene& scene, const PathSet& set) {
    PathIntegratorOptions options;
    options.path_set = set;
    TestRender render(scene, scene.cameras.at(0), options, 32);
    REQUIRE(render.integrator->iterate());
    Film film(32, 32);
    render.integrator->resolve(film);
    std::vector<float> pixels;
    for (const FilmLayer& layer : film.layers()) pixels.insert(pixels.end(), layer.pixels.begin(), layer.pixels.end());
    return pixels;
  };
  CHECK(picture(lambert, declared) == picture(lambert, all));

  // Each key stays where the scene has what it is about.
  const Scene mirror = make_builtin_scene("cornell-mirror");
  PathSet left = declared.simplified(mirror);
  CHECK(!left.light_delta);
  CHECK(left.eye_deltas == 0);
  CHECK(left.secondary_lambert_only);
  CHECK(left.blend);
  CHECK(picture(mirror, declared) == picture(mirror, left));
  CHECK(picture(mirror, declared) != picture(mirror, all));

  Scene odd = lambert;
  odd.materials[0].alpha_mode = AlphaMode::blend;
  odd.environment.emplace();
  odd.lights.emplace_back();
  left = declared.simplified(odd);
  CHECK(!left.blend);
  CHECK(!left.environment);
  CHECK(!left.point_lights);
  // A rough surface whose texture may make it a mirror.
  odd.materials[0].ior = 1.5f;
  odd.materials[0].metallic_roughness_texture.texture = 0;
  CHECK(!declared.simplified(odd).light_delta);

  declared.max_bounces = 0;
  declared.indirect = false;
  CHECK(declared.simplified(lambert).indirect);
  CHECK(!PathSet::no_light_transport().simplified(lambert).light_transport());
}
