// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "lucarium/scene/scene.h"
#include "virtual_light_field/shared/field.h"

namespace lucarium::vlf {

/// The fixed directions of the field, each with a parallel subfield (Mortensen et al. 2007, section 2.1): nodes of an
/// equal-area octahedral grid, n cells per edge of the octahedron, turned at random. 4 n² + 2 directions on 2 n² + 1
/// lines, closed under ω → -ω; the grid n / 2 is every second node.
///
/// The map: a point (u, v) of [-1, 1]² with d = 1 - |u| - |v|, r = 1 - |d|, φ = π/4 (1 + (|v| - |u|) / r),
/// k = r √(2 - r²) is ω = (sgn(u) k cos φ, sgn(v) k sin φ, sgn(d) (1 - r²)). Every triangle of the grid covers π / 2 n²
/// of solid angle, so that the hat function of a node has the integral π / n², and 2 π / 3 n² at the six corners of the
/// octahedron, where four triangles meet instead of six. They sum to 4 π.
class DirectionGrid {
 public:
  /// `n`: 2 to 64. The same seed gives the same directions for n and n / 2.
  DirectionGrid(uint32_t n, uint64_t seed);

  uint32_t n() const { return n_; }
  uint32_t lines() const { return 2 * n_ * n_ + 1; }
  uint32_t directions() const { return 2 * lines(); }
  /// Unit vector, world space, of direction 2 · line, or 2 · line + 1, which is opposite.
  glm::dvec3 direction(uint32_t index) const;
  /// Integral of the hat function of a direction [sr].
  double solid_angle(uint32_t index) const { return solid_angles_[index / 2]; }
  /// Direction of each node of the square, (2 n + 1)², row by row.
  const std::vector<uint32_t>& nodes() const { return nodes_; }
  /// `count` directions about that of direction 2 · line, with the density h / ∫ h, h its hat function: perturbed
  /// directions (Mortensen et al. 2007, section 3.5; there uniform over the solid angle of the direction). Those of all
  /// lines and their opposites cover the sphere uniformly when they count ∫ h / count each.
  ///
  /// The i-th directions of all lines are the whole grid, turned about one axis r, a point of the unit ball by `seed`
  /// and i, a little more or less by latitude: a direction ω moves along r × ω, as far as the distribution of |r × ω|
  /// asks for. That keeps solid angles, so that they are a set of directions as even as the grid itself.
  std::vector<glm::dvec3> directions_about(uint32_t line, uint32_t count, uint64_t seed) const;
  /// Per line the greatest level up to `max_level` whose grid n / 2^level has it; 0: this one alone. n divides by
  /// 2^max_level.
  std::vector<uint32_t> levels(uint32_t max_level) const;
  /// World to the axes of the grid.
  const glm::dmat3& rotation() const { return rotation_; }
  /// Distance between neighbours [rad]: δ = √(4 π / directions).
  double spacing() const;
  static double spacing(uint32_t n);

 private:
  /// Steps in the square from the node of a line to those with which it has triangles, in their order around it. Beyond
  /// the border they lead to nodes that fold() finds.
  std::vector<glm::dvec2> neighbors(uint32_t line) const;

  uint32_t n_;
  glm::dmat3 rotation_{1};
  std::vector<glm::dvec3> omegas_;  ///< per line
  std::vector<glm::dvec2> places_;  ///< per line: one of its nodes, in units of cells
  std::vector<double> solid_angles_;
  std::vector<uint32_t> nodes_;
};

/// Subfields of lines: N × N cells of edge `cell` that hold the bounding sphere of the scene, turned and shifted at
/// random. `seed`: as of the grid.
std::vector<FieldLine> make_lines(const DirectionGrid& grid, const Bounds& bounds, uint32_t subfield, double cell,
                                  uint64_t seed);

/// The same of `count` directions about each line, those of a line behind each other. omega.w is its share of the
/// line's solid angle.
std::vector<FieldLine> make_perturbed_lines(const DirectionGrid& grid, uint32_t count, const Bounds& bounds,
                                            uint32_t subfield, double cell, uint64_t seed);

}  // namespace lucarium::vlf
