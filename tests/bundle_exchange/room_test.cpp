// SPDX-License-Identifier: Apache-2.0
// A room with a lamp, all light by bundles: every texel's mean against the closed form of its direct light and against
// path tracing of its indirect light, both done here.
#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <random>

#include "bundle_rig.h"
#include "test_support.h"
#include "tolerance.h"

using namespace lucarium;
using namespace lucarium::bundle;

namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr std::array<double, 6> kAlbedos{0.25, 0.6, 0.6, 0.7, 0.7, 0.5};  // -x, +x, floor, ceiling, -z, +z
constexpr double kLampLow = 0.375, kLampHigh = 0.625, kLampRadiance = 20;

/// The unit box; in the middle of its ceiling a patch of 0.25 m of the ceiling's albedo that emits.
Scene room() {
  Scene scene;
  std::array<int, 6> walls{};
  for (int i = 0; i < 6; ++i) walls[i] = add_lambert(scene, "wall", glm::vec3(static_cast<float>(kAlbedos[i])));
  const int lamp = add_emitter(scene, "lamp", glm::vec3(static_cast<float>(kLampRadiance)));
  scene.materials[lamp].base_color = glm::vec4(0.7f, 0.7f, 0.7f, 1);
  scene = test::box_scene(walls, std::move(scene));
  const float y = 0.9999f, low = static_cast<float>(kLampLow), high = static_cast<float>(kLampHigh);
  MeshBuilder mesh("lamp");
  mesh.quad({low, y, low}, {high, y, low}, {high, y, high}, {low, y, high});
  add_instance(scene, add_mesh(scene, std::move(mesh).take()), lamp);
  return scene;
}

/// A point of a wall: 2 axis + side, and its coordinates along the other axes in order.
struct WallPoint {
  int wall;
  double u, v;
  glm::dvec3 position() const {
    const int axis = wall / 2, first = axis == 0 ? 1 : 0, second = axis == 2 ? 1 : 2;
    glm::dvec3 p;
    p[axis] = wall % 2;
    p[first] = u;
    p[second] = v;
    return p;
  }
  glm::dvec3 normal() const {
    glm::dvec3 n(0);
    n[wall / 2] = wall % 2 ? -1 : 1;
    return n;
  }
};

WallPoint wall_point(const glm::dvec3& p, int wall) {
  const int axis = wall / 2;
  return {wall, p[axis == 0 ? 1 : 0], p[axis == 2 ? 1 : 2]};
}

/// Direct E/π by Lambert's formula for polygons; the lamp is above every wall's horizon, and in the ceiling's plane.
double lamp_light(const WallPoint& point) {
  if (point.wall == 3) return 0;
  const glm::dvec3 p = point.position(), n = point.normal();
  const glm::dvec2 corners[4] = {{kLampLow, kLampLow}, {kLampHigh, kLampLow}, {kLampHigh, kLampHigh}, {kLampLow, kLampHigh}};
  double sum = 0;
  for (int i = 0; i < 4; ++i) {
    const glm::dvec2 a = corners[i], b = corners[(i + 1) % 4];
    const glm::dvec3 to_a = glm::normalize(glm::dvec3(a.x, 1, a.y) - p), to_b = glm::normalize(glm::dvec3(b.x, 1, b.y) - p);
    const glm::dvec3 across = glm::cross(to_a, to_b);
    sum += std::atan2(glm::length(across), glm::dot(to_a, to_b)) * glm::dot(glm::normalize(across), n);
  }
  return kLampRadiance * std::abs(sum) / (2 * kPi);
}

/// lamp_light of cells of all walls.
class LampTable {
 public:
  LampTable() {
    for (int i = 0; i < 6 * kFine * kFine; ++i)
      light_.push_back(lamp_light({i / (kFine * kFine), (i / kFine % kFine + 0.5) / kFine, (i % kFine + 0.5) / kFine}));
  }
  double at(const WallPoint& p) const {
    const auto cell = [](double x) { return std::clamp(static_cast<int>(x * kFine), 0, kFine - 1); };
    return light_[static_cast<size_t>((p.wall * kFine + cell(p.u)) * kFine + cell(p.v))];
  }

