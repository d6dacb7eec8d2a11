// SPDX-License-Identifier: Apache-2.0
// Which triangles touch which: internal to the surface atlas.
#pragma once
#include <array>
#include <cmath>
#include <glm/glm.hpp>
#include <vector>

#include "lucarium/scene/mesh_topology.h"
#include "lucarium/services/surface_atlas/layout/layout.h"

namespace lucarium {

/// Cosine of an angle in degrees.
inline double cos_degrees(double angle) { return std::cos(angle * 0.017453292519943295); }

/// The geometry with its welded topology. Edge i of a triangle runs from corner i to corner i + 1.
struct AtlasMesh {
  explicit AtlasMesh(const AtlasGeometry& geometry);

  const AtlasGeometry& geometry;
  std::vector<glm::uvec3> welded;                 ///< corners; equal positions of one instance have one number
  std::vector<std::array<uint32_t, 3>> neighbor;  ///< oppositely oriented triangle behind each edge or LUCARIUM_NONE
  std::vector<uint8_t> hard;                      ///< bit i: edge i is a crease that charts do not cross
  std::vector<glm::vec3> normal;                  ///< unit; 0 for slivers, which have none to speak of
  std::vector<double> area;                       ///< [m²]
  /// Rays cannot hit it: it has neither area nor neighbours nor a chart. Where all are such, the first one stays, so
  /// that there is a texel.
  std::vector<uint8_t> left_out;
  std::vector<uint32_t> number;  ///< among those that are not left out

  size_t triangle_count() const { return area.size(); }
  glm::dvec3 position(uint32_t triangle, int corner) const {
    return glm::dvec3(geometry.positions[geometry.triangles[triangle][corner]]);
  }
  bool two_sided(uint32_t triangle) const { return geometry.two_sided[geometry.instance[triangle]] != 0; }
  /// Edge of `triangle` behind which `other` lies; 3 when they are not neighbours.
  int edge_to(uint32_t triangle, uint32_t other) const {
    for (int i = 0; i < 3; ++i)
      if (neighbor[triangle][i] == other) return i;
    return 3;
  }

 private:
  void measure();
  void leave_out();
  void weld();
  void pair_edges();
  void pair_group(const HalfEdge* first, const HalfEdge* last);
  void join(uint32_t half_edge, uint32_t other);
};

/// Splits triangles into parts connected by edges: `part[i]` gets a number in order of first appearance in `triangles`.
/// `place(t)` is t's index in `triangles`, or LUCARIUM_NONE when t is not in it. Returns the number of parts.
uint32_t number_parts(const AtlasMesh& mesh, const std::vector<uint32_t>& triangles,
                      const std::function<uint32_t(uint32_t)>& place, std::vector<uint32_t>& part);

}  // namespace lucarium
