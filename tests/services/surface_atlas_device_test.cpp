// SPDX-License-Identifier: Apache-2.0
// The atlas on the device: kernels find what the host finds, slots know their surface, refits follow.
#include <cmath>

#include "../analytic/closed_form.h"
#include "lucarium/base/error.h"
#include "lucarium/services/bvh.h"
#include "lucarium/services/direct_light.h"
#include "lucarium/services/gbuffer.h"
#include "lucarium/services/surface_atlas.h"
#include "lucarium/services/surface_atlas_image.h"
#include "lucarium/technique/technique.h"
#include "surface_atlas_support.h"
#include "tolerance.h"

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
    CHECK(glm::length(glm::dvec3(points[slot].position.xyz()) - point_on(g, t, texels[slot].b1, texels[slot].b2)) <
          1e-6);
    const bool back = slot >= k && slot < 2 * k;
    const glm::dvec3 n =
        glm::normalize(glm::cross(corner(g, t, 1) - corner(g, t, 0), corner(g, t, 2) - corner(g, t, 0)));
    CHECK(glm::dot(glm::dvec3(points[slot].normal.xyz()), n) == test::relative(back ? -1 : 1, 1e-5));
    const SceneMaterial& material = context.scene.materials[context.scene.instances[g.instance[t]].material];
    if (material.emits()) {
      CHECK(materials[slot].emission.x == test::relative(material.emissive_factor.x * material.emissive_strength));
    } else {
      CHECK(materials[slot].emission.x == 0.f);
      CHECK(materials[slot].diffuse.x == test::relative(material.base_color.x, 1e-4));
    }
  }
  CHECK(area == test::relative(side_area(g), 1e-6));
}

