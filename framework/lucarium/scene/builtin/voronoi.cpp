// SPDX-License-Identifier: Apache-2.0
// Voronoi cells by clipping: a cube, cut by the bisectors to the points around, nearest rings of a grid first.
#include "lucarium/scene/builtin/voronoi.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace lucarium {

namespace {

/// Corners this near a plane, relative to lengths about 1, are taken as inside, against cuts of slivers.
constexpr double on_plane = 1e-9;

ConvexCell cube(double half_edge) {
  ConvexCell cell;
  for (int i = 0; i < 8; ++i) {
    cell.corners.emplace_back(i & 1 ? half_edge : -half_edge, i & 2 ? half_edge : -half_edge,
                              i & 4 ? half_edge : -half_edge);
  }
  cell.faces = {{{0, 4, 6, 2}, false}, {{1, 3, 7, 5}, false}, {{0, 1, 5, 4}, false},
                {{2, 6, 7, 3}, false}, {{0, 2, 3, 1}, false}, {{4, 5, 7, 6}, false}};
  return cell;
}

double farthest_corner(const ConvexCell& cell, const glm::dvec3& from) {
  double squared = 0;
  for (const glm::dvec3& p : cell.corners) squared = std::max(squared, glm::dot(p - from, p - from));
  return std::sqrt(squared);
}

/// Drops corners that no face has.
void drop_unused_corners(ConvexCell& cell) {
  std::vector<uint32_t> renamed(cell.corners.size(), ~0u);
  std::vector<glm::dvec3> kept;
  for (ConvexCell::Face& face : cell.faces) {
    for (uint32_t& corner : face.corners) {
      if (renamed[corner] == ~0u) {
        renamed[corner] = static_cast<uint32_t>(kept.size());
        kept.push_back(cell.corners[corner]);
      }
      corner = renamed[corner];
    }
  }
  cell.corners = std::move(kept);
}

/// Points in cubic boxes, about one in each.
class PointGrid {
 public:
  PointGrid(std::span<const glm::dvec3> points, double half_edge)
      : side_(std::max(1, static_cast<int>(std::cbrt(static_cast<double>(points.size()))))),
        half_edge_(half_edge),
        boxes_(static_cast<size_t>(side_) * side_ * side_) {
    for (uint32_t i = 0; i < points.size(); ++i) boxes_[index(box_of(points[i]))].push_back(i);
  }

  double box_edge() const { return 2 * half_edge_ / side_; }
  int side() const { return side_; }

  /// Visits the points whose boxes are `ring` boxes away from that of `p`, along the axis where they are farthest.
  template <class Visit>
  void visit_ring(const glm::dvec3& p, int ring, const Visit& visit) const {
    const glm::ivec3 middle = box_of(p);
    for (int z = -ring; z <= ring; ++z) {
      for (int y = -ring; y <= ring; ++y) {
        const bool shell = std::max(std::abs(y), std::abs(z)) == ring;
        for (int x = -ring; x <= ring; x += shell ? 1 : std::max(1, 2 * ring)) {
          const glm::ivec3 box = middle + glm::ivec3(x, y, z);
          if (glm::any(glm::lessThan(box, glm::ivec3(0))) || glm::any(glm::greaterThanEqual(box, glm::ivec3(side_))))
            continue;
          for (const uint32_t i : boxes_[index(box)]) visit(i);
        }
      }
    }
  }

 private:
  glm::ivec3 box_of(const glm::dvec3& p) const {
    return glm::clamp(glm::ivec3(glm::floor((p + half_edge_) / box_edge())), 0, side_ - 1);
  }
  size_t index(const glm::ivec3& box) const {
    return (static_cast<size_t>(box.z) * side_ + box.y) * side_ + static_cast<size_t>(box.x);
  }

  int side_;
  double half_edge_;
  std::vector<std::vector<uint32_t>> boxes_;
};

}  // namespace

