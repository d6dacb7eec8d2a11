// SPDX-License-Identifier: Apache-2.0
// The atlas on the device: kernels find what the host finds, texel sides know their surface, receive light and are
// drawn.
#include <cmath>

#include "context.h"
#include "lucarium/base/error.h"
#include "lucarium/scene/builtin/scenes.h"
#include "lucarium/services/bvh/bvh.h"
#include "lucarium/services/direct_light/direct_light.h"
#include "lucarium/services/gbuffer/gbuffer.h"
#include "lucarium/services/surface_atlas/image.h"
#include "lucarium/technique/technique.h"
#include "made_scene.h"
#include "tolerance.h"

using namespace lucarium;
using namespace lucarium::test;

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
  const auto fronts = test_buffer<uint32_t>(count), backs = test_buffer<uint32_t>(count);
  run_at(context, "look_up_atlas", p, [&](PassBuilder& pass) { pass.arg("fronts", fronts).arg("backs", backs); });
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

TEST_CASE("texel sides lie on their triangles and know what the surface does") {
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
  for (uint32_t side = 0; side < texels.size(); ++side) {
    area += double(texels[side].area);
    const uint32_t t = texels[side].triangle;
    CHECK(points[side].triangle == t);
    CHECK(glm::length(glm::dvec3(points[side].position.xyz()) - point_on(g, t, texels[side].b1, texels[side].b2)) <
          1e-6);
    const bool back = side >= k && side < 2 * k;
    const glm::dvec3 n =
        glm::normalize(glm::cross(corner(g, t, 1) - corner(g, t, 0), corner(g, t, 2) - corner(g, t, 0)));
    CHECK(glm::dot(glm::dvec3(points[side].normal.xyz()), n) == test::relative(back ? -1 : 1, 1e-5));
    const SceneMaterial& material = context.scene.materials[context.scene.instances[g.instance[t]].material];
    if (material.emits()) {
      CHECK(materials[side].emission.x == test::relative(material.emissive_factor.x * material.emissive_strength));
    } else {
      CHECK(materials[side].emission.x == 0.f);
      CHECK(materials[side].diffuse.x == test::relative(material.base_color.x, 1e-4));
    }
  }
  CHECK(area == test::relative(side_area(g), 1e-6));
}

TEST_CASE("the sides of a sheet know what is seen of them") {
  // A lamp of frosted plastic that shines on both sides, with normals that lean; and a polished volume of index 1.5
  // with some white in it, of which one side is inside.
  Scene scene;
  SceneMaterial lamp = emitter(3, 0.5f), glass = lambert(1);
  lamp.double_sided = true;
  lamp.ior = 1.5f;
  lamp.roughness = 0.5f;
  glass.ior = 1.5f;
  glass.roughness = 0;
  glass.transmission = 0.75f;
  glass.thickness = 1;
  add_horizontal(scene, 0, 0, 0, 1, 1, true, add_material(scene, lamp));
  const glm::vec3 leaning = glm::normalize(glm::vec3(0.3f, 1, 0));
  scene.meshes[0].flat_normals = false;
  scene.meshes[0].normals.assign(scene.meshes[0].positions.size(), leaning);
  add_horizontal(scene, 5, 0, 0, 1, 1, true, add_material(scene, glass));
  AtlasContext context(std::move(scene), 80);
  const uint32_t k = context.atlas->info().double_sided_count;
  const auto points = context.atlas->surface_points().download();
  const auto materials = context.atlas->materials().download();
  REQUIRE(2 * k == points.size());
  uint32_t lamps = 0, volumes = 0;
  for (uint32_t side = 0; side < 2 * k; ++side) {
    CAPTURE(side);
    const AtlasMaterial& m = materials[side];
    const bool back = side >= k;
    if (points[side].position.x < 2) {
      ++lamps;
      CHECK(m.emission.x == test::relative(3));
      CHECK(m.emission.w == 0);
      CHECK(m.diffuse.w == test::relative(0.25));
      CHECK(m.diffuse.x > 0.4f);
      CHECK(glm::distance(m.shading.xyz(), (back ? -1.f : 1.f) * leaning) < 1e-5f);
    } else {
      ++volumes;
      CHECK(m.emission.w == 1);
      CHECK(m.transmission.x == test::relative(0.75));
      CHECK(m.transmission.w == test::relative(back ? 1.5 : 1 / 1.5));
      const double outside = 0.25 * (1 - (0.04 * (1 - 1 / 21.) + 1 / 21.));
      CHECK(m.diffuse.x == test::relative(back ? outside / 2.25 : outside, 1e-4));
    }
  }
  CHECK(lamps == volumes);
}

