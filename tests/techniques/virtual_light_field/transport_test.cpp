// SPDX-License-Identifier: Apache-2.0
// Transport along lines, as sums over rays without normalisation: what one sends the other receives, nothing is lost,
// light adds up, and rays of subfields meet what rays meet.
//
// A ray of a subfield stands for A_p ΔΩ of the measure of lines, A_p the area of its pixel. It meets two places a and b
// and carries L_a A_p ΔΩ from a to b and L_b A_p ΔΩ back. With W_t = Σ ΔΩ over the rays of side t, and S_t = Σ ΔΩ L
// what they bring, both without factors A_p, and K the linear map from what sides send to what they receive, S = K L:
//
//   Σ_t y_t (K x)_t = Σ_t x_t (K y)_t           each ray that counts for (a, b) counts for (b, a)
//   Σ_t L_t W_t = Σ_t S_t + Σ_t L_t (W_t - (K 1)_t)      sent = received + what meets neither side: sky and backs
//   E_t = A_p S_t / A_t                          irradiance without its normalisation Σ W
#include <doctest/doctest.h>

#include <cmath>
#include <cstring>
#include <random>

#include "field_rig.h"
#include "lucarium/base/numbers.h"
#include "lucarium/compute/program/source_library.h"
#include "lucarium/shared/hash.h"
#include "test_support.h"
#include "tolerance.h"

const lucarium::EmbeddedSources& test_virtual_light_field_kernels();

using namespace lucarium;
using test::relative;
using test::within;

namespace {

vlf::Parameters plain(int dir_n, int cells, int texels) {
  vlf::Parameters parameters;
  parameters.dir_n = dir_n;
  parameters.cells = cells;
  parameters.texels = texels;
  parameters.direct_mode = vlf::DirectMode::exchange;
  parameters.access_gap = 0;  // a = 1
  return parameters;
}

/// Both sides of a box with a block and a slanted sheet in it, each wall a material of its own; one wall is missing, so
/// that light escapes.
Scene uneven_room(const std::vector<float>& radiance) {
  std::vector<std::pair<int, SceneMaterial>> walls;
  const auto material = [&](size_t i) {
    SceneMaterial made = test::emitter(radiance[i]);
    made.double_sided = true;
    return made;
  };
  for (int wall = 0; wall < 5; ++wall) walls.emplace_back(wall, material(static_cast<size_t>(wall)));
  Scene scene = test::unit_box(walls);
  test::add_box(scene, {0.2f, 0, 0.3f}, {0.5f, 0.6f, 0.7f}, false, test::add_material(scene, material(5)));
  test::add_polygon(scene, {{0.6f, 0.2f, 0.2f}, {0.9f, 0.3f, 0.2f}, {0.9f, 0.8f, 0.8f}, {0.6f, 0.7f, 0.8f}},
                    test::add_material(scene, material(6)));
  return scene;
}
constexpr size_t kParts = 7 + 5;  // instances: walls, faces of the block, sheet

struct Sums {
  std::vector<double> weight, light;  ///< W and S of each side
  std::vector<uint32_t> instance;
};

Sums transported(Scene scene, const vlf::Parameters& parameters) {
  test::FieldRig rig(std::move(scene), parameters, {.max_bounces = 1});
  rig.propagate(1);  // what a sweep has brought is given up when all is done
  Sums sums;
  for (const float4& side : rig.field().last().download()) {
    sums.weight.push_back(static_cast<double>(side.w));
    sums.light.push_back(static_cast<double>(side.x) * static_cast<double>(side.w));
  }
  sums.instance = rig.instances();
  return sums;
}

/// What each instance sends, by the material of its place.
double radiance_of(uint32_t instance, const std::vector<float>& radiance) {
  return static_cast<double>(radiance[instance < 5 ? instance : instance + 1 == kParts ? 6 : 5]);
}

double inner(const Sums& received, const std::vector<float>& sent) {
  double sum = 0;
  for (size_t side = 0; side < received.light.size(); ++side)
    sum += received.light[side] * radiance_of(received.instance[side], sent);
  return sum;
}

}  // namespace