namespace {

/// Smooth over the scene: two waves of a fifth of its extent.
double wave(const glm::dvec3& p, double extent) {
  const double k = 2 * 3.14159265358979 / (0.2 * extent);
  return std::sin(k * (p.x + 0.4 * p.y + 0.3 * p.z)) + std::cos(k * (0.3 * p.x - 0.2 * p.y + p.z));
}

/// What kernels get between the slots' values at points of the fronts.
std::vector<float4> interpolate(AtlasContext& context, const std::vector<float4>& values, const Points& p) {
  const SurfaceAtlas& atlas = *context.atlas;
  Device& device = *atlas_device();
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

namespace {

/// Slots after a change of geometry lie on the triangles as they are now, and their areas sum to the surface's.
void check_follows(const AtlasContext& context) {
  const AtlasGeometry g = read_atlas_geometry(context.scene, context.buffers, false);
  const auto texels = context.atlas->texels().download();
  const auto points = context.atlas->surface_points().download();
  const auto ranges = context.atlas->ranges().download();
  const auto pieces = context.atlas->pieces().download();
  double area = 0;
  for (uint32_t slot = 0; slot < texels.size(); ++slot) {
    const uint32_t t = texels[slot].triangle;
    const glm::dvec3 exact = point_on(g, t, texels[slot].b1, texels[slot].b2);
    CHECK(glm::length(glm::dvec3(points[slot].position.xyz()) - exact) < 1e-5);
    const glm::dvec3 n = glm::cross(corner(g, t, 1) - corner(g, t, 0), corner(g, t, 2) - corner(g, t, 0));
    const uint32_t k = context.atlas->info().double_sided_count;
    const bool back = slot >= k && slot < 2 * k;
    CHECK(glm::dot(glm::dvec3(points[slot].normal.xyz()), glm::normalize(n)) ==
          test::relative(back ? -1 : 1, 1e-4));
    double expected = 0;
    for (uint32_t i = ranges[slot].x; i < ranges[slot].x + ranges[slot].y; ++i)
      expected += double(pieces[i].fraction) * area_of(g, pieces[i].triangle);
    CHECK(double(texels[slot].area) == test::relative(expected, 1e-4));
    area += double(texels[slot].area);
  }
  CHECK(area == test::relative(side_area(g), 1e-6));
}

}  // namespace

TEST_CASE("a rigid motion moves the slots and keeps their areas") {
  AtlasContext context(make_builtin_scene("cornell"), 4000);
  const auto before = context.atlas->texels().download();
  const uint64_t generation = context.atlas->generation();
  SceneChange change;
  for (int i = 0; i < int(context.scene.instances.size()); i += 2) {
    SceneInstance& instance = context.scene.instances[size_t(i)];
    change.moved_instances.push_back(i);
    change.previous_world_from_object.push_back(instance.world_from_object);
    instance.world_from_object =
        glm::rotate(glm::translate(glm::mat4(1), glm::vec3(0.3f, 1, -0.2f)), 0.7f, glm::normalize(glm::vec3(1, 2, 3))) *
        instance.world_from_object;
  }
  context.buffers.update(context.scene, change);
  context.atlas->refit(context.scene, change);
  CHECK(context.atlas->generation() == generation);
  check_follows(context);
  const auto after = context.atlas->texels().download();
  for (size_t i = 0; i < after.size(); ++i)
    CHECK(double(after[i].area) == test::relative(double(before[i].area), 1e-4));
}

TEST_CASE("a deformation: areas follow the triangles, and sum to what a rebuilt atlas has") {
  Scene scene = make_builtin_scene("furnace");
  for (SceneInstance& instance : scene.instances)
    instance.pose = std::make_shared<Mesh>(scene.meshes[size_t(instance.mesh)]);
  AtlasContext context(std::move(scene), 4000);
  SceneChange change;
  for (int i = 0; i < int(context.scene.instances.size()); ++i) {
    Mesh pose = *context.scene.instances[size_t(i)].pose;
    for (glm::vec3& p : pose.positions)
      p = glm::vec3(1.5f * p.x + 0.2f * std::sin(3 * p.y), p.y * (1 + 0.3f * p.x), 0.7f * p.z);
    context.scene.instances[size_t(i)].pose = std::make_shared<Mesh>(std::move(pose));
    change.deformed_instances.push_back(i);
  }
  context.buffers.update(context.scene, change);
  context.atlas->refit(context.scene, change);
  check_follows(context);
  const auto sum = [](const SurfaceAtlas& atlas) {
    double area = 0;
    for (const AtlasTexel& texel : atlas.texels().download()) area += double(texel.area);
    return area;
  };
  const SurfaceAtlas rebuilt(*atlas_device(), context.scheduler, context.scene, context.buffers, context.options,
                             "test");
  CHECK(sum(*context.atlas) == test::relative(sum(rebuilt), 1e-6));
}

TEST_CASE("a change of material is seen; one of its sides rebuilds") {
  AtlasContext context(make_builtin_scene("cornell"), 2000);
  SceneChange change;
  change.materials = {0};
  context.scene.materials[0].base_color = glm::vec4(0.25f, 0.5f, 0.75f, 1);
  context.scene.materials[0].ior = 1;
  context.buffers.update(context.scene, change);
  context.atlas->refit(context.scene, change);
  CHECK(context.atlas->generation() == 1);
  const auto slots_of_material = [&] {
    const AtlasGeometry g = read_atlas_geometry(context.scene, context.buffers, false);
    const auto texels = context.atlas->texels().download();
    const auto materials = context.atlas->materials().download();
    uint32_t count = 0;
    for (size_t slot = 0; slot < texels.size(); ++slot) {
      if (context.scene.instances[g.instance[texels[slot].triangle]].material != 0) continue;
      CHECK(materials[slot].diffuse.x == test::relative(0.25));
      CHECK(materials[slot].diffuse.z == test::relative(0.75));
      ++count;
    }
    return count;
  };
  const uint32_t before = slots_of_material();
  CHECK(before > 0);
  CHECK(context.atlas->info().double_sided_count == 0);
  context.scene.materials[0].double_sided = true;
  context.buffers.update(context.scene, change);
  context.atlas->refit(context.scene, change);
  CHECK(context.atlas->generation() == 2);
  CHECK(2 * context.atlas->info().double_sided_count == slots_of_material());
}

TEST_CASE("the sample positions are receivers for DirectLight") {
  // A closed room with one point light: where it is seen, E = I cos / d².
  AtlasContext context(make_builtin_scene("room"), 2000);
  const Bvh bvh(*atlas_device(), context.scene, context.buffers);
  DirectLight direct(*atlas_device(), context.scheduler, context.buffers, bvh, "test");
  const TypedBuffer<float4> sums(*atlas_device(), "test", "irradiance", context.atlas->info().texel_count);
  REQUIRE(direct.accumulate_irradiance(context.atlas->surface_points(), sums, 0, 1));
  context.scheduler.finish();
  REQUIRE(context.scene.lights.size() == 1);
  const glm::dvec3 light(context.scene.lights[0].world_from_light[3]);
  const auto points = context.atlas->surface_points().download();
  const auto irradiance = sums.download();
  uint32_t lit = 0;
  for (size_t slot = 0; slot < points.size(); ++slot) {
    const glm::dvec3 to = light - glm::dvec3(points[slot].position.xyz());
    const double d = glm::length(to), cosine = glm::dot(to, glm::dvec3(points[slot].normal.xyz())) / d;
    if (irradiance[slot].x == 0) continue;
    ++lit;
    CHECK(double(irradiance[slot].x) ==
          test::relative(double(context.scene.lights[0].intensity.x) * cosine / (d * d), 1e-3));
  }
  CHECK(lit > points.size() / 2);
}

TEST_CASE("the layer shows every texel in its colour") {
  AtlasContext context(make_builtin_scene("cornell"), 300);
  const Bvh bvh(*atlas_device(), context.scene, context.buffers);
  RenderSettings settings;
  settings.width = settings.height = 64;
  settings.pixel_sampling = LUCARIUM_PIXEL_CENTRE;
  settings.camera = context.scene.cameras.at(0);
  GBuffer gbuffer(*atlas_device(), context.scheduler, context.buffers, bvh, make_frame(settings), "test");
  REQUIRE(gbuffer.render(0));
  Film film(64, 64);
  context.atlas->resolve(gbuffer.points(), film);
  const FilmLayer* layer = film.find("atlas");
  REQUIRE(layer);
  const auto colors = context.atlas->slot_colors();
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

TEST_CASE("the packed picture has every texel") {
  Scene scene = make_builtin_scene("cornell");
  scene.materials[0].double_sided = true;
  AtlasContext context(std::move(scene), 3000);
  const SurfaceAtlasImage image(*context.atlas);
  const uint32_t slots = context.atlas->info().texel_count, k = context.atlas->info().double_sided_count;
  std::vector<float4> values;
  for (uint32_t slot = 0; slot < slots; ++slot) values.emplace_back(float(slot + 1), 0.f, 0.f, 0.f);
  Film film(image.width(), image.height());
  image.add_layer(film, "fronts", values);
  image.add_layer(film, "backs", values, true);
  std::vector<uint8_t> seen(slots + 1, 0);
  for (const char* name : {"fronts", "backs"})
    for (size_t i = 0; i < film.pixel_count(); ++i) seen[size_t(film.find(name)->pixels[3 * i])] = 1;
  for (uint32_t slot = 0; slot < slots; ++slot) CHECK(seen[slot + 1]);
  CHECK(k > 0);
  const Film drawn = image.draw(*context.atlas);
  for (const char* name : {"atlas", "Albedo", "Emission", "P", "N", "Area"}) CHECK(drawn.find(name));
}

TEST_CASE("memory: refused with numbers, estimated about right") {
  Scene scene = make_builtin_scene("cornell");
  AtlasContext context(scene, 100000);
  const double estimate = double(SurfaceAtlas::estimate_bytes(scene, context.options));
  CHECK(double(context.atlas->report().bytes) == test::relative(estimate, 0.2));
  SurfaceAtlasOptions by_edge;
  by_edge.texel_edge = context.atlas->report().texel_edge;
  CHECK(double(SurfaceAtlas::estimate_bytes(scene, by_edge)) == test::relative(estimate, 0.05));
  CHECK(context.atlas->report().slots == context.atlas->info().texel_count);
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
      CHECK(found[i].x == (at.x < 1 + 0.1 * double(gap) ? 0.f : 1.f));
      ++beside;
    }
    CHECK(beside > 500);
  }
}
