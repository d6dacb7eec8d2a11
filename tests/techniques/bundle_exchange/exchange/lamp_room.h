// SPDX-License-Identifier: Apache-2.0
// A room with a lamp whose light is known: direct light in closed form, indirect light by path tracing.
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <vector>

#include "bundle_rig.h"
#include "lucarium/base/numbers.h"

namespace lucarium::test::lamp_room {

inline constexpr std::array<double, 6> kAlbedos{0.25, 0.6, 0.6, 0.7, 0.7, 0.5};  // -x, +x, floor, ceiling, -z, +z
inline constexpr double kLampLow = 0.375, kLampHigh = 0.625, kLampRadiance = 20;

/// The unit box; in the middle of its ceiling a patch of 0.25 m of the ceiling's albedo that emits.
inline Scene room() {
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

inline WallPoint wall_point(const glm::dvec3& p, int wall) {
  const int axis = wall / 2;
  return {wall, p[axis == 0 ? 1 : 0], p[axis == 2 ? 1 : 2]};
}

/// A square of a wall, from its least corner on.
struct WallSquare {
  WallPoint corner;
  double edge;
  WallPoint at(double u, double v) const { return {corner.wall, corner.u + edge * u, corner.v + edge * v}; }
};

inline constexpr WallSquare kLamp{{3, kLampLow, kLampLow}, kLampHigh - kLampLow};

/// E/π at a point from a square of radiance 1 on another wall, which is above the point's horizon: Lambert's formula
/// for polygons.
inline double light_of(const WallSquare& square, const WallPoint& point) {
  const glm::dvec3 p = point.position(), n = point.normal();
  glm::dvec3 to[4];
  for (int i = 0; i < 4; ++i) to[i] = glm::normalize(square.at(i == 1 || i == 2, i >= 2).position() - p);
  double sum = 0;
  for (int i = 0; i < 4; ++i) {
    const glm::dvec3 across = glm::cross(to[i], to[(i + 1) % 4]);
    const double length = glm::length(across);
    if (length > 0) sum += std::atan2(length, glm::dot(to[i], to[(i + 1) % 4])) * glm::dot(across, n) / length;
  }
  return std::abs(sum) / (2 * pi);
}

/// Direct E/π; nothing in the ceiling's own plane.
inline double lamp_light(const WallPoint& point) {
  return point.wall == kLamp.corner.wall ? 0 : kLampRadiance * light_of(kLamp, point);
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

/// Into the box by the cosine's density. x: random.
inline glm::dvec3 cosine_direction(int wall, glm::dvec2 x) {
  const double r = std::sqrt(x.x), phi = 2 * pi * x.y, up = std::sqrt(1 - x.x);
  const int axis = wall / 2;
  glm::dvec3 d;
  d[axis] = wall % 2 ? -up : up;
  d[(axis + 1) % 3] = r * std::cos(phi);
  d[(axis + 2) % 3] = r * std::sin(phi);
  return d;
}

/// Where a ray from a wall into the box arrives, and how far that is.
struct Arrival {
  WallPoint point;
  double distance;
};
inline Arrival trace(const glm::dvec3& p, const glm::dvec3& d) {
  int wall = 0;
  double nearest = 1e30;
  for (int axis = 0; axis < 3; ++axis) {
    const double t = ((d[axis] > 0 ? 1.0 : 0.0) - p[axis]) / d[axis];
    if (!(t < nearest) || std::abs(d[axis]) < 1e-12) continue;
    nearest = t;
    wall = 2 * axis + (d[axis] > 0);
  }
  return {wall_point(p + nearest * d, wall), nearest};
}

/// Share of the rays from a point that go farther than `gap`, by `strata`² of them.
inline double accessibility(const WallPoint& point, double gap, int strata, std::mt19937_64& random) {
  if (gap == 0) return 1;
  std::uniform_real_distribution<double> unit;
  int open = 0;
  for (int k = 0; k < strata * strata; ++k) {
    const glm::dvec2 x((k / strata + unit(random)) / strata, (k % strata + unit(random)) / strata);
    open += trace(point.position(), cosine_direction(point.wall, x)).distance > gap;
  }
  return static_cast<double>(open) / (strata * strata);
}

/// One path's indirect E/π at a point: at every vertex the lamp's light, reflected; goes on by the albedo's
/// probability. x: random, for the first direction.
inline double follow_path(WallPoint point, glm::dvec2 x, const LampTable& lamp, std::mt19937_64& random) {
  std::uniform_real_distribution<double> unit;
  double sum = 0, factor = 1;
  for (int depth = 0;; ++depth) {
    point = trace(point.position(), cosine_direction(point.wall, x)).point;
    const double albedo = kAlbedos[static_cast<size_t>(point.wall)];
    if (depth == 0)
      factor = albedo;
    else if (unit(random) >= albedo)
      return sum;
    sum += factor * lamp.at(point);
    x = {unit(random), unit(random)};
  }
}

/// Mean over a square, in which points count by their accessibility.
struct Mean {
  double value, accessibility;
};

/// Of indirect E/π, by `strata`² paths whose first directions are stratified.
inline Mean path_traced(const WallSquare& square, int strata, double gap, const LampTable& lamp,
                        std::mt19937_64& random) {
  std::uniform_real_distribution<double> unit;
  double sum = 0, open = 0;
  for (int k = 0; k < strata * strata; ++k) {
    const WallPoint point = square.at(unit(random), unit(random));
    const double a = accessibility(point, gap, 2, random);
    sum += a * follow_path(point, {(k / strata + unit(random)) / strata, (k % strata + unit(random)) / strata}, lamp,
                           random);
    open += a;
  }
  return {sum / open, open / (strata * strata)};
}

/// Of direct E/π.
inline Mean lamp_lit(const WallSquare& square, double gap, std::mt19937_64& random) {
  const int fine = 6;
  double sum = 0, open = 0;
  for (int k = 0; k < fine * fine; ++k) {
    const WallPoint point = square.at((k / fine + 0.5) / fine, (k % fine + 0.5) / fine);
    const double a = accessibility(point, gap, 16, random);
    sum += a * lamp_light(point);
    open += a;
  }
  return {sum / open, open / (fine * fine)};
}

/// The room solved exactly for radiance that is constant over squares, `side`² per wall: indirect E/π of each is
/// (1 - K)⁻¹ K E_direct, K the form factors times albedos. What a limitless number of directions would come to.
class DiscreteRoom {
 public:
  explicit DiscreteRoom(int side)
      : side_(side), count_(static_cast<size_t>(6 * side * side)), direct_(count_), indirect_(count_, 0) {
    std::vector<double> factors(count_ * count_, 0);
    for (size_t i = 0; i < count_; ++i)
      for (size_t j = 0; j < count_; ++j) {
        factors[i * count_ + j] = form_factor(square(i), square(j));
        if (on_lamp(square(j))) direct_[i] += kLampRadiance * factors[i * count_ + j];
      }
    for (double change = 1; change > 1e-9;) {
      change = 0;
      std::vector<double> next(count_, 0);
      for (size_t i = 0; i < count_; ++i) {
        for (size_t j = 0; j < count_; ++j)
          next[i] += factors[i * count_ + j] * kAlbedos[j / wall_count()] * (direct_[j] + indirect_[j]);
        change = std::max(change, std::abs(next[i] - indirect_[i]));
      }
      indirect_ = std::move(next);
    }
  }
  double indirect(const WallPoint& corner) const {
    const auto cell = [&](double x) { return static_cast<size_t>(std::lround(x * side_)); };
    return indirect_[static_cast<size_t>(corner.wall) * wall_count() + cell(corner.u) * static_cast<size_t>(side_) +
                     cell(corner.v)];
  }

 private:
  size_t wall_count() const { return static_cast<size_t>(side_ * side_); }
  WallSquare square(size_t k) const {
    const size_t in_wall = k % wall_count(), side = static_cast<size_t>(side_);
    return {{static_cast<int>(k / wall_count()), static_cast<double>(in_wall / side) / side_,
             static_cast<double>(in_wall % side) / side_},
            1.0 / side_};
  }
  static bool on_lamp(const WallSquare& s) {
    const double u = s.corner.u + s.edge / 2, v = s.corner.v + s.edge / 2;
    return s.corner.wall == kLamp.corner.wall && u > kLampLow && u < kLampHigh && v > kLampLow && v < kLampHigh;
  }
  /// Gauss-Legendre points of the receiver, closed form over the sender.
  static double form_factor(const WallSquare& receiver, const WallSquare& sender) {
    if (receiver.corner.wall == sender.corner.wall) return 0;
    constexpr std::array<double, 4> kPlaces{0.0694318442, 0.3300094782, 0.6699905218, 0.9305681558};
    constexpr std::array<double, 4> kWeights{0.1739274226, 0.3260725774, 0.3260725774, 0.1739274226};
    double sum = 0;
    for (size_t a = 0; a < 4; ++a)
      for (size_t b = 0; b < 4; ++b)
        sum += kWeights[a] * kWeights[b] * light_of(sender, receiver.at(kPlaces[a], kPlaces[b]));
    return sum;
  }
  int side_;
  size_t count_;
  std::vector<double> direct_, indirect_;
};

}  // namespace lucarium::test::lamp_room
