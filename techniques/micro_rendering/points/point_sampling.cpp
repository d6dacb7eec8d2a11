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

namespace lucarium::micro {
namespace {

constexpr uint32_t kFirstRound = 64;
constexpr uint32_t kCandidates = 8;
constexpr uint32_t kRejections = 4096;  // draws for a candidate that is there, before one is taken as it is
constexpr uint32_t kSubRounds = 8;
constexpr float kApart =
    8;  // how much farther a point counts that lies before or behind another: parallel layers leave each other alone
constexpr uint32_t kNone = 0xffffffffu;

double side_area(const SurfaceSide& side) {
  return 0.5 * glm::length(glm::dvec3(glm::cross(glm::dvec3(side.v1 - side.v0), glm::dvec3(side.v2 - side.v0))));
}

/// Sides in Morton order of their centroids, and the running sum of their covered areas.
struct AreaTable {
  std::vector<const SurfaceSide*> sides;
  std::vector<double> upper;    ///< covered area up to and including a side
  std::vector<uint32_t> guide;  ///< first side whose upper exceeds g / guide size of the area

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
      sides.push_back(&given[i]);
      upper.push_back(sum += side_area(given[i]) * given[i].coverage);
    }
    guide.resize(std::bit_ceil(given.size()));
    uint32_t side = 0;
    for (size_t g = 0; g < guide.size(); ++g) {
      const double a = sum * static_cast<double>(g) / static_cast<double>(guide.size());
      while (side + 1 < upper.size() && upper[side] <= a) ++side;
      guide[g] = side;
    }
  }

  double total() const { return upper.empty() ? 0 : upper.back(); }

  /// The side that holds the point `a` of the total area.
  const SurfaceSide& find(double a) const {
    if (total() <= 0) return *sides.front();
    const size_t g = std::min(static_cast<size_t>(a / total() * static_cast<double>(guide.size())), guide.size() - 1);
    uint32_t i = guide[g];
    while (i > 0 && upper[i - 1] > a) --i;
    while (i + 1 < upper.size() && upper[i] <= a) ++i;
    return *sides[i];
  }
};

/// Points found so far, in a hash grid whose cells hold chains.
class PointGrid {
 public:
  explicit PointGrid(uint32_t capacity) : next_(capacity) {}

  /// Empties the grid and puts points [0, count) into cells of this size.
  void rebuild(const std::vector<SampledPoint>& points, uint32_t count, float cell) {
    cell_ = std::max(cell, 1e-30f);  // 0: surfaces without area
    inverse_ = 1 / cell_;
    head_.assign(std::bit_ceil(size_t{4} * count + 64), kNone);
    for (uint32_t i = 0; i < count; ++i) insert(points, i);
  }
  void insert(const std::vector<SampledPoint>& points, uint32_t i) {
    uint32_t& head = head_[bucket(cell_of(points[i].position))];
    next_[i] = head;
    head = i;
  }

  /// Distance from a candidate to the nearest point of its 27 cells, at most a cell's size; points whose normals differ
  /// count as farther, and those of other layers, so that both sides of a thin sheet are covered by their own. Gives up
  /// below `enough`.
  float distance(const std::vector<SampledPoint>& points, const glm::vec3& p, const glm::vec3& n, float enough) const {
    const glm::ivec3 c = cell_of(p);
    float nearest2 = cell_ * cell_;
    const float enough2 = enough * enough;
    for (const auto& o : offsets()) {
      // What lies in a neighbouring cell is at least as far as the cell.
      const glm::vec3 low = glm::vec3(c + o) * cell_, gap = glm::max(glm::max(low - p, p - (low + cell_)), 0.f);
      if (glm::dot(gap, gap) >= nearest2) continue;
      for (uint32_t i = head_[bucket(c + o)]; i != kNone; i = next_[i]) {
        const glm::vec3 d = points[i].position - p;
        const float d2 = glm::dot(d, d);
        if (d2 >= nearest2) continue;
        const float stretch = 1 + 2 * (1 - std::max(0.f, glm::dot(points[i].normal, n)));
        const float height = kApart * glm::dot(d, n);
        nearest2 = std::min(nearest2, d2 * stretch * stretch + height * height);
        if (nearest2 <= enough2) return enough;
      }
    }
    return std::sqrt(nearest2);
  }

