// SPDX-License-Identifier: Apache-2.0
#include "micro_rendering/points/point_sampling.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <glm/glm.hpp>
#include <numeric>

#include "lucarium/base/parallel.h"
#include "lucarium/shared/hash.h"
#include "lucarium/shared/triangle_map.h"
#include "micro_rendering/points/morton.h"
#include "micro_rendering/points/point_grid.h"

namespace lucarium::micro {
namespace {

constexpr uint32_t kFirstRound = 64;
constexpr uint32_t kCandidates = 8;
constexpr uint32_t kRejections = 4096;  // draws for a candidate that is there, before one is taken as it is
constexpr uint32_t kSubRounds = 8;

double side_area(const SurfaceSide& side) {
  return 0.5 * glm::length(glm::dvec3(glm::cross(glm::dvec3(side.v1 - side.v0), glm::dvec3(side.v2 - side.v0))));
}

/// Sides in Morton order of their centroids, and the running sum of their covered areas.
struct AreaTable {
  struct Face {
    const SurfaceSide* side;
    glm::vec3 normal;
    float area;
    explicit Face(const SurfaceSide& of) : side(&of) {
      const glm::vec3 n = glm::cross(of.v1 - of.v0, of.v2 - of.v0);
      const float length = glm::length(n);
      normal = length > 0 ? (of.back ? -n : n) / length : glm::vec3(0, 0, 1);
      area = 0.5f * length;
    }
  };
  std::vector<Face> faces;
  std::vector<double> upper;    ///< covered area up to and including a side
  std::vector<uint32_t> guide;  ///< first side whose upper exceeds g / guide size of the area
  double guides_per_area = 0;

  explicit AreaTable(const std::vector<SurfaceSide>& given) {
    glm::vec3 low(INFINITY), high(-INFINITY);
    for (const SurfaceSide& s : given) {
      const glm::vec3 c = (s.v0 + s.v1 + s.v2) / 3.f;
      low = glm::min(low, c), high = glm::max(high, c);
    }
    std::vector<std::pair<uint32_t, uint32_t>> order(given.size());
    const glm::vec3 extent = high - low;
    const float scale = 1 / std::max({extent.x, extent.y, extent.z, 1e-30f});
    for (uint32_t i = 0; i < given.size(); ++i)
      order[i] = {morton_code(((given[i].v0 + given[i].v1 + given[i].v2) / 3.f - low) * scale), i};
    std::sort(order.begin(), order.end());
    double sum = 0;
    for (const auto& [code, i] : order) {
      faces.emplace_back(given[i]);
      upper.push_back(sum += side_area(given[i]) * given[i].coverage);
    }
    guide.resize(std::bit_ceil(given.size()));
    if (sum > 0) guides_per_area = static_cast<double>(guide.size()) / sum;
    uint32_t side = 0;
    for (size_t g = 0; g < guide.size(); ++g) {
      const double a = sum * static_cast<double>(g) / static_cast<double>(guide.size());
      while (side + 1 < upper.size() && upper[side] <= a) ++side;
      guide[g] = side;
    }
  }

  double total() const { return upper.empty() ? 0 : upper.back(); }

  /// The face that holds the point `a` of the total area.
  const Face& find(double a) const {
    if (total() <= 0) return faces.front();
    const size_t g = std::min(static_cast<size_t>(a * guides_per_area), guide.size() - 1);
    uint32_t i = guide[g];
    while (i > 0 && upper[i - 1] > a) --i;
    while (i + 1 < upper.size() && upper[i] <= a) ++i;
    return faces[i];
  }
};

/// A point of a face; false where a test says that it is not there.
bool place(const AreaTable::Face& face, glm::vec2 weights, float random, PointTest test, const void* context,
           SampledPoint& point) {
  const SurfaceSide& side = *face.side;
  if (test && side.coverage < 1 && !test(context, side.source, weights, random)) return false;
  point.position = side.v0 + weights.x * (side.v1 - side.v0) + weights.y * (side.v2 - side.v0);
  point.weights = weights;
  point.source = side.source;
  point.normal = face.normal;
  point.area = face.area;
  return true;
}

}  // namespace

double covered_area(const std::vector<SurfaceSide>& sides) {
  return std::accumulate(sides.begin(), sides.end(), 0.0,
                         [](double sum, const SurfaceSide& s) { return sum + side_area(s) * s.coverage; });
}

SampledSurface sample_surface(const std::vector<SurfaceSide>& sides, uint32_t count, uint32_t seed, int threads,
                              PointTest test, const void* test_context, const std::function<void(uint32_t)>& progress) {
  SampledSurface result;
  const AreaTable table(sides);
  result.area = table.total();
  std::vector<SampledPoint>& points = result.points;
  points.resize(count);
  PointGrid grid(count);

  // Point `first + i` owns part i of `strata` equal parts of the area.
  const auto sample = [&](uint32_t first, uint32_t i, uint32_t strata) {
    // Draw candidates within the part, and keep the one farthest from all points so far (best candidate).
    std::array<SampledPoint, kCandidates> candidates;
    std::array<PointGrid::Look, kCandidates> looks;
    for (uint32_t k = 0; k < kCandidates; ++k) {
      for (uint32_t attempt = 0; attempt < kRejections; ++attempt) {
        const uint4 r = hash_uint4({seed, first + i, k, attempt});
        const double a = table.total() * (i + static_cast<double>(r.x) * 0x1p-32) / strata;
        const float2 weights = sample_triangle({uint_to_unit(r.y), uint_to_unit(r.z)});
        if (place(table.find(a), {weights.x, weights.y}, uint_to_unit(r.w), attempt + 1 < kRejections ? test : nullptr,
                  test_context, candidates[k]))
          break;
      }
      looks[k] = grid.look_from(candidates[k].position, candidates[k].normal);
    }
    points[first + i] = candidates[grid.farthest(looks)];
    grid.set(first + i, points[first + i].position, points[first + i].normal);
  };

  for (uint32_t first = 0; first < count;) {
    const uint32_t strata = std::min(first == 0 ? kFirstRound : first, count - first);
    const double spacing = std::sqrt(table.total() / strata);  // of the points so far, except in the first round
    grid.rebuild(first, static_cast<float>(std::max(spacing, 1e-20)));
    for (uint32_t sub = 0; sub < kSubRounds; ++sub) {
      const uint32_t members = (strata + kSubRounds - 1 - sub) / kSubRounds;
      parallel_for(members, threads, [&](uint32_t m) { sample(first, sub + kSubRounds * m, strata); });
      throw_if_interrupted("points on surfaces");
      for (uint32_t m = 0; m < members; ++m) grid.insert(first + sub + kSubRounds * m);
      if (progress) progress(first + strata / kSubRounds * (sub + 1));
    }
    first += strata;
  }
  return result;
}

}  // namespace lucarium::micro
