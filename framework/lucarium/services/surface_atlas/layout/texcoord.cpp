// SPDX-License-Identifier: Apache-2.0
#include "lucarium/services/surface_atlas/layout/texcoord.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "lucarium/base/error.h"
#include "lucarium/services/surface_atlas/layout/cross2.h"

namespace lucarium {

namespace {

using glm::dvec2;
using glm::dvec3;

constexpr double max_off = 2;            // of density along any direction
constexpr double tolerated_area = 1e-3;  // of an instance whose density is off
constexpr double min_overlap = 1e-4;     // of the smaller triangle's area

struct UvTriangle {
  dvec2 corner[3];
  double twice() const { return cross2(corner[1] - corner[0], corner[2] - corner[0]); }
};

/// Area that two triangles have in common, relative to the smaller one: one is cut by the other's edges.
double common_share(const UvTriangle& a, const UvTriangle& b) {
  std::vector<dvec2> polygon(a.corner, a.corner + 3), next;
  const double sign = b.twice() < 0 ? -1 : 1;
  for (int i = 0; i < 3; ++i) {
    const dvec2 from = b.corner[i], along = b.corner[(i + 1) % 3] - from;
    next.clear();
    for (size_t k = 0; k < polygon.size(); ++k) {
      const dvec2 p = polygon[k], q = polygon[(k + 1) % polygon.size()];
      const double dp = sign * cross2(along, p - from), dq = sign * cross2(along, q - from);
      if (dp >= 0) next.push_back(p);
      if ((dp < 0) != (dq < 0)) next.push_back(p + dp / (dp - dq) * (q - p));
    }
    polygon.swap(next);
  }
  double twice = 0;
  for (size_t k = 1; k + 1 < polygon.size(); ++k) twice += cross2(polygon[k] - polygon[0], polygon[k + 1] - polygon[0]);
  return std::fabs(twice) / std::min(std::fabs(a.twice()), std::fabs(b.twice()));
}

/// The triangles of one instance.
class TexcoordCheck {
 public:
  TexcoordCheck(const AtlasMesh& mesh, uint32_t first, uint32_t last) : mesh_(mesh), first_(first), last_(last) {}

  double run() {
    double area = 0, uv_area = 0;
    for (uint32_t t = first_; t < last_; ++t) {
      if (mesh_.left_out[t]) continue;
      area += mesh_.area[t];
      uv_area += 0.5 * std::fabs(uv(t).twice());
    }
    if (!(area > 0)) return 0;
    if (!(uv_area > 0) || !std::isfinite(uv_area)) refuse("has no area");
    const double scale = std::sqrt(area / uv_area);
    check_density(scale, area);
    check_folds();
    check_overlap();
    return scale;
  }

 private:
  UvTriangle uv(uint32_t t) const {
    const glm::uvec3& v = mesh_.geometry.triangles[t];
    const auto at = [&](uint32_t i) { return dvec2(mesh_.geometry.texcoord1[i]); };
    return {{at(v.x), at(v.y), at(v.z)}};
  }

  [[noreturn]] void refuse(const std::string& what) const {
    const uint32_t instance = mesh_.geometry.instance[first_];
    const std::string name = instance < mesh_.geometry.names.size() ? mesh_.geometry.names[instance] : "";
    throw_error(ErrorClass::input,
                "surface atlas: TEXCOORD_1 of mesh \"{}\" (instance {}) {}; leave it out, or unwrap the mesh again",
                name, instance, what);
  }

  /// Least and greatest stretch of uv → space (singular values), by the metric of the two edges.
  std::array<double, 2> stretch(uint32_t t) const {
    const UvTriangle u = uv(t);
    const double twice = u.twice();
    if (twice == 0) return {0, INFINITY};
    const dvec2 d1 = u.corner[1] - u.corner[0], d2 = u.corner[2] - u.corner[0];
    const dvec3 e1 = mesh_.position(t, 1) - mesh_.position(t, 0), e2 = mesh_.position(t, 2) - mesh_.position(t, 0);
    const dvec3 along_u = (d2.y * e1 - d1.y * e2) / twice, along_v = (d1.x * e2 - d2.x * e1) / twice;
    const double a = glm::dot(along_u, along_u), b = glm::dot(along_u, along_v), c = glm::dot(along_v, along_v);
    const double root = std::sqrt((a - c) * (a - c) + 4 * b * b);
    return {std::sqrt(std::max(0., 0.5 * (a + c - root))), std::sqrt(0.5 * (a + c + root))};
  }

