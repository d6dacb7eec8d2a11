// SPDX-License-Identifier: Apache-2.0
#include "virtual_light_field/tiles/cell_estimate.h"

#include <algorithm>
#include <array>
#include <climits>
#include <cmath>
#include <map>

#include "lucarium/scene/device/emission.h"
#include "virtual_light_field/directions/direction_grid.h"
#include "virtual_light_field/tiles/patch_growth.h"

namespace lucarium::vlf {
namespace {

constexpr uint32_t kFew = 2, kMore = 4;   // n of the directions that are counted
constexpr size_t kManyTriangles = 20000;  // from so many on few directions do
constexpr uint64_t kSeed = 1;
constexpr double kJoinedAngle = 75;  // of normals, beyond which triangles share no texel [degrees]

/// Triangles of a patch; whether their backs are a facet, too.
struct Patch {
  std::vector<uint32_t> triangles;
  bool back = false;
  uint32_t tile = 0, level = 0;
};

/// Small triangles that are likely to share a texel go to the patch that has most of it (patches.h).
void join_in_texels(const PatchMesh& mesh, double texel_edge, std::vector<uint32_t>* patch_of) {
  const double texel = texel_edge * texel_edge;
  const std::vector<uint32_t> surfaces = connected_surfaces(mesh, kJoinedAngle);
  std::vector<double> of_surface(surfaces.size(), 0);
  for (uint32_t t = 0; t < surfaces.size(); ++t) of_surface[surfaces[t]] += mesh.areas[t];
  using Place = std::array<int64_t, 5>;  // surface; side of the normal and position in texel edges where it is large
  const auto place_of = [&](uint32_t t) {
    const Triangle& triangle = mesh.triangles[t];
    if (of_surface[surfaces[t]] <= texel) return Place{surfaces[t], -1, 0, 0, 0};
    const glm::vec3 size = glm::abs(mesh.normals[t]);
    const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    const glm::vec3 sum = mesh.positions[triangle.v0] + mesh.positions[triangle.v1] + mesh.positions[triangle.v2];
    const glm::dvec3 at = glm::dvec3(sum) / (3 * texel_edge);
    return Place{surfaces[t], 2 * axis + (mesh.normals[t][axis] > 0 ? 1 : 0), std::llround(at.x), std::llround(at.y),
                 std::llround(at.z)};
  };
  const auto is_small = [&](uint32_t t) { return mesh.areas[t] > 0 && mesh.areas[t] < texel; };
  std::map<Place, std::map<uint32_t, double>> areas;
  for (uint32_t t = 0; t < surfaces.size(); ++t)
    if (is_small(t)) areas[place_of(t)][(*patch_of)[t]] += mesh.areas[t];
  for (uint32_t t = 0; t < surfaces.size(); ++t) {
    if (!is_small(t)) continue;
    const auto& here = areas[place_of(t)];
    const auto less = [](const auto& a, const auto& b) { return a.second < b.second; };
    (*patch_of)[t] = std::max_element(here.begin(), here.end(), less)->first;
  }
}

/// GGX width of a material where it is certain, else 0.
double min_width(const SceneMaterial& material) {
  if (material.metallic_roughness_texture.texture >= 0 || material.transmission > 0) return 0;
  return static_cast<double>(material.roughness) * static_cast<double>(material.roughness);
}

std::vector<Patch> patches_of(const Scene& scene, const PatchMesh& mesh, const PatchOptions& options,
                              double texel_edge) {
  uint32_t count = 0;
  std::vector<uint32_t> patch_of =
      grow_patches(mesh, std::vector<uint8_t>(mesh.triangles.size(), 1), options.cone, &count);
  join_in_texels(mesh, texel_edge, &patch_of);
  std::vector<Patch> patches(count);
  for (uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    if (!(mesh.areas[t] > 0)) continue;
    Patch& patch = patches[patch_of[t]];
    patch.triangles.push_back(t);
    const SceneMaterial& material = scene.materials[scene.instances[mesh.triangles[t].instance].material];
    patch.back = is_two_sided(material);
    patch.level = level_of(min_width(material), options);
  }
  patches.erase(std::remove_if(patches.begin(), patches.end(), [](const Patch& p) { return p.triangles.empty(); }),
                patches.end());
  for (Patch& patch : patches) patch.tile = tile_of(mesh, patch.triangles, options);
  return patches;
}

/// A triangle on a subfield [cells], with the margin of a cell.
struct Projected {
  std::array<glm::vec2, 3> p;
  glm::vec2 low, high;
};

Projected project(const PatchMesh& mesh, const Triangle& triangle, const FieldLine& line) {
  const auto row = [](const float4& r, const glm::vec3& p) { return r.x * p.x + r.y * p.y + r.z * p.z + r.w; };
  Projected result;
  const std::array<uint32_t, 3> corners{triangle.v0, triangle.v1, triangle.v2};
  for (size_t k = 0; k < 3; ++k)
    result.p[k] = {row(line.row_x, mesh.positions[corners[k]]), row(line.row_y, mesh.positions[corners[k]])};
  result.low = glm::min(result.p[0], glm::min(result.p[1], result.p[2])) - 1.f;
  result.high = glm::max(result.p[0], glm::max(result.p[1], result.p[2])) + 1.f;
  return result;
}

/// build_maps.cl: touches(), of a square that the rectangle about the triangle meets.
bool touches(const Projected& t, const glm::vec2& low, const glm::vec2& high) {
  for (size_t k = 0; k < 3; ++k) {
    const glm::vec2 a = t.p[k], edge = t.p[(k + 1) % 3] - a, other = t.p[(k + 2) % 3] - a;
    glm::vec2 out(edge.y, -edge.x);
    if (glm::dot(out, other) > 0) out = -out;
    const glm::vec2 corner(out.x > 0 ? low.x : high.x, out.y > 0 ? low.y : high.y);
    if (glm::dot(out, corner - a) > glm::length(out)) return false;
  }
  return true;
}

/// build_maps.cl: row_range(), as coordinates.
glm::vec2 row_range(const Projected& t, int y) {
  const float low = static_cast<float>(y - 1), high = static_cast<float>(y + 2);
  glm::vec2 range(INFINITY, -INFINITY);
  for (size_t k = 0; k < 3; ++k) {
    const glm::vec2 &a = t.p[k], &b = t.p[(k + 1) % 3];
    if (std::max(a.y, b.y) < low || std::min(a.y, b.y) > high) continue;
    const bool level = std::abs(b.y - a.y) < 1e-3f;
    const float slope = level ? 0 : (b.x - a.x) / (b.y - a.y);
    const float from = level ? a.x : a.x + slope * (std::clamp(a.y, low, high) - a.y);
    const float to = level ? b.x : a.x + slope * (std::clamp(b.y, low, high) - a.y);
    range = {std::min(range.x, std::min(from, to)), std::max(range.y, std::max(from, to))};
  }
  return range;
}

/// What one map has: of the side of a patch that a direction sees.
class MapCounter {
 public:
  MapCounter(uint32_t subfield, uint32_t tile) : subfield_(subfield), tile_(static_cast<int>(tile)) {}

