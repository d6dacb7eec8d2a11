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
#include <numeric>

#include "lucarium/base/luminance.h"
#include "lucarium/base/numbers.h"
#include "lucarium/scene/device/degenerate_triangle.h"
#include "lucarium/scene/device/specular_albedo.h"
#include "lucarium/scene/mesh_topology.h"

namespace lucarium::vlf {
namespace {

constexpr int kAlbedoAverages = 129;  // specular_albedo.clh
constexpr double kCellBytes = 16, kTileBytes = 24,
                 kEntryBytes = 4;  // of a tile: its share of norms, and its place in the list
constexpr double kFlat = 1e-4;     // of 1 - cos: within it normals are equal

double bright(const glm::vec3& c) {
  return luminance(static_cast<double>(c.x), static_cast<double>(c.y), static_cast<double>(c.z));
}

/// Cosine-averaged albedo of the reflection lobe (bsdf.clh: bsdf_average_albedo()).
glm::vec3 average_albedo(const std::vector<float>& table, const AtlasMaterial& material) {
  const float x = std::sqrt(material.diffuse.w) * (kAlbedoAverages - 1);
  const int i = std::clamp(static_cast<int>(x), 0, kAlbedoAverages - 2);
  const float f = x - static_cast<float>(i);
  const float e = table[2 * i] * (1 - f) + table[2 * i + 2] * f, b = table[2 * i + 1] * (1 - f) + table[2 * i + 3] * f;
  return material.f0.xyz() * (e - b) + material.f0.w * b;
}

struct Mesh {
  std::vector<Triangle> triangles;
  std::vector<glm::vec3> positions, normals;  ///< per vertex; per triangle, 0 without area
  std::vector<double> areas;

  explicit Mesh(const SceneBuffers& buffers) : triangles(buffers.scene_triangles.download()) {
    for (const Vertex& v : buffers.scene_vertices.download()) positions.push_back(v.position.xyz());
    for (const Triangle& t : triangles) {
      const glm::vec3 &a = positions[t.v0], &b = positions[t.v1], &c = positions[t.v2];
      const glm::vec3 cross = glm::cross(b - a, c - a);
      const float length = glm::length(cross);
      const bool flat = is_degenerate(a, b, c) || !(length > 0);
      normals.push_back(flat ? glm::vec3(0) : cross / length);
      areas.push_back(flat ? 0. : 0.5 * static_cast<double>(length));
    }
  }
};

/// Triangles across each triangle's edges, in one list.
struct Neighbors {
  std::vector<uint32_t> first, other;

  Neighbors(const Mesh& mesh, const std::vector<uint8_t>& taken) {
    const std::vector<uint32_t> welded = weld_positions(mesh.positions);
    std::vector<glm::uvec3> corners;
    std::vector<uint32_t> names;
    for (uint32_t t = 0; t < mesh.triangles.size(); ++t)
      if (taken[t] && mesh.areas[t] > 0) {
        corners.emplace_back(welded[mesh.triangles[t].v0], welded[mesh.triangles[t].v1], welded[mesh.triangles[t].v2]);
        names.push_back(t);
      }
    std::vector<std::pair<uint32_t, uint32_t>> pairs;
    const std::vector<HalfEdge> edges = sorted_half_edges(corners);
    visit_edges(edges, [&](const HalfEdge* begin, const HalfEdge* end) {
      for (const HalfEdge* a = begin; a != end; ++a)
        for (const HalfEdge* b = begin; b != end; ++b)
          if (a->triangle != b->triangle && run_opposite(corners, *a, *b))
            pairs.emplace_back(names[a->triangle], names[b->triangle]);
    });
    std::sort(pairs.begin(), pairs.end());
    first.assign(mesh.triangles.size() + 1, 0);
    for (const auto& [a, b] : pairs) {
      ++first[a + 1];
      other.push_back(b);
    }
    std::partial_sum(first.begin(), first.end(), first.begin());
  }
};

/// Patch of each triangle that is taken: connected sets of one instance around the largest triangle that is left.
std::vector<uint32_t> grow_patches(const Mesh& mesh, const std::vector<uint8_t>& taken, double cone, uint32_t* count) {
  const Neighbors neighbors(mesh, taken);
  const double least = std::cos(cone * pi / 180) - kFlat;
  std::vector<uint32_t> order, result(mesh.triangles.size(), LUCARIUM_NONE), open;
  for (uint32_t t = 0; t < mesh.triangles.size(); ++t)
    if (taken[t]) order.push_back(t);
  std::stable_sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) { return mesh.areas[a] > mesh.areas[b]; });
  *count = 0;
  for (const uint32_t seed : order) {
    if (result[seed] != LUCARIUM_NONE) continue;
    const uint32_t patch = (*count)++;
    result[seed] = patch;
    open.assign(1, seed);
    for (size_t i = 0; i < open.size(); ++i)
      for (uint32_t k = neighbors.first[open[i]]; k < neighbors.first[open[i] + 1]; ++k) {
        const uint32_t t = neighbors.other[k];
        if (result[t] != LUCARIUM_NONE || mesh.triangles[t].instance != mesh.triangles[seed].instance ||
            static_cast<double>(glm::dot(mesh.normals[t], mesh.normals[seed])) < least)
          continue;
        result[t] = patch;
        open.push_back(t);
      }
  }
  return result;
}