void clip(ConvexCell& cell, const HalfSpace& half_space, bool outer) {
  const size_t before = cell.corners.size();
  std::vector<double> beyond(before);
  bool cut = false;
  for (size_t i = 0; i < before; ++i) {
    beyond[i] = glm::dot(half_space.n, cell.corners[i]) - half_space.offset;
    cut = cut || beyond[i] > on_plane;
  }
  if (!cut) return;
  // One new corner per edge that is cut, whichever of its two faces comes first.
  std::map<std::pair<uint32_t, uint32_t>, uint32_t> made;
  const auto cut_edge = [&](uint32_t in, uint32_t out) {
    const auto [entry, is_new] = made.try_emplace({in, out}, static_cast<uint32_t>(cell.corners.size()));
    if (is_new) {
      const double t = std::clamp(beyond[in] / (beyond[in] - beyond[out]), 0., 1.);
      cell.corners.push_back(glm::mix(cell.corners[in], cell.corners[out], t));
    }
    return entry->second;
  };
  std::vector<ConvexCell::Face> kept;
  std::map<uint32_t, uint32_t> rim;  // edges of the new face: from → to
  for (const ConvexCell::Face& face : cell.faces) {
    ConvexCell::Face rest{{}, face.outer};
    uint32_t leaves = ~0u, enters = ~0u;
    for (size_t i = 0; i < face.corners.size(); ++i) {
      const uint32_t a = face.corners[i], b = face.corners[(i + 1) % face.corners.size()];
      const bool a_in = beyond[a] <= on_plane, b_in = beyond[b] <= on_plane;
      if (a_in) rest.corners.push_back(a);
      if (a_in && !b_in) rest.corners.push_back(leaves = cut_edge(a, b));
      if (!a_in && b_in) rest.corners.push_back(enters = cut_edge(b, a));
    }
    if (leaves != ~0u) rim[enters] = leaves;  // the other way round than in this face
    if (!rest.corners.empty()) kept.push_back(std::move(rest));
  }
  ConvexCell::Face cap{{}, outer};
  for (uint32_t at = rim.empty() ? ~0u : rim.begin()->first; cap.corners.size() < rim.size(); at = rim.at(at))
    cap.corners.push_back(at);
  if (!cap.corners.empty()) kept.push_back(std::move(cap));
  cell.faces = std::move(kept);
  drop_unused_corners(cell);
}

void collapse_short_edges(ConvexCell& cell, double length) {
  std::vector<uint32_t> merged(cell.corners.size());
  for (uint32_t i = 0; i < merged.size(); ++i) merged[i] = i;
  const auto find = [&](uint32_t i) {
    while (merged[i] != i) i = merged[i];
    return i;
  };
  for (const ConvexCell::Face& face : cell.faces) {
    for (size_t i = 0; i < face.corners.size(); ++i) {
      const uint32_t a = face.corners[i], b = face.corners[(i + 1) % face.corners.size()];
      if (glm::distance(cell.corners[a], cell.corners[b]) >= length) continue;
      const uint32_t first = find(a), second = find(b);
      merged[std::max(first, second)] = std::min(first, second);
    }
  }
  for (ConvexCell::Face& face : cell.faces) {
    for (uint32_t& corner : face.corners) corner = find(corner);
    std::vector<uint32_t>& loop = face.corners;
    loop.erase(std::unique(loop.begin(), loop.end()), loop.end());
    while (loop.size() > 1 && loop.front() == loop.back()) loop.pop_back();
  }
  std::erase_if(cell.faces, [](const ConvexCell::Face& face) { return face.corners.size() < 3; });
  drop_unused_corners(cell);
}

std::vector<ConvexCell> voronoi_cells(std::span<const glm::dvec3> points, std::span<const HalfSpace> body, double inner,
                                      double half_edge) {
  const PointGrid grid(points, half_edge);
  std::vector<ConvexCell> cells;
  cells.reserve(points.size());
  for (uint32_t i = 0; i < points.size(); ++i) {
    const glm::dvec3& p = points[i];
    ConvexCell cell = cube(half_edge);
    const auto clip_by_ring = [&](int ring) {
      const double reach = 2 * farthest_corner(cell, p);  // bisectors to points farther away pass all corners
      grid.visit_ring(p, ring, [&](uint32_t k) {
        const double distance = glm::distance(points[k], p);
        if (k == i || distance >= reach) return;
        const glm::dvec3 n = (points[k] - p) / distance;
        clip(cell, {n, glm::dot(n, 0.5 * (points[k] + p))}, false);
      });
    };
    const auto done = [&](int ring) { return ring * grid.box_edge() >= 2 * farthest_corner(cell, p); };
    int ring = 0;
    for (; ring < std::min(3, grid.side()); ++ring) clip_by_ring(ring);
    if (farthest_corner(cell, glm::dvec3(0)) > inner) {
      for (const HalfSpace& face : body) clip(cell, face, true);
    }
    for (; ring < grid.side() && !done(ring - 1); ++ring) clip_by_ring(ring);
    cells.push_back(std::move(cell));
  }
  return cells;
}

}  // namespace lucarium
