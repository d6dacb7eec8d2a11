// SPDX-License-Identifier: Apache-2.0
#include "lucarium/services/surface_atlas/estimate.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "lucarium/services/surface_atlas/geometry.h"
#include "lucarium/services/surface_atlas/layout/chart.h"
#include "lucarium/services/surface_atlas/layout/mesh.h"

namespace lucarium {
namespace {

constexpr double slack = 9. / 8;     // by which a wanted count is missed at the most
constexpr double joined_angle = 75;  // of normals, beyond which triangles share no texel [degrees]

constexpr double all_slivers = 0.75;  // of the area: beyond a half slivers count in full, in texels that vary in width

/// Triangles that may share a texel when texels are large.
struct Surface {
  double area = 0;                            ///< of one side [m²]
  double border = 0;                          ///< [m]
  glm::dvec3 low{INFINITY}, high{-INFINITY};  ///< [m]
  int sides = 0;                              ///< 0: no surface
};

std::vector<Surface> find_surfaces(const AtlasGeometry& geometry) {
  const AtlasMesh mesh(geometry);
  const double min_cosine = cos_degrees(joined_angle);
  const uint32_t count = static_cast<uint32_t>(mesh.triangle_count());
  std::vector<uint32_t> parent(count);
  std::iota(parent.begin(), parent.end(), 0);
  const auto joins = [&](uint32_t t, uint32_t other) {
    if (other == LUCARIUM_NONE) return false;
    const glm::vec3 &a = mesh.normal[t], &b = mesh.normal[other];
    return a == glm::vec3(0) || b == glm::vec3(0) || double(glm::dot(a, b)) >= min_cosine;
  };
  for (uint32_t t = 0; t < count; ++t)
    for (const uint32_t other : mesh.neighbor[t])
      if (joins(t, other)) parent[find_root(parent, t)] = find_root(parent, other);
  std::vector<Surface> surfaces(count);
  for (uint32_t t = 0; t < count; ++t) {
    if (mesh.left_out[t]) continue;
    Surface& surface = surfaces[find_root(parent, t)];
    surface.area += mesh.area[t];
    surface.sides = mesh.two_sided(t) ? 2 : 1;
    for (int i = 0; i < 3; ++i) {
      const glm::dvec3 p = mesh.position(t, i);
      surface.low = glm::min(surface.low, p), surface.high = glm::max(surface.high, p);
      if (!joins(t, mesh.neighbor[t][i])) surface.border += glm::length(mesh.position(t, (i + 1) % 3) - p);
    }
  }
  return surfaces;
}

/// What small surfaces have besides the wanted sides: one each, and where long ones are slivers (layout.cpp) as many as
/// lie along them, for other surfaces keep half of the wanted number whatever slivers have. Where slivers are half of
/// all area they count in full, so that they become no longer than texels.
double sides_of_small(const std::vector<Surface>& surfaces, double area, double edge) {
  struct Sliver {
    double edge, area, along;  ///< from which edge on it is one [m], of its sides [m²], texel sides then
  };
  std::vector<Sliver> slivers;
  double sum = 0;
  for (const Surface& surface : surfaces) {
    if (surface.sides == 0 || surface.area > edge * edge) continue;
    sum += surface.sides;
    if (glm::length(surface.high - surface.low) <= 2 * edge) continue;
    // Along half of its border lie border / 2 s texels of 2 s area / border each; below s²/64 they are slivers. Its
    // tips are sooner.
    const double from = std::max(edge, 0.5 * 128 * surface.area / surface.border);
    slivers.push_back({from, surface.sides * surface.area, surface.sides * surface.border / (2 * from)});
  }
  std::sort(slivers.begin(), slivers.end(), [](const Sliver& a, const Sliver& b) { return a.edge < b.edge; });
  double before = 0;
  for (const Sliver& sliver : slivers) {
    if (before > all_slivers * area) break;
    before += sliver.area, sum += sliver.along;
  }
  return sum;
}

/// `largest`: the largest number, otherwise the likely one.
double sides_of(const std::vector<Surface>& surfaces, double area, const AtlasLayoutOptions& options, bool largest) {
  const double over = largest ? slack : 1, free = largest ? 1. / 8 : 0;
  const double wanted = wanted_sides(area, options);
  if (options.texel_edge > 0) {
    double sum = over * wanted;
    for (const Surface& surface : surfaces) sum += surface.sides * (1 + surface.border / (2 * options.texel_edge));
    return sum;
  }
  const double more = sides_of_small(surfaces, area, std::sqrt(area / wanted));
  // As layout.cpp charges for slivers: an eighth is free, and those beyond leave the others half of the wanted number.
  return std::max((over + free) * wanted, over / 2 * wanted + more);
}

}  // namespace

double reflecting_area(const Scene& scene) {
  double sum = 0;
  const std::vector<uint8_t> two_sided = two_sided_instances(scene);
  for (size_t i = 0; i < scene.instances.size(); ++i) {
    const SceneInstance& instance = scene.instances[i];
    const Mesh& mesh = instance.shape(scene);
    const glm::mat3 linear(instance.world_from_object);
    double area = 0;
    for (const glm::uvec3& t : mesh.triangles) {
      const glm::vec3 a = mesh.positions[t.x];
      const glm::vec3 e1 = linear * (mesh.positions[t.y] - a), e2 = linear * (mesh.positions[t.z] - a);
      area += 0.5 * static_cast<double>(glm::length(glm::cross(e1, e2)));
    }
    sum += area * (two_sided[i] ? 2 : 1);
  }
  return sum;
}

double wanted_sides(double area, const AtlasLayoutOptions& options) {
  if (options.texel_edge > 0) return area / (options.texel_edge * options.texel_edge);
  return static_cast<double>(std::max<uint64_t>(1, options.texel_count));
}

double count_sides(const AtlasGeometry& geometry, const AtlasLayoutOptions& options, bool largest) {
  const std::vector<Surface> surfaces = find_surfaces(geometry);
  double area = 0;
  for (const Surface& surface : surfaces) area += surface.sides * surface.area;
  return sides_of(surfaces, area, options, largest);
}

double count_sides(const Scene& scene, const AtlasLayoutOptions& options, bool largest) {
  AtlasGeometry geometry;
  for (uint32_t i = 0; i < scene.instances.size(); ++i) {
    const Mesh& mesh = scene.instances[i].shape(scene);
    const uint32_t first = static_cast<uint32_t>(geometry.positions.size());
    for (const glm::vec3& p : mesh.positions)
      geometry.positions.emplace_back(scene.instances[i].world_from_object * glm::vec4(p, 1));
    for (const glm::uvec3& t : mesh.triangles) geometry.triangles.push_back(t + first);
    geometry.instance.insert(geometry.instance.end(), mesh.triangles.size(), i);
  }
  geometry.normals.resize(geometry.positions.size());  // of which no texel depends
  geometry.two_sided = two_sided_instances(scene);
  return count_sides(geometry, options, largest);
}

}  // namespace lucarium
