// SPDX-License-Identifier: Apache-2.0
// LightAtPoints at single points: lamps that nearly touch them, and light inside of coloured volumes.
#include "lucarium/services/light_at_points/light_at_points.h"

#include <doctest/doctest.h>

#include <bit>
#include <cmath>
#include <numbers>
#include <random>

#include "device_fixture.h"
#include "lucarium/base/error.h"
#include "lucarium/base/numbers.h"
#include "lucarium/compute/program/source_library.h"
#include "lucarium/scene/builtin/builder.h"
#include "lucarium/services/bvh/bvh.h"
#include "lucarium/services/light_paths/light_paths.h"
#include "lucarium/shared/light_tree.h"
#include "lucarium/shared/surface_point.h"
#include "made_scene.h"
#include "test_support.h"
#include "tolerance.h"

const lucarium::EmbeddedSources& test_services_kernels();

using namespace lucarium;
using namespace lucarium::test;

namespace {

/// The middle of a horizontal rectangle that a scene begins with: that of its first triangle's longest side, from its
/// first to its third corner.
SurfacePoint middle(float y) {
  SurfacePoint point{};
  point.position = float4(0, y, 0, 0);
  point.normal = float4(0, 1, 0, 0);
  point.v = 0.5f;
  return point;
}

/// Points in a scene.
struct PointRig {
  PointRig(Scene s, const SurfacePoint& point, uint32_t copies, const std::string& kernels = "photon_points")
      : PointRig(std::move(s), std::vector<SurfacePoint>(copies, point), kernels) {}
  PointRig(Scene s, const std::vector<SurfacePoint>& list, const std::string& kernels = "photon_points")
      : scene(std::move(s)),
        buffers(*test_device(), scene),
        bvh(*test_device(), scene, buffers),
        scheduler(test_device()),
        points(*test_device(), "test", "points", list),
        sums(*test_device(), "test", "sums", list.size()),
        program(make_program(kernels)),
        light(
            *test_device(), buffers, bvh, program, static_cast<uint32_t>(list.size()),
            [this](PassBuilder& pass) { pass.arg("points", points); }, "test", "use fewer points") {}

  static Program make_program(const std::string& kernels) {
    SourceLibrary library;
    library.add(test_services_kernels());
    return Program(*test_device(), library, {"test/" + kernels, {"test_services/" + kernels + ".cl"}, {}});
  }
  LightAtPoints::Bind bind_sums() {
    return [this](PassBuilder& pass) { pass.arg("irradiance", sums); };
  }
  std::vector<float4> run(Schedule& schedule) {
    sums.fill_zero();
    REQUIRE(scheduler.run(schedule) == RunResult::done);
    scheduler.finish();
    return sums.download();
  }
  /// Single samples of the light at the points, `samples` of each [lx].
  std::vector<double> samples(uint32_t samples, uint32_t seed_value = 1) {
    ScheduleRecorder recorder = scheduler.record("direct light", "test");
    const Variable<uint32_t> sample = recorder.variable("sample", 0u), seed = recorder.variable("seed", seed_value);
    light.record_samples(recorder, sample, seed, bind_sums());
    Schedule schedule = recorder.compile();
    std::vector<double> all;
    for (uint32_t k = 0; k < samples; ++k) {
      schedule.set(sample, k);
      for (const float4& e : run(schedule)) {
        CHECK(e.w == 1);
        all.push_back(double{e.y});
      }
    }
    return all;
  }

  Scene scene;
  SceneBuffers buffers;
  Bvh bvh;
  KernelScheduler scheduler;
  TypedBuffer<SurfacePoint> points;
  TypedBuffer<float4> sums;
  Program program;
  LightAtPoints light;
};

struct Spread {
  double mean = 0, variance = 0, largest = 0;
};
Spread spread(const std::vector<double>& values) {
  Spread result;
  for (const double v : values) {
    result.mean += v / static_cast<double>(values.size());
    result.largest = std::max(result.largest, v);
  }
  for (const double v : values)
    result.variance += (v - result.mean) * (v - result.mean) / static_cast<double>(values.size());
  return result;
}

}  // namespace

