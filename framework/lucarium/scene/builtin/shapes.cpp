// SPDX-License-Identifier: Apache-2.0
// Curved shapes for the built-in scenes. Declared in builder.h.
#include <cmath>
#include <glm/gtc/constants.hpp>

#include "lucarium/scene/builtin/builder.h"

namespace lucarium {

MeshBuilder& MeshBuilder::sheet(const std::vector<glm::vec3>& positions, size_t rows, size_t columns, bool closed) {
  const size_t quads = closed ? columns : columns - 1;
  const auto at = [&](size_t row, size_t column) { return row * columns + column % columns; };
  std::vector<glm::vec3> normals(positions.size(), glm::vec3(0));
  const auto add_normal = [&](size_t a, size_t b, size_t c) {
    const glm::vec3 n = glm::cross(positions[b] - positions[a], positions[c] - positions[a]);
    for (const size_t i : {a, b, c}) normals[i] += n;
  };
  for (size_t r = 0; r + 1 < rows; ++r) {
    for (size_t c = 0; c < quads; ++c) {
      add_normal(at(r, c), at(r, c + 1), at(r + 1, c + 1));
      add_normal(at(r, c), at(r + 1, c + 1), at(r + 1, c));
    }
  }
  const uint32_t first = static_cast<uint32_t>(mesh_.positions.size());
  for (size_t i = 0; i < positions.size(); ++i) {
    vertex(positions[i], normals[i] == glm::vec3(0) ? glm::vec3(0, 1, 0) : normals[i]);
  }
  for (size_t r = 0; r + 1 < rows; ++r) {
    for (size_t c = 0; c < quads; ++c) {
      const auto index = [&](size_t row, size_t column) { return first + static_cast<uint32_t>(at(row, column)); };
      face(index(r, c), index(r, c + 1), index(r + 1, c + 1));
      face(index(r, c), index(r + 1, c + 1), index(r + 1, c));
    }
  }
  return *this;
}

MeshBuilder& MeshBuilder::revolve(const std::vector<std::vector<glm::vec2>>& parts, size_t segments) {
  for (const std::vector<glm::vec2>& part : parts) {
    std::vector<glm::vec3> positions;
    for (const glm::vec2& p : part) {
      for (size_t i = 0; i < segments; ++i) {
        // From +X towards -Z: counter-clockwise seen from above.
        const float angle = 2 * glm::pi<float>() * static_cast<float>(i) / static_cast<float>(segments);
        positions.emplace_back(p.x * std::cos(angle), p.y, -p.x * std::sin(angle));
      }
    }
    sheet(positions, part.size(), segments, true);
  }
  return *this;
}

MeshBuilder& MeshBuilder::sweep_around(const std::vector<glm::vec2>& polygon, const glm::vec2& half) {
  constexpr int signs[4][2] = {{1, 1}, {1, -1}, {-1, -1}, {-1, 1}};  // counter-clockwise seen from above
  const auto at = [&](size_t i, int corner) {
    const glm::vec2& p = polygon[i % polygon.size()];
    return glm::vec3(static_cast<float>(signs[corner % 4][0]) * (half.x + p.x), p.y,
                     static_cast<float>(signs[corner % 4][1]) * (half.y + p.x));
  };
  for (size_t i = 0; i < polygon.size(); ++i) {
    for (int corner = 0; corner < 4; ++corner) {
      quad(at(i, corner), at(i, corner + 1), at(i + 1, corner + 1), at(i + 1, corner));
    }
  }
  return *this;
}

std::vector<std::array<glm::vec3, 3>> icosphere(int levels) {
  const float t = 0.5f * (1 + std::sqrt(5.f));
  const glm::vec3 p[12] = {{-1, t, 0},  {1, t, 0},  {-1, -t, 0}, {1, -t, 0}, {0, -1, t},  {0, 1, t},
                           {0, -1, -t}, {0, 1, -t}, {t, 0, -1},  {t, 0, 1},  {-t, 0, -1}, {-t, 0, 1}};
  const int f[20][3] = {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
                        {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
                        {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}};
  std::vector<std::array<glm::vec3, 3>> faces;
  for (const auto& i : f) {
    faces.push_back({glm::normalize(p[i[0]]), glm::normalize(p[i[1]]), glm::normalize(p[i[2]])});
  }
  for (int level = 0; level < levels; ++level) {
    std::vector<std::array<glm::vec3, 3>> finer;
    for (const auto& [a, b, c] : faces) {
      const glm::vec3 ab = glm::normalize(a + b), bc = glm::normalize(b + c), ca = glm::normalize(c + a);
      finer.push_back({a, ab, ca});
      finer.push_back({ab, b, bc});
      finer.push_back({ca, bc, c});
      finer.push_back({ab, bc, ca});
    }
    faces = std::move(finer);
  }
  return faces;
}

}  // namespace lucarium
