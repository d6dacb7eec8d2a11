// SPDX-License-Identifier: Apache-2.0
#include "virtual_light_field/directions/direction_grid.h"

#include <algorithm>
#include <cmath>
#include <random>

#include "lucarium/base/numbers.h"
#include "lucarium/shared/hash.h"
#include "lucarium/shared/sobol_points.h"

namespace lucarium::vlf {
namespace {

constexpr uint64_t kRotationStream = 0x726f7461;
constexpr uint64_t kSubfieldStream = 0x66696c6d, kPerturbedStream = 0x70657274;

/// Of [0, 1), the same on every machine.
double uniform(std::mt19937_64& random) { return static_cast<double>(random() >> 11) * 0x1p-53; }

/// A uniform rotation (Shoemake 1992, "Uniform Random Rotations").
glm::dmat3 random_rotation(uint64_t seed) {
  std::mt19937_64 random(seed ^ kRotationStream);
  const double u = uniform(random), a = 2 * pi * uniform(random), b = 2 * pi * uniform(random);
  const double x = std::sqrt(1 - u) * std::sin(a), y = std::sqrt(1 - u) * std::cos(a), z = std::sqrt(u) * std::sin(b),
               w = std::sqrt(u) * std::cos(b);
  return {1 - 2 * (y * y + z * z), 2 * (x * y + w * z),     2 * (x * z - w * y),
          2 * (x * y - w * z),     1 - 2 * (x * x + z * z), 2 * (y * z + w * x),
          2 * (x * z + w * y),     2 * (y * z - w * x),     1 - 2 * (x * x + y * y)};
}

/// Grid axes.
glm::dvec3 sphere_point(double u, double v) {
  const double d = 1 - std::abs(u) - std::abs(v), r = 1 - std::abs(d);
  const double phi = r > 0 ? pi / 4 * (1 + (std::abs(v) - std::abs(u)) / r) : 0;
  const double k = r * std::sqrt(2 - r * r);
  return glm::normalize(glm::dvec3(std::copysign(k * std::cos(phi), u), std::copysign(k * std::sin(phi), v),
                                   std::copysign(1 - r * r, d)));
}

/// Nodes of the square as integers from -n to n.
struct Node {
  int u, v;
};

/// The one of the nodes that are the same direction, which the square's border has: on it (u, v) ≡ (-u, v) or (u, -v).
Node canonical(Node node, int n) {
  if (std::abs(node.v) == n) node.u = std::abs(node.u);
  if (std::abs(node.u) == n) node.v = std::abs(node.v);
  if (std::abs(node.u) == n && std::abs(node.v) == n) return {n, n};
  return node;
}

/// -ω: signs change, and the hemispheres fold into each other.
Node antipode(Node node, int n) {
  const auto sign = [](int x) { return x < 0 ? -1 : 1; };
  // A coordinate of 0 has either sign: both give nodes that are the same direction.
  return {-sign(node.u) * (n - std::abs(node.v)), -sign(node.v) * (n - std::abs(node.u))};
}

/// The same point of the sphere within the square, of one that lies beyond its border.
glm::dvec2 fold(glm::dvec2 at, double n) {
  if (std::abs(at.x) > n) at = {std::copysign(2 * n - std::abs(at.x), at.x), -at.y};
  if (std::abs(at.y) > n) at = {-at.x, std::copysign(2 * n - std::abs(at.y), at.y)};
  return at;
}

/// A point of the unit ball, by three of the coordinates of a point of the unit cube.
glm::dvec3 ball_point(const uint4& bits) {
  const auto unit = [](uint32_t word) { return (static_cast<double>(word) + 0.5) * 0x1p-32; };
  const double z = 2 * unit(bits.y) - 1, r = std::sqrt(1 - z * z), phi = 2 * pi * unit(bits.z);
  return std::cbrt(unit(bits.x)) * glm::dvec3(r * std::cos(phi), r * std::sin(phi), z);
}

/// Share of the way from a node to the edge across its triangles within which the share `mass` of its hat function's
/// integral lies: s with 3 s² - 2 s³ = mass.
double hat_distance(double mass) { return 0.5 - std::sin(std::asin(std::clamp(1 - 2 * mass, -1., 1.)) / 3); }

/// A subfield across `z`.
FieldLine make_line(const glm::dvec3& z, double solid_angle, const Bounds& bounds, uint32_t subfield, double cell,
                    std::mt19937_64& random) {
  const glm::dvec3 center = 0.5 * (glm::dvec3(bounds.min) + glm::dvec3(bounds.max));
  const glm::dvec3 helper = std::abs(z.y) < 0.9 ? glm::dvec3(0, 1, 0) : glm::dvec3(1, 0, 0);
  const glm::dvec3 u = glm::normalize(glm::cross(helper, z)), v = glm::cross(z, u);
  const double angle = 2 * pi * uniform(random);
  const glm::dvec3 x = std::cos(angle) * u + std::sin(angle) * v, y = glm::cross(z, x);
  const auto row = [&](const glm::dvec3& axis, double size, double shift) {
    return float4(glm::vec3(axis / size), static_cast<float>(shift - glm::dot(axis, center) / size));
  };
  FieldLine result;
  result.omega = float4(glm::vec3(z), static_cast<float>(solid_angle));
  result.row_x = row(x, cell, 0.5 * subfield + uniform(random) - 0.5);
  result.row_y = row(y, cell, 0.5 * subfield + uniform(random) - 0.5);
  result.row_w = row(z, 1, 0);
  return result;
}

}  // namespace

DirectionGrid::DirectionGrid(uint32_t n, uint64_t seed) : n_(n), rotation_(random_rotation(seed)) {
  const int size = static_cast<int>(n), side = 2 * size + 1;
  const auto at = [&](Node node) { return static_cast<size_t>(node.v + size) * side + (node.u + size); };
  nodes_.assign(static_cast<size_t>(side) * side, UINT32_MAX);
  const glm::dmat3 to_world = glm::transpose(rotation_);
  for (int v = -size; v <= size; ++v)
    for (int u = -size; u <= size; ++u) {
      const Node node = canonical({u, v}, size);
      if (nodes_[at(node)] == UINT32_MAX) {
        const auto line = static_cast<uint32_t>(omegas_.size());
        nodes_[at(node)] = 2 * line;
        nodes_[at(canonical(antipode(node, size), size))] = 2 * line + 1;
        places_.emplace_back(node.u, node.v);
        omegas_.push_back(to_world *
                          sphere_point(static_cast<double>(node.u) / size, static_cast<double>(node.v) / size));
        const bool corner = (node.u == 0 || std::abs(node.u) == size) && (node.v == 0 || std::abs(node.v) == size);
        solid_angles_.push_back(pi / (static_cast<double>(n) * n) * (corner ? 2. / 3 : 1));
      }
      nodes_[at({u, v})] = nodes_[at(node)];
    }
}

glm::dvec3 DirectionGrid::direction(uint32_t index) const {
  return index & 1 ? -omegas_[index / 2] : omegas_[index / 2];
}

std::vector<uint32_t> DirectionGrid::levels(uint32_t max_level) const {
  std::vector<uint32_t> result(lines(), 0);
  const auto side = 2 * static_cast<size_t>(n_) + 1;
  for (uint32_t level = 1; level <= max_level; ++level)
    for (size_t v = 0; v < side; v += size_t{1} << level)
      for (size_t u = 0; u < side; u += size_t{1} << level) result[nodes_[v * side + u] / 2] = level;
  return result;
}

double DirectionGrid::spacing(uint32_t n) { return std::sqrt(4 * pi / (4. * n * n + 2)); }
double DirectionGrid::spacing() const { return spacing(n_); }

std::vector<glm::dvec2> DirectionGrid::neighbors(uint32_t line) const {
  const double n = n_;
  std::vector<glm::dvec2> result;
  for (const glm::dvec2 corner : {glm::dvec2(1, 1), glm::dvec2(-1, 1), glm::dvec2(-1, -1), glm::dvec2(1, -1)}) {
    const bool even = corner.x * corner.y > 0;
    result.push_back(even ? glm::dvec2(corner.x, 0) : glm::dvec2(0, corner.y));
    // Beyond the border lies a quadrant that is split the other way, turned by half a turn.
    const glm::dvec2 middle = places_[line] + 0.5 * corner;
    const bool beyond = (std::abs(middle.x) > n) != (std::abs(middle.y) > n);
    const bool falling = ((middle.x > 0) == (middle.y > 0)) != beyond;  // split along i + j = const
    if (falling != even) result.push_back(corner);
  }
  return result;
}

std::vector<glm::dvec3> DirectionGrid::directions_about(uint32_t line, uint32_t count, uint64_t seed) const {
  const std::vector<glm::dvec2> fan = neighbors(line);
  // About a corner of the octahedron on the square's border, all four triangles are met twice.
  const size_t triangles = fan.size() == 8 ? 4 : fan.size();
  const auto size = static_cast<double>(triangles);
  const double n = n_;
  const auto point = [&](const glm::dvec2& at) { return sphere_point(at.x / n, at.y / n); };
  const glm::dvec3 own = rotation_ * omegas_[line];
  const glm::dvec3 x = glm::normalize(
                       glm::cross(std::abs(own.z) < 0.9 ? glm::dvec3(0, 0, 1) : glm::dvec3(1, 0, 0), own)),
                   y = glm::cross(own, x);
  const auto angle = [&](const glm::dvec3& along) { return std::atan2(glm::dot(along, y), glm::dot(along, x)); };
  // The angle at which the fan begins, so that on average its sectors lie where their share of a turn does.
  double sine = 0, cosine = 0;
  for (size_t k = 0; k < triangles; ++k) {
    const double off = angle(point(fold(places_[line] + fan[k], n)) - own) - 2 * pi * static_cast<double>(k) / size;
    sine += std::sin(off);
    cosine += std::cos(off);
  }
  const double begin = std::atan2(sine, cosine);

  const uint32_t low = static_cast<uint32_t>(seed), high = static_cast<uint32_t>(seed >> 32);
  const uint4 seeds{hash_uint3(low, high, 1), hash_uint3(low, high, 2), hash_uint3(low, high, 3), 0};
  const glm::dmat3 to_world = glm::transpose(rotation_);
  std::vector<glm::dvec3> result;
  for (uint32_t i = 0; i < count; ++i) {
    const glm::dvec3 moved =
        glm::cross(ball_point(reverse_bits4(owen_scramble_reversed(sobol_reversed(i), seeds))), own);
    const double distance = std::min(glm::length(moved), 1.), inside = 1 - std::pow(1 - distance * distance, 1.5);
    const double turn = (angle(moved) - begin) / (2 * pi), sector = (turn - std::floor(turn)) * size;
    const size_t k = std::min(static_cast<size_t>(sector), triangles - 1);
    const double share = sector - static_cast<double>(k);
    const glm::dvec2 edge = (1 - share) * fan[k] + share * fan[(k + 1) % fan.size()];
    result.push_back(to_world * point(fold(places_[line] + hat_distance(inside) * edge, n)));
  }
  return result;
}

std::vector<FieldLine> make_lines(const DirectionGrid& grid, const Bounds& bounds, uint32_t subfield, double cell,
                                  uint64_t seed) {
  std::mt19937_64 random(seed ^ kSubfieldStream);
  std::vector<FieldLine> lines;
  for (uint32_t line = 0; line < grid.lines(); ++line)
    lines.push_back(make_line(grid.direction(2 * line), grid.solid_angle(2 * line), bounds, subfield, cell, random));
  return lines;
}

std::vector<FieldLine> make_perturbed_lines(const DirectionGrid& grid, uint32_t count, const Bounds& bounds,
                                            uint32_t subfield, double cell, uint64_t seed) {
  std::mt19937_64 random(seed ^ kPerturbedStream);
  std::vector<FieldLine> lines;
  for (uint32_t line = 0; line < grid.lines(); ++line)
    for (const glm::dvec3& direction : grid.directions_about(line, count, seed ^ kPerturbedStream))
      lines.push_back(make_line(direction, grid.solid_angle(2 * line) / count, bounds, subfield, cell, random));
  return lines;
}

}  // namespace lucarium::vlf