TEST_CASE("a lamp that nearly touches a point: no sample of it brings more than its radiance allows") {
  // A square lamp of half side a, height h above the point: E = pi L F, and F from four corner rectangles. Light
  // samples alone would bring up to L A / h^2 = 2500 L, and have a variance of L^2 A / 3 h^2 = 800 L^2.
  const double a = 0.5, h = 0.02, x = a / h, root = std::sqrt(1 + x * x);
  const double expected = pi * 4 / (2 * pi) * 2 * (x / root) * std::atan(x / root);
  Scene scene;
  add_horizontal(scene, 0, 0, 0, 4, 4, true, add_material(scene, lambert(0.5f)));
  add_horizontal(scene, 0, static_cast<float>(h), 0, 1, 1, false, add_material(scene, emitter(1)));
  PointRig rig(std::move(scene), middle(0), 1024);
  const std::vector<double> one = rig.samples(16, 1), other = rig.samples(16, 2);
  for (const std::vector<double>* samples : {&one, &other}) {
    const Spread found = spread(*samples);
    MESSAGE(found.mean, " of ", expected, ", variance ", found.variance, ", at most ", found.largest);
    CHECK(found.mean == test::relative(expected, 0.01));
    CHECK(found.largest <= 1.5 * pi * 1.0001);
    CHECK(found.variance < 1);
    // Points and samples are apart: means over 16 samples of a point, and over 1024 points of a sample.
    std::vector<double> of_points(1024), of_samples(16);
    for (size_t i = 0; i < samples->size(); ++i) {
      of_points[i % 1024] += (*samples)[i] / 16;
      of_samples[i / 1024] += (*samples)[i] / 1024;
    }
    CHECK(spread(of_points).variance < 2 * found.variance / 16);
    CHECK(spread(of_samples).variance < 4 * found.variance / 1024);
  }
}

TEST_CASE("a small portal a centimetre away, a lamp elsewhere: samples of both are bounded, and no light is lost") {
  // The portal has a fortieth of the samples for each triangle, since the lamp has the power: L A / P h^2 would be
  // 2000 L. It begins above the point, hides the half of the lamp beyond, and each is two corner rectangles.
  const auto corner = [](double a, double b, double height) {  // E of radiance 1
    const double x = a / height, y = b / height, rx = std::sqrt(1 + x * x), ry = std::sqrt(1 + y * y);
    return 0.5 * (x / rx * std::atan(y / rx) + y / ry * std::atan(x / ry));
  };
  const double portal = 3, lamp = 20;
  Scene scene;
  add_horizontal(scene, 0, 0, 0, 10, 10, true, add_material(scene, lambert(0.5f)));
  add_horizontal(scene, 0.05f, 0.01f, 0, 0.1f, 0.1f, false, add_material(scene, emitter(static_cast<float>(portal))));
  add_horizontal(scene, 0, 3, 0, 4, 4, false, add_material(scene, emitter(static_cast<float>(lamp))));
  const double expected = portal * 2 * corner(0.1, 0.05, 0.01) + lamp * 2 * corner(2, 2, 3);
  PointRig rig(std::move(scene), middle(0), 1024);
  for (const uint32_t seed : {1u, 2u}) {
    const Spread found = spread(rig.samples(16, seed));
    MESSAGE(found.mean, " of ", expected, ", variance ", found.variance, ", at most ", found.largest);
    CHECK(found.mean == test::relative(expected, 0.02));
    CHECK(found.largest <= 2 * pi * lamp * 1.0001);
    CHECK(found.variance < expected * expected);
  }
}