TEST_CASE("the sample positions are receivers for DirectLight") {
  // A closed room with one point light: where it is seen, E = I cos / d².
  AtlasContext context(make_builtin_scene("room"), 2000);
  const Bvh bvh(*test_device(), context.scene, context.buffers);
  DirectLight direct(*test_device(), context.scheduler, context.buffers, bvh, "test");
  const TypedBuffer<float4> sums(*test_device(), "test", "irradiance", context.atlas->info().texel_count);
  REQUIRE(direct.accumulate_irradiance(context.atlas->surface_points(), sums, 0, 1));
  context.scheduler.finish();
  REQUIRE(context.scene.lights.size() == 1);
  const glm::dvec3 light(context.scene.lights[0].world_from_light[3]);
  const auto points = context.atlas->surface_points().download();
  const auto irradiance = sums.download();
  uint32_t lit = 0;
  for (size_t side = 0; side < points.size(); ++side) {
    const glm::dvec3 to = light - glm::dvec3(points[side].position.xyz());
    const double d = glm::length(to), cosine = glm::dot(to, glm::dvec3(points[side].normal.xyz())) / d;
    if (irradiance[side].x == 0) continue;
    ++lit;
    CHECK(double(irradiance[side].x) ==
          test::relative(double(context.scene.lights[0].intensity.x) * cosine / (d * d), 1e-3));
  }
  CHECK(lit > points.size() / 2);
}

TEST_CASE("the layer shows every texel in its colour") {
  AtlasContext context(make_builtin_scene("cornell"), 300);
  const Bvh bvh(*test_device(), context.scene, context.buffers);
  RenderSettings settings;
  settings.width = settings.height = 64;
  settings.pixel_sampling = LUCARIUM_PIXEL_CENTRE;
  settings.camera = context.scene.cameras.at(0);
  GBuffer gbuffer(*test_device(), context.scheduler, context.buffers, bvh, make_frame(settings), "test");
  REQUIRE(gbuffer.render(0));
  Film film(64, 64);
  context.atlas->resolve(gbuffer.points(), film);
  const FilmLayer* layer = film.find("atlas");
  REQUIRE(layer);
  const auto colors = context.atlas->side_colors();
  const auto records = context.atlas->triangles().download();
  const auto table = context.atlas->table().download();
  const auto points = gbuffer.points().download();
  for (size_t i = 0; i < points.size(); ++i) {
    float4 expected(0, 0, 0, 0);
    if (points[i].state == LUCARIUM_GBUFFER_SURFACE && points[i].normal.w == 0)
      expected = colors[table[atlas_cell(records[points[i].triangle], points[i].u, points[i].v)]];
    CHECK(layer->pixels[3 * i] == expected.x);
    CHECK(layer->pixels[3 * i + 2] == expected.z);
  }
}