 private:
  static constexpr int kFine = 512;  // cells are points on the mean, so that steps between them do not matter
  std::vector<double> light_;
};

/// Where a ray from a wall into the box arrives.
WallPoint trace(const glm::dvec3& p, const glm::dvec3& d) {
  int wall = 0;
  double nearest = 1e30;
  for (int axis = 0; axis < 3; ++axis) {
    const double t = ((d[axis] > 0 ? 1.0 : 0.0) - p[axis]) / d[axis];
    if (!(t < nearest) || std::abs(d[axis]) < 1e-12) continue;
    nearest = t;
    wall = 2 * axis + (d[axis] > 0);
  }
  return wall_point(p + nearest * d, wall);
}

/// One path's indirect E/π at a point: at every vertex the lamp's light, reflected; goes on by the albedo's probability.
/// x: random, for the first direction.
double follow_path(WallPoint point, glm::dvec2 x, const LampTable& lamp, std::mt19937_64& random) {
  std::uniform_real_distribution<double> unit;
  double sum = 0, factor = 1;
  for (int depth = 0;; ++depth) {
    const double r = std::sqrt(x.x), phi = 2 * kPi * x.y;
    const double across[3] = {std::sqrt(1 - x.x), r * std::cos(phi), r * std::sin(phi)};
    const int axis = point.wall / 2;
    glm::dvec3 d;
    d[axis] = point.wall % 2 ? -across[0] : across[0];
    d[(axis + 1) % 3] = across[1];
    d[(axis + 2) % 3] = across[2];
    point = trace(point.position(), d);
    const double albedo = kAlbedos[static_cast<size_t>(point.wall)];
    if (depth == 0)
      factor = albedo;
    else if (unit(random) >= albedo)
      return sum;
    sum += factor * lamp.at(point);
    x = {unit(random), unit(random)};
  }
}

/// Mean indirect E/π over a square of a wall, by `strata`² paths whose places and first directions are stratified.
double path_traced(const WallPoint& corner, double edge, int strata, const LampTable& lamp, std::mt19937_64& random) {
  std::uniform_real_distribution<double> unit;
  double sum = 0;
  for (int k = 0; k < strata * strata; ++k) {
    const WallPoint point{corner.wall, corner.u + edge * unit(random), corner.v + edge * unit(random)};
    sum += follow_path(point, {(k / strata + unit(random)) / strata, (k % strata + unit(random)) / strata}, lamp, random);
  }
  return sum / (strata * strata);
}

double mean_lamp_light(const WallPoint& corner, double edge) {
  const int fine = 6;
  double sum = 0;
  for (int k = 0; k < fine * fine; ++k)
    sum += lamp_light({corner.wall, corner.u + edge * (k / fine + 0.5) / fine, corner.v + edge * (k % fine + 0.5) / fine});
  return sum / (fine * fine);
}

/// Relative errors over all texels of the walls that are not behind the lamp.
struct Errors {
  double direct, indirect, both;      ///< root mean square over the root mean square
  double direct_bias, indirect_bias;  ///< of the mean
  double direct_mean, indirect_mean;  ///< of the values that are expected
};

