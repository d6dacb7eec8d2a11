// SPDX-License-Identifier: Apache-2.0
// A chart's plane: projection, best-fit rectangle, bisection of shapes that fill it badly, and the grid of cells.
// Declared in chart.h.
#include <algorithm>
#include <array>

#include "lucarium/services/surface_atlas/layout/chart.h"
#include "lucarium/services/surface_atlas/layout/cross2.h"

namespace lucarium {

namespace {

using glm::dvec2;
using glm::dvec3;

constexpr double steepest_degrees = 75;  // between the projection and a triangle, before another axis is tried
constexpr double min_fill = 0.75;        // of the rectangle; below, a chart is bisected
constexpr double min_fill_uncut = 0.3;   // below, a chart is halved even where that alone gains nothing
constexpr double worth_bisecting = 16;   // rectangles up to this many s² stay whole
constexpr double bisection_gain = 0.85;  // both rectangles together over the whole one, at most
constexpr int bins = 16;
constexpr double inset = 2e-3;  // of the chart's edges in their outermost cells [cells]

struct Rectangle {
  dvec2 low{INFINITY}, high{-INFINITY};
  void add(const dvec2& p) { low = glm::min(low, p), high = glm::max(high, p); }
  void add(const Rectangle& r) { low = glm::min(low, r.low), high = glm::max(high, r.high); }
  double area() const { return low.x > high.x ? 0 : (high.x - low.x) * (high.y - low.y); }
};

/// Counter-clockwise convex hull (Andrew's monotone chain).
std::vector<dvec2> convex_hull(std::vector<dvec2> points) {
  const auto before = [](const dvec2& a, const dvec2& b) { return a.x != b.x ? a.x < b.x : a.y < b.y; };
  std::sort(points.begin(), points.end(), before);
  points.erase(std::unique(points.begin(), points.end()), points.end());
  if (points.size() < 3) return points;
  std::vector<dvec2> hull;
  for (int pass = 0; pass < 2; ++pass) {
    const size_t start = hull.size();
    for (const dvec2& p : points) {
      while (hull.size() >= start + 2 && cross2(hull.back() - hull[hull.size() - 2], p - hull.back()) <= 0)
        hull.pop_back();
      hull.push_back(p);
    }
    hull.pop_back();
    std::reverse(points.begin(), points.end());
  }
  return hull;
}

/// Direction of the long side of the smallest rectangle around points; one side lies on a hull edge.
dvec2 best_direction(const std::vector<dvec2>& hull) {
  dvec2 best(1, 0);
  double least = INFINITY;
  for (size_t i = 0; i < hull.size(); ++i) {
    const dvec2 edge = hull[(i + 1) % hull.size()] - hull[i];
    const double length = glm::length(edge);
    if (!(length > 0)) continue;
    const dvec2 x = edge / length, y(-x.y, x.x);
    Rectangle rectangle;
    for (const dvec2& p : hull) rectangle.add(dvec2(glm::dot(p, x), glm::dot(p, y)));
    const dvec2 size = rectangle.high - rectangle.low;
    if (size.x * size.y < least * (1 - 1e-9)) {
      least = size.x * size.y;
      best = size.x >= size.y ? x : y;
    }
  }
  return best;
}

/// Two unit vectors that make a right-handed basis with n.
std::array<dvec3, 2> plane_basis(const dvec3& n) {
  const dvec3 helper = std::fabs(n.x) < 0.6 ? dvec3(1, 0, 0) : dvec3(0, 1, 0);
  const dvec3 t = glm::normalize(glm::cross(helper, n));
  return {t, glm::cross(n, t)};
}

/// A unit vector across the longest edge of a triangle that has no normal to speak of.
dvec3 sliver_axis(const AtlasMesh& mesh, uint32_t triangle) {
  dvec3 longest(0);
  for (int i = 0; i < 3; ++i) {
    const dvec3 edge = mesh.position(triangle, (i + 1) % 3) - mesh.position(triangle, i);
    if (glm::dot(edge, edge) > glm::dot(longest, longest)) longest = edge;
  }
  const double length = glm::length(longest);
  return length > 0 && std::isfinite(length) ? plane_basis(longest / length)[0] : dvec3(0, 0, 1);
}

/// Area-weighted mean normal, unless some triangle is too steep to it: then that of the largest.
dvec3 chart_axis(const AtlasMesh& mesh, const std::vector<uint32_t>& triangles) {
  dvec3 sum(0);
  uint32_t largest = triangles[0];
  for (const uint32_t t : triangles) {
    sum += mesh.area[t] * dvec3(mesh.normal[t]);
    if (mesh.area[t] > mesh.area[largest]) largest = t;
  }
  const dvec3 fallback =
      mesh.normal[largest] == glm::vec3(0) ? sliver_axis(mesh, largest) : dvec3(mesh.normal[largest]);
  const double length = glm::length(sum);
  if (!(length > 0)) return fallback;
  const double steepest = cos_degrees(steepest_degrees);
  for (const uint32_t t : triangles) {
    if (mesh.normal[t] != glm::vec3(0) && glm::dot(sum, dvec3(mesh.normal[t])) < steepest * length) return fallback;
  }
  return sum / length;
}

}  // namespace

// Fills chart_ with uv in metres and size_; false when the triangles have no finite extent to speak of.
bool ChartPlacer::project(const std::vector<uint32_t>& triangles) {
  const uint32_t instance = mesh_.geometry.instance[triangles[0]];
  const double scale = settings_.texcoord_scale.empty() ? 0 : settings_.texcoord_scale[instance];
  std::array<dvec3, 2> basis{dvec3(0), dvec3(0)};
  if (scale == 0) basis = plane_basis(chart_axis(mesh_, triangles));
  const dvec3 origin = mesh_.position(triangles[0], 0);
  const auto corner_uv = [&](uint32_t t, int i) {
    const uint32_t vertex = mesh_.geometry.triangles[t][i];
    if (scale > 0) return scale * dvec2(mesh_.geometry.texcoord1[vertex]);
    const dvec3 p = dvec3(mesh_.geometry.positions[vertex]) - origin;
    return dvec2(glm::dot(p, basis[0]), glm::dot(p, basis[1]));
  };
  chart_.clear();
  std::vector<dvec2> points;
  for (const uint32_t t : triangles) {
    chart_.push_back({t, {corner_uv(t, 0), corner_uv(t, 1), corner_uv(t, 2)}});
    points.insert(points.end(), chart_.back().uv, chart_.back().uv + 3);
  }
  for (const dvec2& p : points)
    if (!std::isfinite(p.x) || !std::isfinite(p.y)) return false;
  const dvec2 x = best_direction(convex_hull(std::move(points))), y(-x.y, x.x);
  Rectangle rectangle;
  for (ChartTriangle& t : chart_) {
    for (dvec2& p : t.uv) {
      p = dvec2(glm::dot(p, x), glm::dot(p, y));
      rectangle.add(p);
    }
  }
  for (ChartTriangle& t : chart_)
    for (dvec2& p : t.uv) p -= rectangle.low;
  size_ = rectangle.high - rectangle.low;
  return size_.x > 0;
}

// Splits a chart that leaves much of its rectangle empty where two rectangles fit best; triangles go by their centroid.
bool ChartPlacer::bisect(std::vector<uint32_t>& one, std::vector<uint32_t>& other) const {
  const double whole = size_.x * size_.y;
  double filled = 0;
  for (const ChartTriangle& t : chart_) filled += 0.5 * std::fabs(cross2(t.uv[1] - t.uv[0], t.uv[2] - t.uv[0]));
  if (chart_.size() < 2 || whole <= worth_bisecting * settings_.edge * settings_.edge || filled >= min_fill * whole)
    return false;
  const auto bin_of = [&](const ChartTriangle& t, int axis) {
    const double center = (t.uv[0][axis] + t.uv[1][axis] + t.uv[2][axis]) / 3;
    return std::clamp(static_cast<int>(center / size_[axis] * bins), 0, bins - 1);
  };
  double least = bisection_gain * whole;
  int best_axis = -1, best_bin = 0;
  for (int axis = 0; axis < 2; ++axis) {
    std::array<Rectangle, bins> boxes, above;
    for (const ChartTriangle& t : chart_)
      for (const dvec2& p : t.uv) boxes[bin_of(t, axis)].add(p);
    for (int i = bins - 1; i >= 0; --i) {
      above[i] = boxes[i];
      if (i + 1 < bins) above[i].add(above[i + 1]);
    }
    Rectangle below;
    for (int i = 0; i + 1 < bins; ++i) {
      below.add(boxes[i]);
      const bool both = below.low.x <= below.high.x && above[i + 1].low.x <= above[i + 1].high.x;
      if (both && below.area() + above[i + 1].area() < least) {
        least = below.area() + above[i + 1].area();
        best_axis = axis, best_bin = i;
      }
    }
  }
  if (best_axis < 0) {
    // Frames and the like gain only when their halves are cut again.
    if (filled >= min_fill_uncut * whole) return false;
    best_axis = size_.x >= size_.y ? 0 : 1, best_bin = bins / 2 - 1;
  }
  for (const ChartTriangle& t : chart_) (bin_of(t, best_axis) <= best_bin ? one : other).push_back(t.triangle);
  return !one.empty() && !other.empty();
}

// Whole cells that fit the rectangle, stretched by up to half a cell, so that straight borders cut no slivers off.
void ChartPlacer::fit_grid() {
  dvec2 scale, cells;
  for (int axis = 0; axis < 2; ++axis) {
    cells[axis] = std::max(1., std::round(size_[axis] / settings_.edge));
    scale[axis] = size_[axis] > 0 ? (cells[axis] - 2 * inset) / size_[axis] : 0;
  }
  width_ = static_cast<uint32_t>(cells.x) + 2;
  height_ = static_cast<uint32_t>(cells.y) + 2;
  for (ChartTriangle& t : chart_)
    for (dvec2& p : t.uv) p = 1 + inset + p * scale;
}

}  // namespace lucarium
