// SPDX-License-Identifier: Apache-2.0
// Transport between diffuse surfaces against closed forms: uniform fields, form factors, a plate under a sky. What is
// tested is the ratio that the technique uses; the solid angles of directions weight it.
#include <doctest/doctest.h>

#include <algorithm>
#include <numeric>

#include "field_rig.h"
#include "test_support.h"
#include "tolerance.h"
#include "virtual_light_field/directions/direction_grid.h"

using namespace lucarium;
using test::relative;
using test::within;

namespace {

vlf::Parameters exchanged(int dir_n, int cells, int texels) {
  vlf::Parameters parameters;
  parameters.dir_n = dir_n;
  parameters.cells = cells;
  parameters.texels = texels;
  parameters.direct_mode = vlf::DirectMode::exchange;
  return parameters;
}

double mean(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.) / static_cast<double>(values.size());
}
/// A lamp of radiance 1 and a black receiver, unit squares at distance 1 or with a common edge.
Scene two_squares(bool parallel) {
  const SceneMaterial lamp = test::emitter(1), black = test::lambert(0);
  return test::unit_box({{2, black}, {parallel ? 3 : 0, lamp}});
}

/// A double-sided square across +y, under a sky of radiance 1 + y.
Scene plate_under_sky() {
  Scene scene;
  SceneMaterial white = test::lambert(0.5f);
  white.double_sided = true;
  test::add_polygon(scene, {{0, 0, 0}, {0, 0, 1}, {1, 0, 1}, {1, 0, 0}}, test::add_material(scene, white));
  Environment sky;
  sky.width = 64;
  sky.height = 128;
  for (uint32_t y = 0; y < sky.height; ++y) {
    const double up = std::cos(3.14159265358979323846 * (y + 0.5) / sky.height);
    sky.radiance.insert(sky.radiance.end(), sky.width, glm::vec3(static_cast<float>(1 + up)));
  }
  scene.environment = sky;
  return scene;
}
std::vector<double> upper_half(const test::FieldRig& rig) {
  const std::vector<double> e = rig.direct();
  return {e.begin(), e.begin() + static_cast<long>(e.size() / 2)};
}
std::vector<double> lower_half(const test::FieldRig& rig) {
  const std::vector<double> e = rig.direct();
  return {e.begin() + static_cast<long>(e.size() / 2), e.end()};
}

}  // namespace

TEST_CASE("in a closed box of radiance 1 every texel side holds exactly that, whatever the directions") {
  for (const float gap : {-1.f, 0.f, 2.f, 8.f}) {
    CAPTURE(gap);
    vlf::Parameters parameters = exchanged(4, 32, 1536);
    parameters.access_gap = gap;
    const SceneMaterial lamp = test::emitter(1);
    test::FieldRig rig(test::unit_box({{0, lamp}, {1, lamp}, {2, lamp}, {3, lamp}, {4, lamp}, {5, lamp}}), parameters,
                       {.max_bounces = 0});
    rig.propagate();
    CHECK(test::min_of(rig.direct()) == within(1, 1e-5));
    CHECK(test::max_of(rig.direct()) == within(1, 1e-5));
  }
}

TEST_CASE("two unit squares have their form factors") {
  const int n = test::full_run() ? 32 : 16;
  for (const bool parallel : {true, false}) {
    CAPTURE(parallel);
    test::FieldRig rig(two_squares(parallel), exchanged(n, 64, 4096), {.max_bounces = 0});
    rig.propagate();
    CHECK(rig.mean(rig.direct(), 0) == relative(parallel ? 0.199825 : 0.200044, 0.01));
  }
}

TEST_CASE("a double-sided plate under the sky 1 + y holds 5 pi / 3 above and pi / 3 below") {
  test::FieldRig rig(plate_under_sky(), exchanged(16, 64, 1024), {.max_bounces = 0});
  rig.propagate();
  const std::vector<double> above = upper_half(rig), below = lower_half(rig);
  CHECK(rig.surfaces().atlas.info().double_sided_count * 2 == rig.sides());
  for (const double value : {test::min_of(above), test::max_of(above)}) CHECK(value == relative(5. / 3, 0.005));
  for (const double value : {test::min_of(below), test::max_of(below)}) CHECK(value == relative(1. / 3, 0.03));
  CHECK(mean(above) == relative(5. / 3, 0.005));
  CHECK(mean(below) == relative(1. / 3, 0.005));
}