/// `side`² texels per wall, a film of 64² pixels over the projected bounds.
Errors room_errors(int side, uint64_t directions, int strata) {
  Parameters parameters;
  parameters.direct_mode = DirectMode::exchange;
  if (directions > 2048) parameters.block = 16384;
  Channels channels;
  channels.emission = true;
  channels.count = 2;
  test::BundleRig rig(room(), static_cast<uint64_t>(6 * side * side + side * side / 16), 1.5f / 64 * static_cast<float>(side), channels, parameters);
  rig.solve(DirectionSequence(parameters, 2, nullptr), directions);
  const std::vector<AtlasMaterial> materials = rig.materials();
  const std::vector<SurfacePoint> points = rig.points();
  const std::vector<AtlasTexel> texels = rig.texels();
  const std::vector<double> direct = rig.direct(), indirect = rig.indirect();
  const LampTable lamp;
  std::mt19937_64 random(1);
  double n = 0, d = 0, dd = 0, de = 0, found_d = 0, i = 0, ii = 0, ie = 0, found_i = 0, tt = 0, te = 0, areas = 0;
  for (uint32_t slot = 0; slot < rig.slots(); ++slot) {
    if (materials[slot].emission.x > 0) continue;
    const glm::dvec3 p(points[slot].position.x, points[slot].position.y, points[slot].position.z);
    const glm::vec3 normal(points[slot].normal.x, points[slot].normal.y, points[slot].normal.z);
    int wall = 0;
    for (int axis = 0; axis < 3; ++axis)
      if (std::abs(normal[axis]) > 0.5f) wall = 2 * axis + (normal[axis] < 0);
    if (wall == 3 && std::abs(p.x - .5) < .125 && std::abs(p.z - .5) < .125) continue;
    WallPoint corner = wall_point(p, wall);
    corner.u = std::floor(corner.u * side) / side;
    corner.v = std::floor(corner.v * side) / side;
    const double edge = 1.0 / side, expected = mean_lamp_light(corner, edge);
    // Two independent values: the product of the differences has no share of their noise.
    const double a = path_traced(corner, edge, strata, lamp, random), b = path_traced(corner, edge, strata, lamp, random);
    const double area = static_cast<double>(texels[slot].area);  // squares but for a thousandth: charts end within their cells
    n += 1, areas += area;
    d += expected, dd += expected * expected, found_d += area * direct[slot];
    de += (direct[slot] - expected) * (direct[slot] - expected);
    i += 0.5 * (a + b), ii += a * b, found_i += area * indirect[slot];
    ie += (indirect[slot] - a) * (indirect[slot] - b);
    const double all = direct[slot] + indirect[slot] - expected;
    tt += (expected + a) * (expected + b);
    te += (all - a) * (all - b);
  }
  CHECK(n == 6 * side * side - side * side / 16);
  return {std::sqrt(de / dd), std::sqrt(std::max(ie, 0.0) / ii), std::sqrt(std::max(te, 0.0) / tt), found_d / areas * n / d - 1, found_i / areas * n / i - 1, d / n, i / n};
}

}  // namespace

TEST_CASE("a room with a lamp, all light by bundles: every texel") {
  const Errors e = room_errors(16, 1024, 32);
  MESSAGE("1024 directions, 16 x 16 texels: direct ", e.direct, " (mean ", e.direct_bias, "), indirect ", e.indirect, " (mean ", e.indirect_bias, "), both ", e.both);
  MESSAGE("expected means ", e.direct_mean, " ", e.indirect_mean);
  CHECK(e.both < 0.06);
  CHECK(e.indirect < 0.03);
  if (!test::full_run()) return;
  const std::array<double, 3> limits{0.010, 0.0040, 0.0035};
  for (int k = 0; k < 3; ++k) {
    const int side = 8 << k;
    CAPTURE(side);
    const Errors f = room_errors(side, 32768, 128 >> k);
    MESSAGE(side, "² texels: direct ", f.direct, " (mean ", f.direct_bias, "), indirect ", f.indirect, " (mean ", f.indirect_bias, ")");
    // Small texels see the edges of the lamp sharp, which strata of directions do not resolve: noise, as the mean shows.
    if (side == 8) CHECK(f.direct < 0.006);
    CHECK(f.indirect < limits[static_cast<size_t>(k)]);
    CHECK(std::abs(f.direct_bias) < 0.0005);
    CHECK(std::abs(f.indirect_bias) < 0.0005);
  }
}
