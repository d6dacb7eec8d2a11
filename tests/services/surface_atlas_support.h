// SPDX-License-Identifier: Apache-2.0
// What several tests of the surface atlas need: geometry of scenes, random points, and what must hold of every layout.
#pragma once
#include <doctest/doctest.h>

#include <memory>
#include <random>
#include <string>

#include "lucarium/compute/scheduler.h"
#include "lucarium/scene/load_scene.h"
#include "lucarium/scene/scene_buffers.h"
#include "lucarium/services/surface_atlas_geometry.h"
#include "lucarium/services/surface_atlas_layout.h"

namespace lucarium::test {

inline std::shared_ptr<Device> atlas_device() {
  static const std::shared_ptr<Device> device = Device::open();
  return device;
}

inline AtlasGeometry geometry_of(const Scene& scene, bool use_texcoord1 = false) {
  const SceneBuffers buffers(*atlas_device(), scene);
  return read_atlas_geometry(scene, buffers, use_texcoord1);
}

inline glm::dvec3 corner(const AtlasGeometry& g, uint32_t t, int i) { return glm::dvec3(g.positions[g.triangles[t][i]]); }

inline double area_of(const AtlasGeometry& g, uint32_t t) {
  return 0.5 * glm::length(glm::cross(corner(g, t, 1) - corner(g, t, 0), corner(g, t, 2) - corner(g, t, 0)));
}

inline glm::dvec3 point_on(const AtlasGeometry& g, uint32_t t, float b1, float b2) {
  const glm::dvec3 a = corner(g, t, 0);
  return a + double(b1) * (corner(g, t, 1) - a) + double(b2) * (corner(g, t, 2) - a);
}

/// Area of all reflecting sides [m²].
inline double side_area(const AtlasGeometry& g) {
  double sum = 0;
  for (uint32_t t = 0; t < g.triangles.size(); ++t) sum += area_of(g, t) * (g.two_sided[g.instance[t]] ? 2 : 1);
  return sum;
}

/// A uniform point of a triangle; now and then on an edge or a corner.
struct RandomPoint {
  float b1, b2;
};
inline RandomPoint random_point(std::mt19937& random) {
  std::uniform_real_distribution<float> unit(0.f, 1.f);
  float u = unit(random), v = unit(random);
  if (u + v > 1) u = 1 - u, v = 1 - v;
  switch (random() % 16) {
    case 0: u = 0; break;
    case 1: v = 0; break;
    case 2: v = 1 - u; break;
    case 3: u = float(random() % 2), v = u == 0 ? float(random() % 2) : 0; break;
    default: break;
  }
  return {u, v};
}

}  // namespace lucarium::test