 private:
  /// The 27 cells, the middle first.
  static const std::array<glm::ivec3, 27>& offsets() {
    static const std::array<glm::ivec3, 27> all = [] {
      std::array<glm::ivec3, 27> list;
      int count = 0;
      for (int order = 0; order <= 3; ++order) {
        for (int i = 0; i < 27; ++i) {
          const glm::ivec3 o(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1);
          if (std::abs(o.x) + std::abs(o.y) + std::abs(o.z) == order) list[count++] = o;
        }
      }
      return list;
    }();
    return all;
  }
  glm::ivec3 cell_of(const glm::vec3& p) const {
    constexpr float far = 1 << 30;  // within int, neighbours too
    return glm::ivec3(glm::clamp(glm::floor(p * inverse_), -far, far));
  }
  size_t bucket(const glm::ivec3& c) const {
    uint32_t h = static_cast<uint32_t>(c.x) * 73856093u ^ static_cast<uint32_t>(c.y) * 19349663u ^
                 static_cast<uint32_t>(c.z) * 83492791u;
    h ^= h >> 15;
    return (h * 2654435761u >> 3) & (head_.size() - 1);
  }

  float cell_ = 1, inverse_ = 1;
  std::vector<uint32_t> head_, next_;
};

/// A point of side `side`; false where a test says that it is not there.
bool place(const SurfaceSide& side, glm::vec2 weights, float random, PointTest test, const void* context,
           SampledPoint& point) {
  if (test && side.coverage < 1 && !test(context, side.source, weights, random)) return false;
  point.position = side.v0 + weights.x * (side.v1 - side.v0) + weights.y * (side.v2 - side.v0);
  point.weights = weights;
  point.source = side.source;
  const glm::vec3 n = glm::cross(side.v1 - side.v0, side.v2 - side.v0);
  const float length = glm::length(n);
  point.normal = length > 0 ? (side.back ? -n : n) / length : glm::vec3(0, 0, 1);
  point.area = 0.5f * length;
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
    SampledPoint best, candidate;
    float best_distance = 0;
    // Draw candidates within the part, and keep the one farthest from all points so far (best candidate).
    for (uint32_t k = 0; k < kCandidates; ++k) {
      for (uint32_t attempt = 0; attempt < kRejections; ++attempt) {
        const uint4 r = hash_uint4({seed, first + i, k, attempt});
        const double a = table.total() * (i + static_cast<double>(r.x) * 0x1p-32) / strata;
        const float2 weights = sample_triangle({uint_to_unit(r.y), uint_to_unit(r.z)});
        if (place(table.find(a), {weights.x, weights.y}, uint_to_unit(r.w), attempt + 1 < kRejections ? test : nullptr,
                  test_context, candidate))
          break;
      }
      const float distance = grid.distance(points, candidate.position, candidate.normal, best_distance);
      if (distance > best_distance || k == 0) best = candidate, best_distance = distance;
    }
    points[first + i] = best;
  };

  for (uint32_t first = 0; first < count;) {
    const uint32_t strata = std::min(first == 0 ? kFirstRound : first, count - first);
    const double spacing = std::sqrt(table.total() / strata);  // of the points so far, except in the first round
    grid.rebuild(points, first, static_cast<float>(std::max(spacing, 1e-20)));
    for (uint32_t sub = 0; sub < kSubRounds; ++sub) {
      const uint32_t members = (strata + kSubRounds - 1 - sub) / kSubRounds;
      parallel_for(members, threads, [&](uint32_t m) { sample(first, sub + kSubRounds * m, strata); });
      throw_if_interrupted("points on surfaces");
      for (uint32_t m = 0; m < members; ++m) grid.insert(points, first + sub + kSubRounds * m);
      if (progress) progress(first + strata / kSubRounds * (sub + 1));
    }
    first += strata;
  }
  return result;
}

}  // namespace lucarium::micro