  void count(const std::vector<Projected>& triangles, CellCounts* sums) {
    glm::ivec4 all(INT_MAX, INT_MAX, -1, -1);
    for (const Projected& t : triangles) {
      const glm::ivec4 r = range(t);
      all = {std::min(all.x, r.x), std::min(all.y, r.y), std::max(all.z, r.z), std::max(all.w, r.w)};
    }
    if (all.z < 0) return;
    if (tile_ == 0)
      rows(triangles, all, sums);
    else
      tiles(triangles, all, sums);
  }

 private:
  glm::ivec4 range(const Projected& t) const {
    const float last = static_cast<float>(subfield_ - 1);
    const glm::vec2 low = glm::clamp(t.low, 0.f, last), high = glm::clamp(t.high, 0.f, last);
    return glm::ivec4(low.x, low.y, high.x, high.y) / std::max(tile_, 1);
  }

  void tiles(const std::vector<Projected>& triangles, const glm::ivec4& all, CellCounts* sums) {
    const int w = all.z - all.x + 1, h = all.w - all.y + 1;
    marks_.assign(static_cast<size_t>(w) * h, 0);
    const float m = static_cast<float>(tile_);
    for (const Projected& t : triangles) {
      const glm::ivec4 r = range(t);
      for (int y = r.y; y <= r.w; ++y)
        for (int x = r.x; x <= r.z; ++x)
          if (touches(t, m * glm::vec2(x, y), m * glm::vec2(x + 1, y + 1)))
            marks_[static_cast<size_t>(y - all.y) * w + (x - all.x)] = 1;
    }
    const auto marked = static_cast<double>(std::count(marks_.begin(), marks_.end(), 1));
    sums->tiles += marked;
    sums->cells += marked * tile_ * tile_;
    sums->entries += static_cast<double>(marks_.size());
  }