TEST_CASE("directions count their solid angles: a plate holds the sum of few of them") {
  constexpr int n = 2;
  test::FieldRig rig(plate_under_sky(), exchanged(n, 64, 1024), {.max_bounces = 0, .seed = 4});
  rig.propagate();
  const vlf::DirectionGrid grid(n, 4);
  double light = 0, all = 0;
  for (uint32_t d = 0; d < grid.directions(); ++d) {
    const double up = grid.direction(d).y;
    if (up <= 0) continue;
    light += grid.solid_angle(d) * up * (1 + up);
    all += grid.solid_angle(d) * up;
  }
  CHECK(mean(upper_half(rig)) == relative(light / all, 0.003));
}

TEST_CASE("a furnace of albedo one half holds 1, 1 + 1/2, ... bounce by bounce, and 2 with its tail") {
  const SceneMaterial wall = test::emitter(1, 0.5f);
  const auto box = [&] { return test::unit_box({{0, wall}, {1, wall}, {2, wall}, {3, wall}, {4, wall}, {5, wall}}); };
  for (const int bounces : {0, 1, 3, -1}) {
    CAPTURE(bounces);
    test::FieldRig rig(box(), exchanged(4, 32, 1536), {.max_bounces = bounces});
    rig.propagate();
    CHECK(rig.field().sweeps() == (bounces < 0 ? 3u : static_cast<uint32_t>(bounces) + 1));
    const double expected = bounces < 0 ? 2 : 2 - std::pow(0.5, bounces);
    CHECK(test::min_of(rig.all()) == within(expected, 1e-4));
    CHECK(test::max_of(rig.all()) == within(expected, 1e-4));
  }
}

TEST_CASE("light samples and propagation bring the same direct light") {
  const auto rig_of = [](vlf::DirectMode mode) {
    vlf::Parameters parameters = exchanged(16, 64, 4096);
    parameters.direct_mode = mode;
    const SceneMaterial grey = test::lambert(0.5f);
    auto rig = std::make_unique<test::FieldRig>(
        test::unit_box({{0, grey}, {1, grey}, {2, grey}, {3, test::emitter(3)}, {4, grey}, {5, grey}}), parameters,
        test::FieldRig::Options{.max_bounces = 2, .light_samples = 256});
    rig->propagate();
    return rig;
  };
  const auto sampled = rig_of(vlf::DirectMode::nee), exchange = rig_of(vlf::DirectMode::exchange);
  for (const int wall : {0, 1, 2, 4, 5}) {
    CAPTURE(wall);
    CHECK(sampled->mean(sampled->direct(), wall) == relative(exchange->mean(exchange->direct(), wall), 0.01));
    CHECK(sampled->mean(sampled->indirect(), wall) == relative(exchange->mean(exchange->indirect(), wall), 0.01));
  }
}

TEST_CASE("an iteration that was cancelled does the rest of its work when it is repeated, and no more") {
  const SceneMaterial wall = test::emitter(1, 0.5f);
  const auto subfields = [&](bool cancelled) {
    vlf::Parameters parameters = exchanged(3, 32, 512);
    test::FieldRig rig(test::unit_box({{0, wall}, {2, wall}, {3, wall}}), parameters, {.max_bounces = 2});
    vlf::LightField& field = rig.field();
    CHECK(field.advance(1));
    int requests = 0;
    if (cancelled) rig.scheduler().set_cancel([&] { return ++requests == 4; });
    const double pixels = field.counts().subfield_pixels;
    const bool completed = field.advance(12 * pixels);
    CHECK(completed != cancelled);
    if (cancelled) CHECK(field.counts().subfield_pixels < 12 * pixels);
    if (!completed) CHECK(field.advance(12 * pixels));
    return field.counts().subfields;
  };
  CHECK(subfields(true) == subfields(false));
}