TEST_CASE("what one side sends another, that side sends back: pair counts are symmetric") {
  const vlf::Parameters parameters = plain(4, 48, 1024);
  const std::vector<std::vector<float>> vectors = {
      {1, 0, 0, 0, 0, 0, 0}, {0, 0, 1, 0, 0, 0, 0}, {0, 0, 0, 0, 0, 0, 1}, {3, 1, 4, 1, 5, 9, 2}};
  std::vector<Sums> received;
  for (const std::vector<float>& vector : vectors) received.push_back(transported(uneven_room(vector), parameters));
  for (size_t a = 0; a < vectors.size(); ++a)
    for (size_t b = 0; b < a; ++b) {
      CAPTURE(a);
      CAPTURE(b);
      CHECK(inner(received[a], vectors[b]) > 0);
      CHECK(inner(received[a], vectors[b]) == relative(inner(received[b], vectors[a]), 1e-5));
    }
}

TEST_CASE("what is sent is received, or escapes: nothing is lost on the way") {
  const vlf::Parameters parameters = plain(4, 48, 1024);
  const std::vector<float> light = {3, 1, 4, 1, 5, 9, 2};
  const Sums lit = transported(uneven_room(light), parameters);
  // With no light but a sky of radiance 1 each side receives Σ ΔΩ over its rays that end there: so many escape.
  Scene dark = uneven_room(std::vector<float>(7, 0.f));
  Environment sky;
  sky.width = sky.height = 4;
  sky.radiance.assign(16, glm::vec3(1));
  dark.environment = sky;
  const Sums open = transported(std::move(dark), parameters);
  double sent = 0, received = 0, escaped = 0;
  for (size_t side = 0; side < lit.light.size(); ++side) {
    const double radiance = radiance_of(lit.instance[side], light);
    sent += radiance * lit.weight[side];
    received += lit.light[side];
    escaped += radiance * open.light[side];
  }
  MESSAGE("sent ", sent, ", received ", received, ", escaped ", escaped);
  CHECK(escaped > 0.05 * sent);
  CHECK(received + escaped == relative(sent, 1e-5));
}

TEST_CASE("what falls on backs of single-sided surfaces is absorbed there, and only that is missing") {
  // A lamp below faces up to the black back of a sheet that covers it whole, at distance 1: of what the lamp sends the
  // form factor of parallel unit squares, 0.199825, meets the sheet, the rest the sky.
  Scene scene = test::unit_box({{2, test::emitter(1)}});
  test::add_polygon(scene, {{0, 1, 0}, {0, 1, 1}, {1, 1, 1}, {1, 1, 0}}, test::add_material(scene, test::lambert(0.5)));
  Environment sky;
  sky.width = sky.height = 4;
  sky.radiance.assign(16, glm::vec3(1));
  scene.environment = sky;
  test::FieldRig rig(std::move(scene), plain(16, 64, 2048), {.max_bounces = 0});
  rig.propagate();
  CHECK(rig.mean(rig.direct(), 0) == relative(1 - 0.199825, 0.005));
  CHECK(rig.mean(rig.direct(), 1) == relative(1, 1e-5));
}

