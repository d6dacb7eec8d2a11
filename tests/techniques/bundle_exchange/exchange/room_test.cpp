// SPDX-License-Identifier: Apache-2.0
// A room with a lamp, all light by bundles: every texel's mean against the closed form of its direct light and against
// path tracing of its indirect light, and against the exact solution for constant radiance per texel.
#include <doctest/doctest.h>

#include <optional>

#include "lamp_room.h"
#include "test_support.h"

using namespace lucarium;
using namespace lucarium::bundle;
using namespace lucarium::test::lamp_room;

namespace {

/// Relative errors over all texels of the walls that are not behind the lamp.
struct Errors {
  double direct, indirect, both;      ///< root mean square over the root mean square
  double direct_bias, indirect_bias;  ///< of the mean by area and accessibility
  double direct_mean, indirect_mean;  ///< of the values that are expected
  double solved;                      ///< indirect: difference from the exact solution of the texels; root mean square
  double discretisation;              ///< indirect: that solution's own error
};

struct Setting {
  int wall_texels;  ///< texels along a wall
  uint64_t directions;
  int strata;  ///< a side's of the paths per texel
  float access_gap = 0;
  bool solve = false;  ///< exactly, too
};

/// A bundle image of 64² pixels over the projected bounds.
Errors room_errors(const Setting& setting) {
  const int wall_texels = setting.wall_texels;
  Parameters parameters;
  parameters.direct_mode = DirectMode::exchange;
  parameters.access_gap = setting.access_gap;
  if (setting.directions > 2048) parameters.block = 16384;
  Channels channels;
  channels.emission = true;
  channels.count = 2;
  test::BundleRig rig(room(), static_cast<uint64_t>(6 * wall_texels * wall_texels + wall_texels * wall_texels / 16),
                      1.5f / 64 * static_cast<float>(wall_texels), channels, parameters);
  rig.solve(make_sequence(parameters, 2), setting.directions);
  const std::vector<AtlasMaterial> materials = rig.materials();
  const std::vector<SurfacePoint> points = rig.points();
  const std::vector<AtlasTexel> texels = rig.texels();
  const std::vector<double> direct = rig.direct(), indirect = rig.indirect();
  const double gap = static_cast<double>(setting.access_gap) * rig.texel_edge();
  std::optional<DiscreteRoom> discrete;
  if (setting.solve) discrete.emplace(wall_texels);
  const LampTable lamp;
  std::mt19937_64 random(1);
  double n = 0, d = 0, dd = 0, de = 0, found_d = 0, i = 0, ii = 0, ie = 0, found_i = 0, tt = 0, te = 0, areas = 0,
         se = 0, ds = 0;
  for (uint32_t side = 0; side < rig.sides(); ++side) {
    if (materials[side].emission.x > 0) continue;
    const glm::dvec3 p(points[side].position.x, points[side].position.y, points[side].position.z);
    const glm::vec3 normal(points[side].normal.x, points[side].normal.y, points[side].normal.z);
    int wall = 0;
    for (int axis = 0; axis < 3; ++axis)
      if (std::abs(normal[axis]) > 0.5f) wall = 2 * axis + (normal[axis] < 0);
    if (wall == 3 && std::abs(p.x - .5) < .125 && std::abs(p.z - .5) < .125) continue;
    WallPoint corner = wall_point(p, wall);
    corner.u = std::floor(corner.u * wall_texels) / wall_texels;
    corner.v = std::floor(corner.v * wall_texels) / wall_texels;
    const WallSquare square{corner, 1.0 / wall_texels};
    const auto [expected, accessibility] = lamp_lit(square, gap, random);
    // Two independent values: the product of the differences has no share of their noise.
    const double a = path_traced(square, setting.strata, gap, lamp, random).value;
    const double b = path_traced(square, setting.strata, gap, lamp, random).value;
    // By true areas: they are squares up to a thousandth, since charts end within their cells.
    const double area = static_cast<double>(texels[side].area) * accessibility;
    n += 1, areas += area;
    d += area * expected, dd += expected * expected, found_d += area * direct[side];
    de += (direct[side] - expected) * (direct[side] - expected);
    i += area * 0.5 * (a + b), ii += a * b, found_i += area * indirect[side];
    ie += (indirect[side] - a) * (indirect[side] - b);
    const double all = direct[side] + indirect[side] - expected;
    tt += (expected + a) * (expected + b);
    te += (all - a) * (all - b);
    if (!discrete) continue;
    const double solution = discrete->indirect(corner);
    se += (indirect[side] - solution) * (indirect[side] - solution);
    ds += (solution - a) * (solution - b);
  }
  CHECK(n == 6 * wall_texels * wall_texels - wall_texels * wall_texels / 16);
  const auto root = [](double x) { return std::sqrt(std::max(x, 0.0)); };
  return {root(de / dd), root(ie / ii), root(te / tt), found_d / d - 1, found_i / i - 1,
          d / areas,     i / areas,     root(se / ii), root(ds / ii)};
}

}  // namespace

TEST_CASE("a room with a lamp, all light by bundles: every texel") {
  const Errors e = room_errors({16, 1024, 32});
  MESSAGE("1024 directions, 16 x 16 texels: direct ", e.direct, " (mean ", e.direct_bias, "), indirect ", e.indirect,
          " (mean ", e.indirect_bias, "), both ", e.both);
  MESSAGE("expected means ", e.direct_mean, " ", e.indirect_mean);
  CHECK(e.both < 0.06);
  CHECK(e.indirect < 0.03);
  if (!test::full_run()) return;
  for (int wall_texels : {8, 16, 32}) {
    CAPTURE(wall_texels);
    const Errors f = room_errors(
        {.wall_texels = wall_texels, .directions = 32768, .strata = 4096 / wall_texels, .solve = wall_texels < 32});
    MESSAGE(wall_texels, "² texels: direct ", f.direct, " (mean ", f.direct_bias, "), indirect ", f.indirect, " (mean ",
            f.indirect_bias, "); exact solution: error ", f.discretisation, ", difference from it ", f.solved);
    // Small texels see the edges of the lamp sharp, which strata of directions do not resolve: noise, as the mean
    // shows.
    if (wall_texels == 8) CHECK(f.direct < 0.006);
    if (wall_texels == 8) CHECK(f.indirect < 0.010);
    if (wall_texels == 32) CHECK(f.indirect < 0.0035);
    if (wall_texels < 32) CHECK(f.solved < 0.001);
    CHECK(std::abs(f.direct_bias) < 0.0005);
    CHECK(std::abs(f.indirect_bias) < 0.0005);
  }
  // By accessibility, rays within the gap carry what is seen from afar: too much near edges, by an error that falls
  // with texels.
  double coarser = 0.005;
  for (int wall_texels : {16, 32}) {
    CAPTURE(wall_texels);
    const Errors f =
        room_errors({.wall_texels = wall_texels, .directions = 32768, .strata = 1024 / wall_texels, .access_gap = 2});
    MESSAGE("access_gap=2: direct ", f.direct, " (mean ", f.direct_bias, "), indirect ", f.indirect, " (mean ",
            f.indirect_bias, ")");
    CHECK(std::abs(f.indirect_bias) < 0.7 * coarser);
    coarser = std::abs(f.indirect_bias);
  }
}