TEST_CASE("a lamp of many pieces close above a point, of which a tree chooses: no light is lost or found twice") {
  // 5 x 5 squares of 0.4 m at a height of 0.15 m are one of 2 m: four corner rectangles of 1 m.
  const double side = 1, height = 0.15, x = side / height, root = std::sqrt(1 + x * x);
  const double expected = 4 * x / root * std::atan(x / root);
  Scene scene;
  add_horizontal(scene, 0, 0, 0, 4, 4, true, add_material(scene, lambert(0.5f)));
  const int material = add_material(scene, emitter(1));
  for (int i = 0; i < 25; ++i)
    add_horizontal(scene, 0.4f * static_cast<float>(i % 5 - 2), 0.15f, 0.4f * static_cast<float>(i / 5 - 2), 0.4f, 0.4f,
                   false, material);
  PointRig rig(std::move(scene), middle(0), 1024);
  REQUIRE(rig.buffers.scene_light_trees.download()[LUCARIUM_LIGHT_TREES_KINDS] != 0);
  for (const uint32_t seed : {1u, 2u}) {
    const Spread found = spread(rig.samples(16, seed));
    MESSAGE(found.mean, " of ", expected, ", variance ", found.variance, ", at most ", found.largest);
    CHECK(found.mean == test::relative(expected, 0.01));
    CHECK(found.largest <= 2 * expected);  // what a tree chooses brings about what all lights do together
  }
}

TEST_CASE("a point light above points: every sample brings its illuminance") {
  Scene scene;
  add_horizontal(scene, 0, 0, 0, 4, 4, true, add_material(scene, lambert(0.5f)));
  add_light(scene, LightType::point, 3, {0, 2, 0}, {0, 0, 0});
  PointRig rig(std::move(scene), middle(0), 4);
  for (const double e : rig.samples(2)) CHECK(e == test::relative(3. / 4, 1e-4));
}

TEST_CASE("virtual lights within a tinted block: its walls get what the way has left") {
  // Attenuation (1/4, 1/2, 1) over 1 m, the way from a light to the block's bottom; that of a light without a block.
  const auto scene = [](bool block) {
    Scene result;
    SceneMaterial glass = lambert(1);
    glass.roughness = 0;
    glass.transmission = glass.thickness = 1;
    glass.attenuation_distance = 1;
    glass.attenuation_color = glm::vec3(0.25f, 0.5f, 1);
    const int floor = add_material(result, block ? glass : lambert(0.5f));
    add_horizontal(result, 0, 0, 0, 4, 4, !block, floor);
    if (block) add_horizontal(result, 0, 2, 0, 4, 4, true, floor);
    return result;
  };
  for (const bool block : {false, true}) {
    CAPTURE(block);
    PointRig rig(scene(block), middle(0), 4);
    VirtualLight above{};  // looks down, (0, -1, 0) as pack_direction has it
    above.position = float4(0, 1, 0, std::bit_cast<float>(32767u));
    above.flux = float4(5, 5, 5, std::bit_cast<float>(32767u));
    const TypedBuffer<VirtualLight> lights(*test_device(), "test", "lights", std::vector<VirtualLight>{above});
    ScheduleRecorder recorder = rig.scheduler.record("virtual light", "test");
    const Variable<uint32_t> index = recorder.variable("light", 0u), seed = recorder.variable("seed", 1u);
    const Variable<float> bound = recorder.variable("bound", 1e30f);
    rig.light.record_virtual_light(recorder, lights, index, seed, bound, rig.bind_sums());
    Schedule schedule = recorder.compile();
    for (const float4& e : rig.run(schedule)) {
      CHECK(e.x == test::relative(5 / pi * (block ? 0.25 : 1), 1e-3));
      CHECK(e.y == test::relative(5 / pi * (block ? 0.5 : 1), 1e-3));
      CHECK(e.z == test::relative(5 / pi, 1e-3));
    }
  }
}

namespace {

/// pack_direction of packing.clh.
uint32_t packed(const glm::vec3& n) {
  glm::vec2 p = glm::vec2(n) / (std::abs(n.x) + std::abs(n.y) + std::abs(n.z));
  if (n.z < 0) p = {std::copysign(1 - std::abs(p.y), p.x), std::copysign(1 - std::abs(p.x), p.y)};
  const auto steps = [](float x) { return static_cast<uint32_t>(std::lround((x + 1) * 32767)); };
  return steps(p.x) | steps(p.y) << 16;
}

}  // namespace