TEST_CASE("two unit squares have their form factors without normalisation, too") {
  // E / pi of the receiver, its mean over the square: A_p Σ_t S_t / (pi A).
  for (const bool parallel : {true, false}) {
    CAPTURE(parallel);
    const SceneMaterial lamp = test::emitter(1), black = test::lambert(0);
    test::FieldRig rig(test::unit_box({{2, black}, {parallel ? 3 : 0, lamp}}),
                       plain(test::full_run() ? 32 : 16, 64, 4096), {.max_bounces = 1});
    rig.propagate(1);
    const double pixel = rig.surfaces().subfield.pixel();
    const std::vector<float4> last = rig.field().last().download();
    const std::vector<uint32_t> instances = rig.instances();
    double light = 0, weight = 0;
    for (size_t side = 0; side < last.size(); ++side) {
      if (instances[side] != 0) continue;
      light += static_cast<double>(last[side].x) * static_cast<double>(last[side].w);
      weight += static_cast<double>(last[side].w);
    }
    const double found = light * pixel * pixel / pi;
    MESSAGE("form factor ", found);
    CHECK(found == relative(parallel ? 0.199825 : 0.200044, 0.01));
    // The rays themselves: Σ ΔΩ cos = pi, to the quadrature's error.
    CHECK(weight * pixel * pixel == relative(pi, 0.005));
  }
}

TEST_CASE("fields of two lamps add up to that of both, in texels and in cells") {
  const SceneMaterial grey = test::lambert(0.5f);
  const auto rig_of = [&](float left, float right) {
    auto rig = std::make_unique<test::FieldRig>(test::unit_box({{0, test::emitter(left, 0.3f)},
                                                                {1, test::mirror(0.9f)},
                                                                {2, grey},
                                                                {3, test::emitter(right, 0.5f)},
                                                                {4, grey},
                                                                {5, test::mirror(0.7f, 0.4f)}}),
                                                plain(4, 32, 1024), test::FieldRig::Options{.max_bounces = 2});
    rig->propagate();
    return rig;
  };
  const auto one = rig_of(1, 0), other = rig_of(0, 3), both = rig_of(1, 3);
  const std::vector<double> a = one->all(), b = other->all(), sum = both->all();
  double texels = 0;
  for (size_t side = 0; side < sum.size(); ++side) texels = std::max(texels, std::abs(a[side] + b[side] - sum[side]));
  CHECK(both->mean(sum, 2) > 0.5);
  // Each cell is rounded to 9 bits, a share of 1/512 of it at most and of its mean nothing: means over hundreds of
  // cells are what texels hold.
  CHECK(texels < 1e-3 * both->mean(sum, 2));
  const std::vector<double> cells_a = one->cells(), cells_b = other->cells(), cells = both->cells();
  double worst = 0, mean = 0, total = 0;
  for (size_t cell = 0; cell < cells.size(); ++cell) {
    worst = std::max(worst, std::abs(cells_a[cell] + cells_b[cell] - cells[cell]));
    mean += cells_a[cell] + cells_b[cell] - cells[cell];
    total += cells[cell];
  }
  MESSAGE("texels ", texels, ", cells ", worst, ", mean ", mean / total);
  CHECK(total > 0);
  CHECK(std::abs(mean) < 1e-4 * total);
  // Three sweeps, each rounded in and out, and once in the total: seven roundings of values up to 4.
  CHECK(worst < 7 * 4. / 512);
}