struct Outline {
  double area = 0, perimeter = 0;
};
/// Of sets of triangles; edges between two triangles of a set do not count.
Outline outline(const Mesh& mesh, const uint32_t* begin, const uint32_t* end) {
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
    const glm::vec3 albedo = average_albedo(table, sides.materials[side]);
    albedos->emplace_back(albedo, 0.f);
    const double known = bright(albedo) + bright(sides.materials[side].transmission.xyz());
    if (!(known > 0 && known >= least)) continue;
    chosen[side] = 1;
    if (side < sides.backs) chosen[side + sides.backs] = 1;
    if (sides.is_back(side)) chosen[side - sides.backs] = 1;
  }
  return chosen;
}

/// Triangles of facets, ascending: fronts of patches at even places, each before its back; empty where there is none.
std::vector<std::vector<uint32_t>> collect_members(const AtlasSides& sides, const Mesh& mesh,
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

void add_facet(const Mesh& mesh, const std::vector<uint32_t>& triangles, bool front, const PatchOptions& options,
               Patches* result) {
  FieldFacet made{};
  made.first = static_cast<uint32_t>(result->triangles.size());
  made.count = static_cast<uint32_t>(triangles.size());
  made.front = front ? 1 : 0;
  made.tile = options.rows ? 0 : options.tile;
  if (options.tile == 0 && !options.rows) {
    const Outline shape = outline(mesh, triangles.data(), triangles.data() + triangles.size());
    made.tile = best_tile(shape.area, shape.perimeter, options.cell);
  }
  result->facets.push_back(made);
  result->triangles.insert(result->triangles.end(), triangles.begin(), triangles.end());
}

}  // namespace

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

Patches make_patches(const SurfaceAtlas& atlas, const SceneBuffers& buffers, const PatchOptions& options) {
  Patches result;
  const AtlasSides sides(atlas);
  const std::vector<uint8_t> tiled = choose_sides(sides, options.tile_albedo, &result.side_albedo);
  result.side_facet.assign(sides.count, LUCARIUM_NONE);
  if (std::none_of(tiled.begin(), tiled.end(), [](uint8_t t) { return t != 0; })) return result;
  const Mesh mesh(buffers);
  const std::vector<std::vector<uint32_t>> members =
      collect_members(sides, mesh, tiled, options.cone, &result.side_facet);
  std::vector<uint32_t> number(members.size(), LUCARIUM_NONE);
  for (uint32_t facet = 0; facet < members.size(); ++facet) {
    if (members[facet].empty()) continue;
    number[facet] = static_cast<uint32_t>(result.facets.size());
    add_facet(mesh, members[facet], facet % 2 == 0, options, &result);
  }
  for (uint32_t& facet : result.side_facet)
    if (facet != LUCARIUM_NONE) facet = number[facet];
  return result;
}

}  // namespace lucarium::vlf