TEST_CASE("photons at known distances: the disc reaches to the last that is asked for, which brings nothing") {
  // Seven photons of flux 1 to 7 about the point, 0.1 to 0.7 m from it; 1 m is looked at.
  Scene scene;
  add_horizontal(scene, 0, 0, 0, 4, 4, true, add_material(scene, lambert(0.5f)));
  std::vector<VirtualLight> list;
  for (int k = 1; k <= 7; ++k) {
    const auto flux = static_cast<float>(k);
    VirtualLight photon{};
    const float up = std::bit_cast<float>(packed({0, 1, 0}));
    photon.position = float4(0.1f * flux * std::cos(flux), 0, 0.1f * flux * std::sin(flux), up);
    photon.flux = float4(flux, flux, flux, up);
    list.push_back(photon);
  }
  PointRig rig(std::move(scene), middle(0), 4);
  const TypedBuffer<VirtualLight> photons(*test_device(), "test", "photons", list);
  for (const auto& [nearest, expected] : {std::pair{4u, (1 + 2 + 3) / (pi * 0.16)}, {32u, 28 / pi}}) {
    CAPTURE(nearest);
    ScheduleRecorder recorder = rig.scheduler.record("density", "test");
    const Variable<float> cell = recorder.variable("cell", 1.f);
    rig.light.record_photon_density(recorder, photons, cell, nearest, rig.bind_sums());
    Schedule schedule = recorder.compile();
    for (const float4& e : rig.run(schedule)) CHECK(e.y == test::relative(expected, 1e-4));
  }
}

TEST_CASE("the density of photons on a sphere is that of their number, to 0.3 %") {
  // N photons of flux 1 at random places of a sphere: N / 4 pi R^2 everywhere, and a disc of radius r about a point
  // cuts exactly pi r^2 out of the sphere. Both ways: from the nearest photons, and from all within a cell that holds
  // fewer.
  const double radius = 2;
  Scene scene;
  add_triangles(scene, sphere_triangles(glm::vec3(0), static_cast<float>(radius), 5, true),
                add_material(scene, lambert(0.5f)));
  const uint32_t count = 1 << 17, places = 1 << 14;
  std::vector<VirtualLight> list;
  std::vector<SurfacePoint> points;
  std::mt19937 random(1);
  std::uniform_real_distribution<float> uniform(0, 1);
  for (uint32_t i = 0; i < count + places; ++i) {
    const float z = 2 * uniform(random) - 1, phi = 2 * static_cast<float>(pi) * uniform(random),
                s = std::sqrt(1 - z * z);
    const glm::vec3 n(s * std::cos(phi), s * std::sin(phi), z);
    if (i < count) {
      VirtualLight photon{};
      const float bits = std::bit_cast<float>(packed(-n));
      photon.position = float4(static_cast<float>(radius) * n, bits);
      photon.flux = float4(1, 1, 1, bits);
      list.push_back(photon);
    } else {
      SurfacePoint point{};
      point.position = float4(static_cast<float>(radius) * n, 0);
      point.normal = float4(-n, 0);
      points.push_back(point);
    }
  }
  PointRig rig(std::move(scene), points);
  const TypedBuffer<VirtualLight> photons(*test_device(), "test", "photons", list);
  const double expected = count / (4 * pi * radius * radius);
  for (const auto& [nearest, in_cell] : {std::pair{32u, 64.}, std::pair{128u, 32.}}) {
    CAPTURE(nearest);
    ScheduleRecorder recorder = rig.scheduler.record("density", "test");
    const Variable<float> cell = recorder.variable("cell", static_cast<float>(std::sqrt(in_cell / (pi * expected))));
    rig.light.record_photon_density(recorder, photons, cell, nearest, rig.bind_sums());
    Schedule schedule = recorder.compile();
    double mean = 0;
    for (const float4& e : rig.run(schedule)) mean += double{e.y} / places;
    MESSAGE("density ", mean / expected);
    CHECK(mean == test::relative(expected, 3e-3));
  }
}