namespace {

/// What the pixels of a line's subfield meet, rasterized: per pixel the number of fragments and their hash.
std::vector<uint32_t> rasterized(test::FieldRig& rig, const LayeredView& view) {
  SourceLibrary library;
  library.add(test_virtual_light_field_kernels());
  const Program program(rig.device(), library,
                        {"test_virtual_light_field/subfield_rays",
                         {"test_virtual_light_field/subfield_rays.cl"},
                         rig.surfaces().raster.defines()});
  const TypedBuffer<LayeredView> views(rig.device(), "test", "views", std::vector<LayeredView>{view});
  const TypedBuffer<uint32_t> sums(rig.device(), "test", "sums",
                                   std::vector<uint32_t>(size_t{2} * view.width * view.height, 0));
  ScheduleRecorder recorder = rig.scheduler().record("subfield rays", "test");
  rig.surfaces().raster.record_tiles(recorder, "subfield rays", {views, recorder.variable("view", 0u)}, program,
                                     "sum_rays", [&](PassBuilder& pass) { pass.arg("sums", sums); });
  Schedule schedule = recorder.compile();
  rig.scheduler().run(schedule);
  rig.scheduler().finish();
  return sums.download();
}

/// The same by rays of the hierarchy, which go on behind each hit.
std::vector<uint32_t> traced(test::FieldRig& rig, std::vector<Ray> rays) {
  std::vector<uint32_t> sums(2 * rays.size(), 0);
  const std::vector<Vertex> vertices = rig.buffers().scene_vertices.download();
  const std::vector<Triangle> triangles = rig.buffers().scene_triangles.download();
  const auto towards = [&](uint32_t t, const glm::vec3& d) {
    const glm::dvec3 a = vertices[triangles[t].v0].position.xyz(), b = vertices[triangles[t].v1].position.xyz(),
                     c = vertices[triangles[t].v2].position.xyz();
    return glm::dot(glm::cross(b - a, c - a), glm::dvec3(d)) > 0;
  };
  const float step = 1e-5f * rig.scene().bounds().radius();
  const auto count = static_cast<uint32_t>(rays.size());
  const TypedBuffer<Hit> hits(rig.device(), "test", "hits", rays.size());
  const TypedBuffer<uint32_t> counter(rig.device(), "test", "counter", std::vector<uint32_t>{count});
  for (bool any = true; any;) {
    any = false;
    const TypedBuffer<Ray> buffer(rig.device(), "test", "rays", rays);
    ScheduleRecorder recorder = rig.scheduler().record("trace", "test");
    rig.bvh().record_closest(recorder, "closest", {buffer, counter, 0, count, {}}, hits);
    Schedule schedule = recorder.compile();
    rig.scheduler().run(schedule);
    rig.scheduler().finish();
    const std::vector<Hit> found = hits.download();
    for (size_t i = 0; i < rays.size(); ++i) {
      if (found[i].triangle == LUCARIUM_NO_HIT) {
        rays[i].direction.w = -1;
        continue;
      }
      any = true;
      const glm::vec3 d = rays[i].direction.xyz();
      const uint32_t id = found[i].triangle | (towards(found[i].triangle, d) ? LAYERED_AWAY : 0);
      sums[2 * i + 1] += hash_uint2(id, sums[2 * i]);
      sums[2 * i] += 1;
      const glm::vec3 next = glm::vec3(rays[i].origin.xyz()) + (found[i].distance + step) * d;
      rays[i].origin = float4(next, rays[i].origin.w);
    }
  }
  return sums;
}

/// Distance of a point from the nearest edge of any triangle on the subfield [pixels].
double edge_distance(const std::vector<glm::dvec2>& corners, const glm::dvec2& p) {
  double nearest = 1e30;
  for (size_t i = 0; i < corners.size(); i += 3)
    for (size_t k = 0; k < 3; ++k) {
      const glm::dvec2 a = corners[i + k], edge = corners[i + (k + 1) % 3] - a;
      const double square = glm::dot(edge, edge);
      const double t = square > 0 ? std::clamp(glm::dot(p - a, edge) / square, 0., 1.) : 0;
      nearest = std::min(nearest, glm::length(a + t * edge - p));
    }
  return nearest;
}

}  // namespace

