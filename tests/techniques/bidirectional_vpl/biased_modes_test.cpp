// SPDX-License-Identifier: Apache-2.0
// Modes that trade noise for bias: clamps of two bounces and of glossy surfaces. Each errs to the side that it should,
// less with more samples or in its limit, and two_bounce=compensate not at all.
#include "bidirectional_rig.h"
#include "lucarium/compute/program/source_library.h"
#include "lucarium/scene/builtin/scenes.h"
#include "made_scene.h"
#include "test_support.h"
#include "tolerance.h"

const lucarium::EmbeddedSources& test_bidirectional_vpl_kernels();
const lucarium::EmbeddedSources& bidirectional_vpl_kernels();

using namespace lucarium;
using namespace lucarium::test;

namespace {

std::vector<double> means_of_indirect(const Scene& scene, const Picture& picture, const Parameters& parameters) {
  return layer_means(scene, "bidirectional_vpl", picture, "indirect", parameters, 60);
}

/// The room, from above a point of its floor.
Scene floor_point(float x, float z) {
  Scene scene = make_builtin_scene("room");
  scene.cameras = {look_orthographic({x, 0.01f, z}, {x, 0, z}, 1e-5f)};
  return scene;
}

Picture point_picture(uint64_t iterations) {
  Picture picture;
  picture.width = picture.height = 16;
  picture.max_bounces = 2;
  picture.iterations = full_run() ? 64 * iterations : iterations;
  return picture;
}

}  // namespace

TEST_CASE(
    "two bounces: clamps lose light, most in corners, what compensates brings it back, and a high limit loses none") {
  // Irradiances of one and both bounces (closed_rooms_test.cpp), reflected. Shares of the second that are lost: by an
  // independent estimate that follows 4e7 paths backwards, each +-4e-4 (with the square of the limit .350 and .422).
  struct Point {
    float x, z;
    double first, second;
    const char* limit;  // [1/m^2]
    double lost;
  };
  ClosedForms table;
  for (const Point& point :
       {Point{-.5f, .3f, .2931, .1698, "0.25", .2748}, Point{-.98f, -.97f, .1709, .1506, "1", .3915}}) {
    const Scene scene = floor_point(point.x, point.z);
    const double all = (point.first + point.second) * 0.7 / M_PI, second = point.second * 0.7 / M_PI;
    const std::string place = "(" + std::to_string(point.x) + ", " + std::to_string(point.z) + ") ";
    table.add(place + "compensated",
              estimate_of(means_of_indirect(scene, point_picture(24), {{"two_bounce", "compensate"}})), all, 1e-4);
    if (point.lost < 0.3)  // in the corner few paths bring most
      table.add(place + "high limit",
                estimate_of(means_of_indirect(scene, point_picture(24), {{"two_bounce", "clamp"}, {"g_max", "1e6"}})),
                all, 1e-4);
    const Parameters limited = {{"two_bounce", "clamp"}, {"g_max", point.limit}};
    const Estimate clamped = estimate_of(means_of_indirect(scene, point_picture(32), limited));
    const double lost = (all - clamped.mean) / second;
    MESSAGE(place << "loses " << lost << " +- " << clamped.error / second << " of the second bounce");
    CHECK(lost == test::within(point.lost, 0.002 + 4 * clamped.error / second));
    CHECK(clamped.error <= 0.02 * second);
  }
  table.check(0.02);
}

TEST_CASE("two bounces: compensated pictures agree with path tracing, mirrors among the surfaces") {
  Picture picture;
  picture.max_bounces = 4;
  picture.iterations = full_run() ? 256 : 8;
  check_agreement("compensated", load_scene("builtin:cornell-mirror"), picture,
                  {{"two_bounce", "compensate"}, {"g_max", "3"}}, {}, kSeeds);
}

