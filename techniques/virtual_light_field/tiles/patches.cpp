// SPDX-License-Identifier: Apache-2.0
//
// How many cells a patch takes. Its projection along a random direction has the mean area A / 2 (Cauchy) and the mean
// perimeter (π / 4) P₃. A grid of tiles of edge m c, placed at random, meets a convex shape of area S' and perimeter P'
// in S' / (m c)² + (2 / π) P' / (m c) + 1 tiles on average. So, in cells,
//
//   cells = S + (2 / π) m P + m²,   S = A / (2 c²),   P = (π / 4) P₃ / c.
#include "virtual_light_field/tiles/patches.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "lucarium/base/luminance.h"
#include "lucarium/base/numbers.h"
#include "lucarium/scene/device/specular_albedo.h"
#include "lucarium/scene/mesh_topology.h"
#include "virtual_light_field/directions/direction_grid.h"
#include "virtual_light_field/tiles/patch_growth.h"

namespace lucarium::vlf {
namespace {

constexpr uint32_t kMinGrid = 2;      // n
constexpr int kAlbedoAverages = 129;  // specular_albedo.clh
constexpr double kCellBytes = 16, kTileBytes = 24,
                 kEntryBytes = 4;  // of a tile: its share of norms, and its place in the list

double bright(const glm::vec3& c) {
  return luminance(static_cast<double>(c.x), static_cast<double>(c.y), static_cast<double>(c.z));
}

/// Cosine-averaged albedo of the reflection lobe (bsdf.clh: bsdf_average_albedo()).
glm::vec3 average_albedo(const std::vector<float>& table, const glm::vec3& f0, float f90, float alpha) {
  const float x = std::sqrt(alpha) * (kAlbedoAverages - 1);
  const int i = std::clamp(static_cast<int>(x), 0, kAlbedoAverages - 2);
  const float f = x - static_cast<float>(i);
  const float e = table[2 * i] * (1 - f) + table[2 * i + 2] * f, b = table[2 * i + 1] * (1 - f) + table[2 * i + 3] * f;
  return f0 * (e - b) + f90 * b;
}

bool keeps_radiance(const glm::vec3& albedo, const glm::vec3& transmission, double least) {
  const double known = bright(albedo) + bright(transmission);
  return known > 0 && known >= least;
}

struct Outline {
  double area = 0, perimeter = 0;
};
/// Of sets of triangles; edges between two triangles of a set do not count.
Outline outline(const PatchMesh& mesh, const uint32_t* begin, const uint32_t* end) {
  Outline result;
  std::vector<glm::vec3> positions;
  std::vector<glm::uvec3> corners;
  for (const uint32_t* t = begin; t != end; ++t) {
    const auto base = static_cast<uint32_t>(positions.size());
    for (const uint32_t v : {mesh.triangles[*t].v0, mesh.triangles[*t].v1, mesh.triangles[*t].v2})
      positions.push_back(mesh.positions[v]);
    corners.emplace_back(base, base + 1, base + 2);
    result.area += mesh.areas[*t];
  }
  const std::vector<uint32_t> welded = weld_positions(positions);
  for (glm::uvec3& c : corners) c = {welded[c.x], welded[c.y], welded[c.z]};
  const std::vector<HalfEdge> edges = sorted_half_edges(corners);
  visit_edges(edges, [&](const HalfEdge* first, const HalfEdge* last) {
    if (last - first == 1)
      result.perimeter += static_cast<double>(glm::length(positions[first->low] - positions[first->high]));
  });
  return result;
}

/// Sides of texels, and what lies on them.
struct AtlasSides {
  uint32_t count, backs;  ///< sides [backs, 2 backs) are backs of [0, backs)
  std::vector<AtlasMaterial> materials;
  std::vector<uint2> ranges;
  std::vector<TexelPiece> pieces;
  std::vector<AtlasTexel> texels;

  explicit AtlasSides(const SurfaceAtlas& atlas)
      : count(atlas.info().texel_count),
        backs(atlas.info().double_sided_count),
        materials(atlas.materials().download()),
        ranges(atlas.ranges().download()),
        pieces(atlas.pieces().download()),
        texels(atlas.texels().download()) {}