TEST_CASE("rays of subfields meet what rays of the hierarchy meet, but beside edges") {
  uint64_t rays_cast = 0, different = 0;
  // Nothing in it coincides with anything else: which of two surfaces in one place comes first is no question of rays.
  const SceneMaterial grey = test::lambert(0.5f);
  Scene scene = test::unit_box({{0, grey}, {1, grey}, {2, grey}, {3, grey}, {4, grey}});
  const int material = test::add_material(scene, grey);
  test::add_box(scene, {0.2f, 0.1f, 0.3f}, {0.5f, 0.6f, 0.7f}, false, material);
  test::add_polygon(scene, {{0.6f, 0.2f, 0.2f}, {0.9f, 0.3f, 0.2f}, {0.9f, 0.8f, 0.8f}, {0.6f, 0.7f, 0.8f}}, material);
  test::add_triangles(scene, test::sphere_triangles({0.7f, 0.75f, 0.3f}, 0.2f, 3, false), material);
  vlf::Parameters parameters = plain(2, 64, 1024);
  parameters.supersample = vlf::Supersample::two;
  test::FieldRig rig(std::move(scene), parameters, {.max_bounces = 0});
  const std::vector<Vertex> vertices = rig.buffers().scene_vertices.download();
  const std::vector<Triangle> triangles =
      rig.buffers().scene_triangles.download(0, rig.buffers().info().triangle_count);
  constexpr uint32_t pixels = 2;  // per cell and axis
  for (const size_t index : {0u, 1u, 2u, 3u, 4u, 5u, 6u, 7u}) {
    const FieldLine line = rig.field().maps().host_lines().at(index);
    const auto times = [&](const float4& row) {
      return float4(row.x * pixels, row.y * pixels, row.z * pixels, row.w * pixels);
    };
    const double cell = rig.surfaces().subfield.cell,
                 radius = 1.01 * static_cast<double>(rig.scene().bounds().radius());
    LayeredView view{};
    view.row_x = times(line.row_x);
    view.row_y = times(line.row_y);
    view.row_w = line.row_w;
    view.depth_min = static_cast<float>(-radius);
    view.depth_scale = static_cast<float>(0.5 / radius);
    view.width = view.height = rig.surfaces().subfield.cells * pixels;
    // p = x s + y t + ω d with (s, t) the subfield's metres and d the depth.
    const glm::dvec3 x = glm::dvec3(glm::vec3(line.row_x.xyz())) * cell,
                     y = glm::dvec3(glm::vec3(line.row_y.xyz())) * cell, omega(glm::vec3(line.omega.xyz()));
    std::vector<Ray> rays;
    for (uint32_t j = 0; j < view.height; ++j)
      for (uint32_t i = 0; i < view.width; ++i) {
        const double s = ((i + 0.5) / pixels - static_cast<double>(line.row_x.w)) * cell,
                     t = ((j + 0.5) / pixels - static_cast<double>(line.row_y.w)) * cell,
                     depth = -radius - static_cast<double>(line.row_w.w);
        Ray ray;
        ray.origin = float4(glm::vec3(x * s + y * t + omega * depth), 0.f);
        ray.direction = float4(glm::vec3(omega), std::numeric_limits<float>::infinity());
        rays.push_back(ray);
      }
    std::vector<glm::dvec2> corners;
    for (const Triangle& t : triangles)
      for (const uint32_t v : {t.v0, t.v1, t.v2}) {
        const glm::dvec3 p(glm::vec3(vertices[v].position.xyz()));
        const auto at = [&](const float4& row) {
          return glm::dot(glm::dvec3(glm::vec3(row.xyz())), p) + static_cast<double>(row.w);
        };
        corners.emplace_back(at(view.row_x), at(view.row_y));
      }
    const std::vector<uint32_t> found = rasterized(rig, view), expected = traced(rig, rays);
    for (uint32_t pixel = 0; pixel < rays.size(); ++pixel) {
      ++rays_cast;
      if (found[2 * pixel] == expected[2 * pixel] && found[2 * pixel + 1] == expected[2 * pixel + 1]) continue;
      ++different;
      CAPTURE(pixel);
      CHECK(edge_distance(corners, {pixel % view.width + 0.5, pixel / view.width + 0.5}) < 1. / 256);
    }
  }
  MESSAGE(rays_cast, " rays, ", different, " of them meet something else beside an edge");
  CHECK(rays_cast > 100000);
  CHECK(different < rays_cast / 1000);
}
