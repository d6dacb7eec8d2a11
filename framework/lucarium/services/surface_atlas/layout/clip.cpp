// SPDX-License-Identifier: Apache-2.0
#include "lucarium/services/surface_atlas/layout/clip.h"

#include <algorithm>
#include <cmath>

#include "lucarium/services/surface_atlas/layout/cross2.h"

namespace lucarium {

namespace {

using glm::dvec2;

/// A convex polygon; a triangle cut by four lines has at most seven corners.
struct Polygon {
  dvec2 corner[10];
  int count = 0;
  void add(const dvec2& p) { corner[count++] = p; }
};

/// Cuts along axis = value into what lies below and above; corners on the line belong to both.
void cut(const Polygon& polygon, int axis, double value, Polygon& below, Polygon& above) {
  below.count = above.count = 0;
  for (int i = 0; i < polygon.count; ++i) {
    const dvec2& a = polygon.corner[i];
    const dvec2& b = polygon.corner[i + 1 == polygon.count ? 0 : i + 1];
    const double da = a[axis] - value, db = b[axis] - value;
    if (da <= 0) below.add(a);
    if (da >= 0) above.add(a);
    if ((da < 0 && db > 0) || (da > 0 && db < 0)) {
      dvec2 p = a + (da / (da - db)) * (b - a);
      p[axis] = value;
      below.add(p);
      above.add(p);
    }
  }
}

/// Twice the signed area, and the centroid.
double measure(const Polygon& polygon, dvec2& centroid) {
  double sum = 0;
  dvec2 moment(0);
  const dvec2 origin = polygon.corner[0];
  for (int i = 1; i + 1 < polygon.count; ++i) {
    const dvec2 a = polygon.corner[i] - origin, b = polygon.corner[i + 1] - origin;
    const double twice = cross2(a, b);
    sum += twice;
    moment += twice / 3 * (a + b);
  }
  centroid = sum != 0 ? origin + moment / sum : origin;
  return sum;
}

int floor_int(double x) { return static_cast<int>(std::floor(x)); }

/// Interval of `other` coordinates of a triangle within low <= axis <= high.
bool extent_within(const dvec2 uv[3], int axis, double low, double high, double& first, double& last) {
  first = INFINITY, last = -INFINITY;
  const auto add = [&](double x) { first = std::min(first, x), last = std::max(last, x); };
  for (int i = 0; i < 3; ++i) {
    const dvec2 &a = uv[i], &b = uv[(i + 1) % 3];
    if (a[axis] >= low && a[axis] <= high) add(a[1 - axis]);
    for (const double line : {low, high}) {
      const double da = a[axis] - line, db = b[axis] - line;
      if ((da < 0) != (db < 0)) add(a[1 - axis] + da / (da - db) * (b[1 - axis] - a[1 - axis]));
    }
  }
  return first <= last;
}

/// Share [0, 1] of segment a + t (b - a) inside a closed box as an interval of t; false when there is none.
bool segment_in_box(const dvec2& a, const dvec2& b, const dvec2& low, const dvec2& high, double& from, double& to) {
  from = 0, to = 1;
  for (int axis = 0; axis < 2; ++axis) {
    const double d = b[axis] - a[axis];
    if (d == 0) {
      if (a[axis] < low[axis] || a[axis] > high[axis]) return false;
      continue;
    }
    double t0 = (low[axis] - a[axis]) / d, t1 = (high[axis] - a[axis]) / d;
    if (t0 > t1) std::swap(t0, t1);
    from = std::max(from, t0), to = std::min(to, t1);
  }
  return from <= to;
}

/// A triangle that is a line in uv: pieces by length along its longest edge.
void clip_line(const dvec2 uv[3], std::vector<ClippedCell>& cells, size_t first) {
  int longest = 0;
  for (int i = 1; i < 3; ++i) {
    if (glm::length(uv[(i + 1) % 3] - uv[i]) > glm::length(uv[(longest + 1) % 3] - uv[longest])) longest = i;
  }
  const int i = longest, j = (longest + 1) % 3;
  double sum = 0;
  std::vector<double> lengths;
  for (size_t c = first; c < cells.size(); ++c) {
    const dvec2 low(cells[c].x, cells[c].y);
    double from, to;
    if (!segment_in_box(uv[i], uv[j], low, low + 1.0, from, to)) from = to = 0;
    lengths.push_back(to - from);
    sum += to - from;
    const double t = 0.5 * (from + to);
    const double weight[3] = {i == 0   ? 1 - t
                              : j == 0 ? t
                                       : 0,
                              i == 1   ? 1 - t
                              : j == 1 ? t
                                       : 0,
                              i == 2   ? 1 - t
                              : j == 2 ? t
                                       : 0};
    cells[c].b1 = static_cast<float>(weight[1]);
    cells[c].b2 = static_cast<float>(weight[2]);
  }
  for (size_t c = first; c < cells.size(); ++c)
    cells[c].fraction = static_cast<float>(sum > 0 ? lengths[c - first] / sum : c == first ? 1. : 0.);
}

}  // namespace

double cell_dilation(const dvec2 uv[3]) {
  const dvec2 extent = glm::max(uv[0], glm::max(uv[1], uv[2])) - glm::min(uv[0], glm::min(uv[1], uv[2]));
  return 1e-4 + 4e-7 * std::max(extent.x, extent.y);
}

bool segment_touches_cell(const dvec2& a, const dvec2& b, int x, int y, double dilation) {
  double from, to;
  return segment_in_box(a, b, dvec2(x, y) - dilation, dvec2(x + 1, y + 1) + dilation, from, to);
}

dvec2 point_beside_cell(const dvec2 uv[3], int x, int y) {
  const double dilation = cell_dilation(uv);
  Polygon polygon, inside, rest;
  for (int i = 0; i < 3; ++i) polygon.add(uv[i]);
  cut(polygon, 0, x - dilation, rest, inside);
  cut(inside, 0, x + 1 + dilation, polygon, rest);
  cut(polygon, 1, y - dilation, rest, inside);
  cut(inside, 1, y + 1 + dilation, polygon, rest);
  const dvec2 center = (uv[0] + uv[1] + uv[2]) / 3.;
  if (polygon.count == 0) return center;
  dvec2 touching(0);
  for (int i = 0; i < polygon.count; ++i) touching += polygon.corner[i] / double(polygon.count);
  const double distance = glm::length(center - touching);
  return distance > 0 ? touching + std::min(1., 3 * dilation / distance) * (center - touching) : center;
}

bool sample_in_cell(const dvec2 uv[3], int x, int y, const dvec2& u, float& b1, float& b2) {
  Polygon polygon, inside, rest;
  for (int i = 0; i < 3; ++i) polygon.add(uv[i]);
  cut(polygon, 0, x, rest, inside);
  cut(inside, 0, x + 1, polygon, rest);
  cut(polygon, 1, y, rest, inside);
  cut(inside, 1, y + 1, polygon, rest);
  const dvec2 e1 = uv[1] - uv[0], e2 = uv[2] - uv[0];
  const double twice = cross2(e1, e2);
  dvec2 centroid;
  const double wanted = polygon.count < 3 ? 0 : u.x * measure(polygon, centroid);
  // The triangle of the fan that holds the share u.x of the area, and the place in it.
  double before = 0, size = 0;
  int i = 1;
  for (; i + 1 < polygon.count; ++i) {
    size = cross2(polygon.corner[i] - polygon.corner[0], polygon.corner[i + 1] - polygon.corner[0]);
    if (std::fabs(before + size) > std::fabs(wanted) || i + 2 == polygon.count) break;
    before += size;
  }
  if (size == 0 || twice == 0) return false;
  const double from_apex = std::sqrt(std::clamp((wanted - before) / size, 0., 1.));
  const dvec2 across = polygon.corner[i] + u.y * (polygon.corner[i + 1] - polygon.corner[i]);
  const dvec2 p = polygon.corner[0] + from_apex * (across - polygon.corner[0]) - uv[0];
  const double first = std::clamp(cross2(p, e2) / twice, 0., 1.);
  b1 = static_cast<float>(first);
  b2 = static_cast<float>(std::clamp(cross2(e1, p) / twice, 0., 1. - first));
  return true;
}

void clip_to_cells(const dvec2 uv[3], std::vector<ClippedCell>& out) {
  const double dilation = cell_dilation(uv);
  const dvec2 low = glm::min(uv[0], glm::min(uv[1], uv[2])), high = glm::max(uv[0], glm::max(uv[1], uv[2]));
  const int row0 = floor_int(low.y - dilation), row1 = floor_int(high.y + dilation);
  if (row0 == row1 && floor_int(low.x - dilation) == floor_int(high.x + dilation)) {
    out.push_back({floor_int(low.x), row0, 1.f, 1.f / 3, 1.f / 3});
    return;
  }
  const dvec2 e1 = uv[1] - uv[0], e2 = uv[2] - uv[0];
  const double twice = cross2(e1, e2);
  const double longest = std::max({glm::dot(e1, e1), glm::dot(e2, e2), glm::dot(e2 - e1, e2 - e1)});
  const bool is_line = !(std::fabs(twice) > 1e-10 * longest);
  const size_t first = out.size();
  Polygon rest, row, piece, right;
  for (int i = 0; i < 3; ++i) rest.add(uv[i]);
  for (int y = row0; y <= row1; ++y) {
    Polygon above;
    cut(rest, 1, y + 1, row, above);
    rest = above;
    double from, to;
    if (!extent_within(uv, 1, y - dilation, y + 1 + dilation, from, to)) continue;
    const int last = floor_int(to + dilation);
    for (int x = floor_int(from - dilation); x <= last; ++x) {
      ClippedCell cell{x, y, 0.f, 1.f / 3, 1.f / 3};
      cut(row, 0, x + 1, piece, right);
      if (!is_line && piece.count >= 3) {
        dvec2 centroid;
        cell.fraction = static_cast<float>(std::max(measure(piece, centroid) / twice, 0.));
        const double b1 = std::clamp(cross2(centroid - uv[0], e2) / twice, 0., 1.);
        const double b2 = std::clamp(cross2(e1, centroid - uv[0]) / twice, 0., 1. - b1);
        cell.b1 = static_cast<float>(b1), cell.b2 = static_cast<float>(b2);
      }
      row = right;
      out.push_back(cell);
    }
  }
  if (is_line) clip_line(uv, out, first);
}

}  // namespace lucarium