  bool is_back(uint32_t side) const { return side >= backs && side < 2 * backs; }
};

/// 1 for sides that reflect and let through at least `least`, and for their other sides.
std::vector<uint8_t> choose_sides(const AtlasSides& sides, double least, std::vector<float4>* albedos) {
  const std::vector<float> table = specular_albedo_table();
  std::vector<uint8_t> chosen(sides.count, 0);
  for (uint32_t side = 0; side < sides.count; ++side) {
    const AtlasMaterial& m = sides.materials[side];
    const glm::vec3 albedo = average_albedo(table, m.f0.xyz(), m.f0.w, m.diffuse.w);
    albedos->emplace_back(albedo, 0.f);
    if (!keeps_radiance(albedo, m.transmission.xyz(), least)) continue;
    chosen[side] = 1;
    if (side < sides.backs) chosen[side + sides.backs] = 1;
    if (sides.is_back(side)) chosen[side - sides.backs] = 1;
  }
  return chosen;
}

/// Triangles of facets, ascending: fronts of patches at even places, each before its back; empty where there is none.
std::vector<std::vector<uint32_t>> collect_members(const AtlasSides& sides, const PatchMesh& mesh,
                                                   const std::vector<uint8_t>& chosen, double cone,
                                                   std::vector<uint32_t>* side_facet) {
  const auto visit = [&](const auto& take) {
    for (uint32_t side = 0; side < sides.count; ++side)
      for (uint32_t i = sides.ranges[side].x; chosen[side] && i < sides.ranges[side].x + sides.ranges[side].y; ++i)
        take(side, sides.pieces[i].triangle);
  };
  std::vector<uint8_t> taken(mesh.triangles.size(), 0);
  visit([&](uint32_t, uint32_t triangle) { taken[triangle] = 1; });
  uint32_t count = 0;
  const std::vector<uint32_t> patch_of = grow_patches(mesh, taken, cone, &count);
  for (uint32_t side = 0; side < sides.count; ++side)
    if (chosen[side]) (*side_facet)[side] = 2 * patch_of[sides.texels[side].triangle] + (sides.is_back(side) ? 1 : 0);
  std::vector<std::vector<uint32_t>> members(2 * size_t{count});
  visit([&](uint32_t side, uint32_t triangle) {
    if (mesh.areas[triangle] > 0) members[(*side_facet)[side]].push_back(triangle);
  });
  for (std::vector<uint32_t>& list : members) {
    std::sort(list.begin(), list.end());
    list.erase(std::unique(list.begin(), list.end()), list.end());
  }
  return members;
}

/// Least GGX width of the sides of each patch; 0 where one shows what is behind it ideally.
std::vector<double> min_widths(const AtlasSides& sides, const std::vector<uint32_t>& side_facet, size_t patches) {
  std::vector<double> result(patches, 1);
  for (uint32_t side = 0; side < sides.count; ++side) {
    if (side_facet[side] == LUCARIUM_NONE) continue;
    const AtlasMaterial& m = sides.materials[side];
    const bool ideal = m.emission.w > 0 && bright(m.transmission.xyz()) > 0;
    double& smallest = result[side_facet[side] / 2];
    smallest = std::min(smallest, ideal ? 0 : static_cast<double>(m.diffuse.w));
  }
  return result;
}

void add_facet(const PatchMesh& mesh, const std::vector<uint32_t>& triangles, bool front, uint32_t level,
               const PatchOptions& options, Patches* result) {
  FieldFacet made{};
  made.first = static_cast<uint32_t>(result->triangles.size());
  made.count = static_cast<uint32_t>(triangles.size());
  made.front = front ? 1 : 0;
  made.tile = tile_of(mesh, triangles, options);
  made.level = level;
  result->facets.push_back(made);
  result->triangles.insert(result->triangles.end(), triangles.begin(), triangles.end());
}

}  // namespace

bool is_tiled(const SceneMaterial& m, double tile_albedo) {
  const glm::vec3 base(m.base_color);
  const float dielectric = glm::pow((m.ior - 1) / (m.ior + 1), 2.f);
  const glm::vec3 f0 = glm::mix(glm::vec3(dielectric), base, m.metallic);
  const float f90 = glm::mix(dielectric > 0 ? 1.f : 0.f, 1.f, m.metallic);
  return keeps_radiance(average_albedo(specular_albedo_table(), f0, f90, m.roughness * m.roughness),
                        (1 - m.metallic) * m.transmission * base, tile_albedo);
}

double expected_cells(double area, double perimeter, double cell, uint32_t tile) {
  const double s = area / (2 * cell * cell), p = pi / 4 * perimeter / cell, m = tile;
  return s + 2 / pi * m * p + m * m;
}

uint32_t best_tile(double area, double perimeter, double cell) {
  uint32_t best = 8;
  double least = std::numeric_limits<double>::infinity();
  for (const uint32_t m : {2u, 4u, 8u, 16u, 32u}) {
    const double cells = expected_cells(area, perimeter, cell, m);
    // The table covers the rectangle about the projection, about twice its area.
    const double tiles = cells / (double{1} * m * m);
    const double bytes = kCellBytes * cells + (kTileBytes + 2 * kEntryBytes) * tiles;
    if (bytes >= least) continue;
    least = bytes;
    best = m;
  }
  return best;
}

uint32_t tile_of(const PatchMesh& mesh, const std::vector<uint32_t>& triangles, const PatchOptions& options) {
  if (options.rows) return 0;
  if (options.tile > 0) return options.tile;
  const Outline shape = outline(mesh, triangles.data(), triangles.data() + triangles.size());
  return best_tile(shape.area, shape.perimeter, options.cell);
}

uint32_t level_of(double alpha, const PatchOptions& options) {
  uint32_t level = 0;
  while (level < options.levels) {
    const uint32_t n = options.dir_n >> (level + 1);
    if (n << (level + 1) != options.dir_n || n < kMinGrid || DirectionGrid::spacing(n) > alpha) break;
    ++level;
  }
  return level;
}

Patches make_patches(const SurfaceAtlas& atlas, const SceneBuffers& buffers, const PatchOptions& options) {
  Patches result;
  const AtlasSides sides(atlas);
  const std::vector<uint8_t> tiled = choose_sides(sides, options.tile_albedo, &result.side_albedo);
  result.side_facet.assign(sides.count, LUCARIUM_NONE);
  if (std::none_of(tiled.begin(), tiled.end(), [](uint8_t t) { return t != 0; })) return result;
  const PatchMesh mesh(buffers);
  const std::vector<std::vector<uint32_t>> members =
      collect_members(sides, mesh, tiled, options.cone, &result.side_facet);
  const std::vector<double> widths = min_widths(sides, result.side_facet, members.size() / 2);
  std::vector<uint32_t> number(members.size(), LUCARIUM_NONE);
  for (uint32_t facet = 0; facet < members.size(); ++facet) {
    if (members[facet].empty()) continue;
    number[facet] = static_cast<uint32_t>(result.facets.size());
    add_facet(mesh, members[facet], facet % 2 == 0, level_of(widths[facet / 2], options), options, &result);
  }
  for (uint32_t& facet : result.side_facet)
    if (facet != LUCARIUM_NONE) facet = number[facet];
  return result;
}

}  // namespace lucarium::vlf