  void check_density(double scale, double area) const {
    double off = 0;
    uint32_t worst = first_;
    for (uint32_t t = first_; t < last_; ++t) {
      if (mesh_.left_out[t]) continue;
      const auto [smallest, largest] = stretch(t);
      if (smallest >= scale / max_off && largest <= scale * max_off) continue;
      off += mesh_.area[t];
      if (mesh_.area[t] > mesh_.area[worst]) worst = t;
    }
    if (off > tolerated_area * area) {
      refuse(fmt::format("has a density that is off by more than {} over {:.1f} % of its area (triangle {})", max_off,
                         100 * off / area, worst - first_));
    }
  }

  void check_folds() const {
    for (uint32_t t = first_; t < last_; ++t) {
      for (int i = 0; i < 3; ++i) {
        const uint32_t other = mesh_.neighbor[t][i];
        if (other == LUCARIUM_NONE || other < t || !texcoord1_goes_on(mesh_, t, i, other)) continue;
        if (uv(t).twice() * uv(other).twice() < 0)
          refuse(fmt::format("is folded between triangles {} and {}", t - first_, other - first_));
      }
    }
  }

  /// Pairs of triangles in the cells of a grid with about as many cells as triangles.
  void check_overlap() const {
    dvec2 low(INFINITY), high(-INFINITY);
    for (uint32_t t = first_; t < last_; ++t)
      if (!mesh_.left_out[t])
        for (const dvec2& p : uv(t).corner) low = glm::min(low, p), high = glm::max(high, p);
    const int cells = std::clamp(static_cast<int>(std::sqrt(double(last_ - first_))), 1, 2048);
    const dvec2 scale = double(cells) / glm::max(high - low, dvec2(1e-30));
    const auto range = [&](uint32_t t, glm::ivec2& from, glm::ivec2& to) {
      const UvTriangle u = uv(t);
      const dvec2 a = glm::min(u.corner[0], glm::min(u.corner[1], u.corner[2]));
      const dvec2 b = glm::max(u.corner[0], glm::max(u.corner[1], u.corner[2]));
      from = glm::clamp(glm::ivec2((a - low) * scale), glm::ivec2(0), glm::ivec2(cells - 1));
      to = glm::clamp(glm::ivec2((b - low) * scale), glm::ivec2(0), glm::ivec2(cells - 1));
    };
    std::vector<std::vector<uint32_t>> grid(size_t(cells) * cells);
    for (uint32_t t = first_; t < last_; ++t) {
      if (mesh_.left_out[t] || uv(t).twice() == 0) continue;
      glm::ivec2 from, to;
      range(t, from, to);
      for (int y = from.y; y <= to.y; ++y) {
        for (int x = from.x; x <= to.x; ++x) {
          std::vector<uint32_t>& cell = grid[size_t(y) * cells + x];
          for (const uint32_t other : cell) {
            if (common_share(uv(t), uv(other)) > min_overlap)
              refuse(fmt::format("overlaps itself: triangles {} and {}", other - first_, t - first_));
          }
          cell.push_back(t);
        }
      }
    }
  }

  const AtlasMesh& mesh_;
  uint32_t first_, last_;
};

}  // namespace

bool texcoord1_goes_on(const AtlasMesh& mesh, uint32_t triangle, int edge, uint32_t other) {
  const auto uv = [&](uint32_t t, int i) { return mesh.geometry.texcoord1[mesh.geometry.triangles[t][i % 3]]; };
  const int back = mesh.edge_to(other, triangle);
  return back < 3 && uv(triangle, edge) == uv(other, back + 1) && uv(triangle, edge + 1) == uv(other, back);
}

std::vector<double> check_texcoord1(const AtlasMesh& mesh) {
  const AtlasGeometry& g = mesh.geometry;
  if (g.has_texcoord1.empty()) return {};
  std::vector<double> scale(g.two_sided.size(), 0);
  bool any = false;
  const uint32_t count = static_cast<uint32_t>(g.triangles.size());
  for (uint32_t first = 0, last = 0; first < count; first = last) {
    while (last < count && g.instance[last] == g.instance[first]) ++last;
    if (!g.has_texcoord1[g.instance[first]]) continue;
    any = true;
    scale[g.instance[first]] = TexcoordCheck(mesh, first, last).run();
  }
  if (!any) {
    throw Error(ErrorClass::input, "surface atlas: no mesh of the scene has TEXCOORD_1; compute a layout instead");
  }
  return scale;
}

}  // namespace lucarium