TEST_CASE("the layer shows backs in the colours of backs") {
  Scene scene;
  SceneMaterial sheet = lambert(0.5f);
  sheet.double_sided = true;
  add_horizontal(scene, 0, 0, 0, 4, 4, false, add_material(scene, sheet));
  AtlasContext context(std::move(scene), 100);
  const Bvh bvh(*test_device(), context.scene, context.buffers);
  RenderSettings settings;
  settings.width = settings.height = 16;
  settings.pixel_sampling = LUCARIUM_PIXEL_CENTRE;
  settings.camera = look_orthographic({0, 3, 0}, {0, 0, 0}, 1);
  GBuffer gbuffer(*test_device(), context.scheduler, context.buffers, bvh, make_frame(settings), "test");
  REQUIRE(gbuffer.render(0));
  Film film(16, 16);
  context.atlas->resolve(gbuffer.points(), film);
  const auto colors = context.atlas->side_colors();
  const auto records = context.atlas->triangles().download();
  const auto table = context.atlas->table().download();
  const auto points = gbuffer.points().download();
  const uint32_t k = context.atlas->info().double_sided_count;
  for (size_t i = 0; i < points.size(); ++i) {
    const uint32_t front = table[atlas_cell(records[points[i].triangle], points[i].u, points[i].v)];
    CHECK(film.find("atlas")->pixels[3 * i + 1] == colors[front + k].y);
  }
}

TEST_CASE("the packed picture has every texel") {
  Scene scene = make_builtin_scene("cornell");
  scene.materials[0].double_sided = true;
  AtlasContext context(std::move(scene), 3000);
  const SurfaceAtlasImage image(*context.atlas);
  const uint32_t sides = context.atlas->info().texel_count, k = context.atlas->info().double_sided_count;
  std::vector<float4> values;
  for (uint32_t side = 0; side < sides; ++side) values.emplace_back(float(side + 1), 0.f, 0.f, 0.f);
  Film film(image.width(), image.height());
  image.add_layer(film, "fronts", values);
  image.add_layer(film, "backs", values, true);
  std::vector<uint8_t> seen(sides + 1, 0);
  for (const char* name : {"fronts", "backs"})
    for (size_t i = 0; i < film.pixel_count(); ++i) seen[size_t(film.find(name)->pixels[3 * i])] = 1;
  for (uint32_t side = 0; side < sides; ++side) CHECK(seen[side + 1]);
  CHECK(k > 0);
  const Film drawn = image.draw(*context.atlas);
  for (const char* name : {"atlas", "Albedo", "Emission", "P", "N", "Area"}) CHECK(drawn.find(name));
}

TEST_CASE("memory: refused with numbers, estimated at little more than it is") {
  Scene scene = make_builtin_scene("cornell");
  AtlasContext context(scene, 100000);
  const double bytes = double(context.atlas->report().bytes);
  const double expected = double(SurfaceAtlas::estimate_bytes(scene, context.options, 100000));
  CHECK(bytes == test::relative(expected, 0.2));
  const double bound = double(SurfaceAtlas::estimate_bytes(scene, context.options));
  CHECK(bytes <= bound);
  CHECK(bytes > 0.7 * bound);
  SurfaceAtlasOptions by_edge;
  by_edge.texel_edge = context.atlas->report().texel_edge;
  const double edges = SurfaceAtlas::estimate_edge(scene, context.options) / double(by_edge.texel_edge);
  const auto sides = static_cast<size_t>(100000 * edges * edges);  // area over a texel's
  CHECK(double(SurfaceAtlas::estimate_bytes(scene, by_edge, sides)) == test::relative(expected, 0.05));
  CHECK(bytes <= double(SurfaceAtlas::estimate_bytes(scene, by_edge)));
  CHECK(context.atlas->report().sides == context.atlas->info().texel_count);
  CHECK(context.atlas->report().area_p50 == test::relative(1, 0.05));
  DeviceOptions little;
  little.memory_limit_bytes = 10 << 20;
  const std::shared_ptr<Device> device = Device::open(little);
  KernelScheduler scheduler(device);
  const SceneBuffers buffers(*device, scene);
  SurfaceAtlasOptions absurd;
  absurd.texel_edge = 1e-9;
  for (const SurfaceAtlasOptions& options : {context.options, by_edge, absurd}) {
    try {
      const SurfaceAtlas atlas(*device, scheduler, scene, buffers, options, "test");
      FAIL("not refused");
    } catch (const Error& error) {
      CHECK(error.error_class() == ErrorClass::device);
      CHECK(std::string(error.what()).find("fewer atlas texels") != std::string::npos);
    }
  }
}
