// SPDX-License-Identifier: Apache-2.0
#include "lucarium/scene/mesh_attributes.h"

#include <algorithm>
#include <cmath>

namespace lucarium {

namespace {

template <class T>
void gather(std::vector<T>& values, const std::vector<uint32_t>& source) {
  if (values.empty()) return;
  std::vector<T> result(source.size());
  for (size_t i = 0; i < source.size(); ++i) result[i] = values[source[i]];
  values = std::move(result);
}

/// Cross product of two edges in double precision: twice the area along the normal. Zero where it is not a number.
glm::dvec3 area_normal(const Mesh& mesh, const glm::uvec3& t) {
  const glm::dvec3 a(mesh.positions[t.x]), b(mesh.positions[t.y]), c(mesh.positions[t.z]);
  const glm::dvec3 normal = glm::cross(b - a, c - a);
  return std::isfinite(normal.x + normal.y + normal.z) ? normal : glm::dvec3(0);
}

/// `v` with unit length; `fallback` where it has no direction.
glm::vec3 direction_or(const glm::dvec3& v, const glm::vec3& fallback) {
  const double largest = std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
  if (!(largest > 0) || !std::isfinite(largest)) return fallback;
  return glm::vec3(glm::normalize(v / largest));
}

glm::vec3 any_perpendicular(const glm::vec3& n) {
  const glm::vec3 axis = std::abs(n.x) < 0.9f ? glm::vec3(1, 0, 0) : glm::vec3(0, 1, 0);
  return glm::normalize(glm::cross(n, axis));
}

/// Part of `v` in the plane with normal `n`, unit length.
glm::vec3 in_plane(const glm::dvec3& v, const glm::vec3& n) {
  const glm::dvec3 normal(n);
  const double scale = std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
  if (!(scale > 0) || !std::isfinite(scale)) return any_perpendicular(n);
  const glm::dvec3 unit = glm::normalize(v / scale), part = unit - normal * glm::dot(normal, unit);
  return glm::length(part) < 1e-5 ? any_perpendicular(n) : glm::vec3(glm::normalize(part));
}

double corner_angle(const Mesh& mesh, const glm::uvec3& t, int corner) {
  const glm::dvec3 p(mesh.positions[t[corner]]);
  const glm::dvec3 a = glm::dvec3(mesh.positions[t[(corner + 1) % 3]]) - p;
  const glm::dvec3 b = glm::dvec3(mesh.positions[t[(corner + 2) % 3]]) - p;
  const double lengths = glm::length(a) * glm::length(b);
  if (!(lengths > 0) || !std::isfinite(lengths)) return 0;
  return std::acos(std::clamp(glm::dot(a, b) / lengths, -1.0, 1.0));
}

/// Derivatives of the position by the texture coordinates over one triangle; zero where these are degenerate.
struct Frame {
  glm::dvec3 by_u{0}, by_v{0};
};

Frame texture_frame(const Mesh& mesh, const glm::uvec3& t, const std::vector<glm::vec2>& uv) {
  const glm::dvec3 p0(mesh.positions[t.x]), e1 = glm::dvec3(mesh.positions[t.y]) - p0,
                                            e2 = glm::dvec3(mesh.positions[t.z]) - p0;
  const glm::dvec2 w0(uv[t.x]), d1 = glm::dvec2(uv[t.y]) - w0, d2 = glm::dvec2(uv[t.z]) - w0;
  const double area = d1.x * d2.y - d2.x * d1.y;
  if (!(std::abs(area) > 0) || !std::isfinite(area)) return {};
  const double sign = area > 0 ? 1 : -1;  // directions suffice
  return {(e1 * d2.y - e2 * d1.y) * sign, (e2 * d1.x - e1 * d2.x) * sign};
}

bool is_mirrored(const Frame& frame, const glm::vec3& normal) {
  return glm::dot(glm::cross(glm::dvec3(normal), frame.by_u), frame.by_v) > 0;
}

}  // namespace

void gather_vertices(Mesh& mesh, const std::vector<uint32_t>& source) {
  gather(mesh.positions, source);
  gather(mesh.normals, source);
  gather(mesh.tangents, source);
  for (auto& set : mesh.uv) gather(set, source);
  gather(mesh.colors, source);
  gather(mesh.joints, source);
  gather(mesh.weights, source);
  for (MorphTarget& target : mesh.morph_targets) {
    gather(target.positions, source);
    gather(target.normals, source);
    gather(target.tangents, source);
  }
}

void make_flat_normals(Mesh& mesh) {
  std::vector<uint32_t> source;
  source.reserve(3 * mesh.triangles.size());
  for (glm::uvec3& triangle : mesh.triangles) {
    const uint32_t first = static_cast<uint32_t>(source.size());
    for (int i = 0; i < 3; ++i) source.push_back(triangle[i]);
    triangle = glm::uvec3(first, first + 1, first + 2);
  }
  gather_vertices(mesh, source);
  mesh.normals.assign(source.size(), glm::vec3(0, 0, 1));
  for (const glm::uvec3& triangle : mesh.triangles) {
    const glm::vec3 normal = direction_or(area_normal(mesh, triangle), glm::vec3(0, 0, 1));
    for (int i = 0; i < 3; ++i) mesh.normals[triangle[i]] = normal;
  }
  mesh.flat_normals = true;
}

size_t repair_normals(Mesh& mesh) {
  std::vector<bool> bad(mesh.normals.size(), false);
  size_t count = 0;
  for (size_t i = 0; i < mesh.normals.size(); ++i) {
    const glm::vec3 unit = direction_or(glm::dvec3(mesh.normals[i]), glm::vec3(0));
    bad[i] = unit == glm::vec3(0);
    count += bad[i];
    mesh.normals[i] = unit;
  }
  if (count == 0) return 0;
  std::vector<glm::dvec3> sums(mesh.normals.size(), glm::dvec3(0));
  for (const glm::uvec3& triangle : mesh.triangles) {
    const glm::dvec3 normal = area_normal(mesh, triangle);
    for (int i = 0; i < 3; ++i) sums[triangle[i]] += normal;
  }
  for (size_t i = 0; i < mesh.normals.size(); ++i) {
    if (bad[i]) mesh.normals[i] = direction_or(sums[i], glm::vec3(0, 0, 1));
  }
  return count;
}

void make_tangents(Mesh& mesh, const std::vector<glm::vec2>& uv) {
  // Split vertices that triangles of both orientations use.
  constexpr int8_t unseen = -1;
  std::vector<int8_t> side(mesh.positions.size(), unseen);
  std::vector<uint32_t> source(mesh.positions.size()), other(mesh.positions.size(), 0);
  for (uint32_t i = 0; i < source.size(); ++i) source[i] = i;
  std::vector<Frame> frames;
  frames.reserve(mesh.triangles.size());
  for (glm::uvec3& triangle : mesh.triangles) {
    frames.push_back(texture_frame(mesh, triangle, uv));
    if (frames.back().by_u == glm::dvec3(0)) continue;
    for (int i = 0; i < 3; ++i) {
      const uint32_t v = triangle[i];
      const int8_t mirrored = is_mirrored(frames.back(), mesh.normals[v]);
      if (side[v] == unseen) side[v] = mirrored;
      if (side[v] == mirrored) continue;
      if (other[v] == 0) {
        other[v] = static_cast<uint32_t>(source.size());
        source.push_back(v);
      }
      triangle[i] = other[v];
    }
  }
  const size_t unsplit = mesh.positions.size();
  mesh.tangents.clear();
  gather_vertices(mesh, source);

  std::vector<glm::dvec3> sums(source.size(), glm::dvec3(0));
  for (size_t t = 0; t < mesh.triangles.size(); ++t) {
    const double length = glm::length(frames[t].by_u);
    if (!(length > 0) || !std::isfinite(length)) continue;
    for (int i = 0; i < 3; ++i) {
      const uint32_t v = mesh.triangles[t][i];
      const glm::vec3 along = in_plane(frames[t].by_u, mesh.normals[v]);
      sums[v] += glm::dvec3(along) * corner_angle(mesh, mesh.triangles[t], i);
    }
  }
  mesh.tangents.resize(source.size());
  for (size_t i = 0; i < source.size(); ++i) {
    const bool mirrored = (side[source[i]] == 1) != (i >= unsplit);
    mesh.tangents[i] = glm::vec4(in_plane(sums[i], mesh.normals[i]), mirrored ? -1.f : 1.f);
  }
}

void repair_tangents(Mesh& mesh) {
  for (size_t i = 0; i < mesh.tangents.size(); ++i) {
    const glm::vec3 direction =
        direction_or(glm::dvec3(glm::vec3(mesh.tangents[i])), any_perpendicular(mesh.normals[i]));
    mesh.tangents[i] = glm::vec4(direction, mesh.tangents[i].w < 0 ? -1.f : 1.f);
  }
}

}  // namespace lucarium