TEST_CASE("glossy surfaces by few samples: less noise, errors of the right sign, less with more samples") {
  // Camera paths along bundles, which do not follow the lobes.
  const Scene scene = load_scene("builtin:cornell-glossy");
  Picture picture;
  picture.width = picture.height = 32;
  picture.max_bounces = 2;
  Picture more = picture;
  more.iterations = full_run() ? 16384 : 1024;
  const Estimate expected = estimate_of(layer_means(scene, "path_tracing", more, "indirect", {}, 90, 4));
  const auto bias = [&](const char* gloss, uint64_t iterations) {
    Picture some = picture;
    some.iterations = iterations;
    Estimate e = estimate_of(means_of_indirect(
        scene, some, {{"directions", "bundle"}, {"light_vertices", "1"}, {"splat", "off"}, {"gloss", gloss}}));
    e.mean = e.mean / expected.mean - 1;
    e.error = std::hypot(e.error, expected.error) / expected.mean;
    MESSAGE(std::string(gloss) << ", " << iterations << " samples: " << e.mean << " +- " << e.error);
    return e;
  };
  const Estimate none = bias("none", 4);
  for (const char* const dark : {"clamp", "vsl"}) {
    const Estimate few = bias(dark, 4), many = bias(dark, full_run() ? 4096 : 64);
    CHECK(few.mean < -5 * few.error);
    CHECK(std::abs(many.mean) < 0.6 * std::abs(few.mean));
    CHECK(few.error < none.error);
    if (full_run()) CHECK(std::abs(many.mean) <= 4 * many.error + 0.01);
  }
  // Wider lobes keep their albedo: the mean hardly changes, the noise does.
  const Estimate few = bias("roughness", 4);
  CHECK(few.error < 0.6 * none.error);
  CHECK(std::abs(few.mean) <= 0.15 + 4 * few.error);
  if (full_run()) CHECK(std::abs(bias("roughness", 4096).mean) <= 0.02);
}

TEST_CASE(
    "clamped lobes reach density over m and no more, Phong and GGX, and samples from both sides have less density") {
  SourceLibrary library;
  library.add(bidirectional_vpl_kernels());
  library.add(test_bidirectional_vpl_kernels());
  const Program program(*test_device(), library,
                        {"test_bidirectional_vpl/clamped_lobes", {"test_bidirectional_vpl/clamped_lobes.cl"}, {}});
  std::vector<float> inputs;
  for (const float width : {0.01f, 0.1f, 0.5f})
    for (const float density : {0.3f, 10.f, 1000.f, 1e6f})
      for (const float m : {0.5f, 16.f}) inputs.insert(inputs.end(), {width, density, m, 5.f});
  const size_t count = inputs.size() / 4;
  const auto in = test_buffer(inputs);
  const auto out = test_buffer<float>(4 * count);
  run_kernel(program, "clamp_lobes", count, 8, [&](PassBuilder& pass) {
    pass.arg("count", static_cast<uint32_t>(count)).arg("inputs", in).arg("outputs", out);
  });
  const std::vector<float> found = out.download();
  for (size_t i = 0; i < count; ++i) {
    const double width = inputs[4 * i], density = inputs[4 * i + 1], m = inputs[4 * i + 2], exponent = 1 / width;
    CAPTURE(width);
    CAPTURE(density);
    CAPTURE(m);
    // max D is (a + 1) / 2 pi and 1 / (pi alpha^2); the widest lobes are a = 0 and alpha = 1.
    const double phong = (double{found[4 * i]} + 1) / (2 * M_PI),
                 ggx = 1 / (M_PI * std::pow(double{found[4 * i + 1]}, 2));
    const double most = density / m;
    CHECK(phong == test::relative(std::max(std::min((exponent + 1) / (2 * M_PI), most), 1 / (2 * M_PI)), 1e-4));
    CHECK(ggx == test::relative(std::max(std::min(1 / (M_PI * width * width), most), 1 / M_PI), 1e-4));
    CHECK(double{found[4 * i + 2]} == test::relative(1 / (1 / density + 1 / 5.), 1e-5));
    CHECK(double{found[4 * i + 3]} == test::relative(density, 1e-5));  // a pinhole on the other side
  }
}