TEST_CASE("arguments that no recording can keep are named") {
  Scene scene;
  add_horizontal(scene, 0, 0, 0, 4, 4, true, add_material(scene, lambert(0.5f)));
  PointRig rig(std::move(scene), middle(0), 64);
  const TypedBuffer<VirtualLight> few(*test_device(), "test", "lights", 7);
  ScheduleRecorder recorder = rig.scheduler.record("nothing", "test");
  const Variable<float> cell = recorder.variable("cell", 1.f);
  const Variable<uint32_t> run = recorder.variable("run", 0u), seed = recorder.variable("seed", 1u);
  for (const uint32_t nearest : {0u, 1u, static_cast<uint32_t>(LIGHT_MAX_PHOTONS) + 1})
    CHECK_THROWS_WITH_AS(rig.light.record_photon_density(recorder, few, cell, nearest, rig.bind_sums()),
                         doctest::Contains("nearest"), Error);
  const LightPaths paths(*test_device(), rig.buffers, rig.bvh, {.paths = 4, .vertices = 2}, "test");
  CHECK_THROWS_WITH_AS(paths.record_virtual_lights(recorder, run, seed, few, 3, true), doctest::Contains("first is 3"),
                       Error);
  CHECK_THROWS_WITH_AS(paths.record_virtual_lights(recorder, run, seed, few, 0, true),
                       doctest::Contains("lights has 7"), Error);
  CHECK_NOTHROW(paths.record_virtual_lights(recorder, run, seed, few, 1, true));
}

TEST_CASE("the number that comes with a light sample is another one for every point, every sample and every seed") {
  // One lamp, so that the light of all samples is the same.
  Scene scene;
  add_horizontal(scene, 0, 0, 0, 4, 4, true, add_material(scene, lambert(0.5f)));
  add_light(scene, LightType::point, 1, {0, 1, 0}, {0, -1, 0});
  constexpr size_t points = 256, samples = 16;
  PointRig rig(std::move(scene), middle(0), points, "chosen_points");
  const std::vector<double> numbers = rig.samples(samples, 1), others = rig.samples(samples, 2);
  CHECK(spread(numbers).mean == test::within(0.5, 5 / std::sqrt(12.0 * points * samples)));
  CHECK(spread(numbers).variance == test::relative(1. / 12, 0.1));
  // Without correlation the mean product of two numbers less 1/2, divided by their variance, deviates by 1 / sqrt(n).
  const auto correlation = [&](const std::vector<double>& a, const std::vector<double>& b, size_t shift) {
    double sum = 0;
    const size_t n = a.size() - shift;
    for (size_t i = 0; i < n; ++i) sum += 12 * (a[i] - 0.5) * (b[i + shift] - 0.5) / static_cast<double>(n);
    return std::abs(sum) * std::sqrt(static_cast<double>(n));
  };
  CHECK(correlation(numbers, others, 0) < 5);
  CHECK(correlation(numbers, numbers, 1) < 5);
  CHECK(correlation(numbers, numbers, points) < 5);
}

TEST_CASE("the ray of a light sample that meets a lamp comes with a number of its own") {
  // A lamp so near that most rays by the cosine meet it.
  Scene scene;
  add_horizontal(scene, 0, 0, 0, 4, 4, true, add_material(scene, lambert(0.5f)));
  add_horizontal(scene, 0, 0.02f, 0, 1, 1, false, add_material(scene, emitter(1)));
  constexpr uint32_t points = 2048;
  PointRig rig(std::move(scene), middle(0), points, "chosen_points");
  ScheduleRecorder recorder = rig.scheduler.record("direct light", "test");
  const Variable<uint32_t> sample = recorder.variable("sample", 0u), seed = recorder.variable("seed", 1u);
  rig.light.record_samples(recorder, sample, seed, rig.bind_sums());
  Schedule schedule = recorder.compile();
  std::vector<double> of_rays;
  double product = 0;
  for (const float4& numbers : rig.run(schedule)) {
    if (numbers.z != 1) continue;
    of_rays.push_back(double{numbers.x});
    product += 12 * (double{numbers.x} - 0.5) * (double{numbers.y} - 0.5);
  }
  const double n = static_cast<double>(of_rays.size());
  CHECK(n > points / 2);
  CHECK(spread(of_rays).mean == test::within(0.5, 5 / std::sqrt(12 * n)));
  // Of two independent numbers the sum's deviation is sqrt(n); of twice the same one it is n.
  CHECK(std::abs(product) < 5 * std::sqrt(n));
}