  void rows(const std::vector<Projected>& triangles, const glm::ivec4& all, CellCounts* sums) {
    const size_t h = static_cast<size_t>(all.w) - static_cast<size_t>(all.y) + 1;
    std::vector<glm::vec2> ends(h, glm::vec2(INFINITY, -INFINITY));
    for (const Projected& t : triangles) {
      const glm::ivec4 r = range(t);
      for (int y = r.y; y <= r.w; ++y) {
        const glm::vec2 row = row_range(t, y);
        glm::vec2& end = ends[static_cast<size_t>(y - all.y)];
        end = {std::min(end.x, row.x), std::max(end.y, row.y)};
      }
    }
    const float last = static_cast<float>(subfield_ - 1);
    for (const glm::vec2& end : ends) {
      if (end.x > end.y) continue;
      sums->cells += std::floor(static_cast<double>(std::clamp(end.y + 1, 0.f, last))) -
                     std::floor(static_cast<double>(std::clamp(end.x - 1, 0.f, last))) + 1;
      sums->tiles += 1;
    }
    sums->entries += 2 * static_cast<double>(h);
  }

  uint32_t subfield_;
  int tile_;  ///< 0: rows
  std::vector<uint8_t> marks_;
};

}  // namespace

CellCounts expect_cells(const Scene& scene, const std::vector<uint8_t>& tiled, const PatchOptions& options,
                        double texel_edge, uint32_t subfield, uint32_t dir_n) {
  const PatchMesh mesh(scene, tiled);
  const std::vector<Patch> patches = patches_of(scene, mesh, options, texel_edge);
  const DirectionGrid few(std::min(dir_n, mesh.triangles.size() < kManyTriangles ? kMore : kFew), kSeed);
  const double directions = 4. * dir_n * dir_n + 2;
  std::vector<CellCounts> by_level(options.levels + 1);
  std::vector<Projected> sides[2];
  for (const FieldLine& line : make_lines(few, scene.bounds(), subfield, options.cell, kSeed))
    for (const Patch& patch : patches) {
      for (auto& side : sides) side.clear();
      for (const uint32_t t : patch.triangles)
        sides[glm::dot(mesh.normals[t], line.omega.xyz()) > 0].push_back(project(mesh, mesh.triangles[t], line));
      MapCounter counter(subfield, patch.tile);
      // The front is seen from a direction and the back from its opposite, and the other way round.
      for (const auto& side : sides)
        for (int facet = 0; facet < (patch.back ? 2 : 1); ++facet) counter.count(side, &by_level[patch.level]);
    }
  CellCounts sums;
  for (const Patch& patch : patches) sums.maps += patch.back ? 2 : 1;
  sums.maps *= directions;
  for (uint32_t level = 0; level < by_level.size(); ++level) {
    const uint32_t n = dir_n >> level;
    const double times = (4. * n * n + 2) / few.directions();
    sums.cells += times * by_level[level].cells;
    sums.tiles += times * by_level[level].tiles;
    sums.entries += times * by_level[level].entries;
    if (level > 0) sums.coarse_cells += times * by_level[level].cells;
  }
  return sums;
}

}  // namespace lucarium::vlf
