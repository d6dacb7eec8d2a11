// SPDX-License-Identifier: Apache-2.0
// Columns, arches and vaults of builtin:atrium. Declared in atrium.h.
#include <cmath>
#include <glm/gtc/constants.hpp>

#include "lucarium/scene/builtin/atrium.h"
#include "lucarium/scene/builtin/builder.h"

namespace lucarium::atrium {

namespace {

constexpr float pi = glm::pi<float>();
constexpr int flutes = 16, segments_per_flute = 5;

/// Point of a semicircle over the springing; step 0 at +X, `arch_segments` at -X.
glm::vec2 arch_point(float radius, int step) {
  if (step == arch_segments) return {-radius, springing};
  const float angle = pi * static_cast<float>(step) / arch_segments;
  return {radius * std::cos(angle), springing + radius * std::sin(angle)};
}

/// The arch's underside between z = -half_wall and half_wall.
void add_soffit(MeshBuilder& builder, float radius) {
  std::vector<glm::vec3> positions;
  for (int i = 0; i <= arch_segments; ++i) {
    const glm::vec2 p = arch_point(radius, i);
    positions.emplace_back(p.x, p.y, -half_wall);
    positions.emplace_back(p.x, p.y, half_wall);
  }
  builder.sheet(positions, arch_segments + 1, 2, false);
}

/// A quad in the plane z = `z`, given counter-clockwise seen from +Z; turned over on the far side.
void add_wall_quad(MeshBuilder& builder, float z, const glm::vec2& a, const glm::vec2& b, const glm::vec2& c,
                   const glm::vec2& d) {
  if (z > 0)
    builder.quad({a, z}, {b, z}, {c, z}, {d, z});
  else
    builder.quad({d, z}, {c, z}, {b, z}, {a, z});
}

}  // namespace

Mesh column_shaft() {
  // Profile (radius, y) of base and capital; the shaft between them swells a little and is fluted.
  const std::vector<std::vector<glm::vec2>> base = {
      {{0.335f, 0.10f}, {0.352f, 0.13f}, {0.36f, 0.165f}, {0.352f, 0.20f}, {0.335f, 0.225f}},
      {{0.335f, 0.225f}, {0.30f, 0.235f}, {0.283f, 0.265f}, {0.29f, 0.295f}},
      {{0.29f, 0.295f}, {0.305f, 0.31f}, {0.308f, 0.33f}, {0.295f, 0.35f}, {0.262f, 0.36f}},
      {{0.262f, 0.36f}, {0.25f, 0.375f}, {0.245f, 0.40f}}};
  const std::vector<std::vector<glm::vec2>> capital = {
      {{0.205f, 2.22f}, {0.228f, 2.235f}, {0.235f, 2.255f}, {0.228f, 2.275f}, {0.208f, 2.285f}},
      {{0.208f, 2.285f}, {0.212f, 2.36f}, {0.228f, 2.43f}, {0.262f, 2.49f}, {0.31f, 2.53f}},
      {{0.31f, 2.53f}, {0.335f, 2.545f}, {0.342f, 2.57f}, {0.34f, 2.60f}}};
  constexpr size_t segments = size_t{flutes} * segments_per_flute;
  MeshBuilder builder("column shaft");
  builder.revolve(base, segments);

  constexpr int rows = 8;
  std::vector<glm::vec3> positions;
  for (int row = 0; row <= rows; ++row) {
    const float t = static_cast<float>(row) / rows;
    const float y = 0.40f + t * (2.22f - 0.40f);
    const float radius = 0.245f + t * (0.205f - 0.245f) + 0.012f * std::sin(pi * t);
    // Flutes run out before both ends.
    const float depth = 0.016f * glm::smoothstep(0.f, 0.08f, t) * glm::smoothstep(0.f, 0.08f, 1 - t);
    for (size_t i = 0; i < segments; ++i) {
      const float angle = 2 * pi * static_cast<float>(i) / segments;
      const float r = radius - depth * (0.5f - 0.5f * std::cos(flutes * angle));
      positions.emplace_back(r * std::cos(angle), y, -r * std::sin(angle));
    }
  }
  builder.sheet(positions, rows + 1, segments, true);
  builder.revolve(capital, segments);
  return builder.take();
}

Mesh column_blocks() {
  return MeshBuilder("column blocks")
      .box({-0.38f, -0.02f, -0.38f}, {0.38f, 0.12f, 0.38f})
      .box({-0.36f, 2.575f, -0.36f}, {0.36f, 2.62f, 0.36f})
      .box({-0.41f, 2.61f, -0.41f}, {0.41f, springing, 0.41f})
      .take();
}

Mesh arcade_wall() {
  MeshBuilder builder("arcade wall");
  add_soffit(builder, arch_radius);
  for (const float z : {half_wall, -half_wall}) {
    for (int i = 0; i < arch_segments; ++i) {
      const glm::vec2 a = arch_point(arch_radius, i), b = arch_point(arch_radius, i + 1);
      add_wall_quad(builder, z, a, {a.x, storey}, {b.x, storey}, b);
    }
    const glm::vec2 foot(arch_radius, springing), outer(bay / 2, springing);
    add_wall_quad(builder, z, foot, outer, {outer.x, storey}, {foot.x, storey});
    add_wall_quad(builder, z, {-outer.x, springing}, {-foot.x, springing}, {-foot.x, storey}, {-outer.x, storey});
  }
  return builder.take();
}

Mesh arcade_trim() {
  // Profile of the archivolt: (radius, distance from the wall).
  const std::vector<std::vector<glm::vec2>> parts = {{{arch_radius, -0.01f}, {arch_radius, 0.035f}},
                                                     {{arch_radius, 0.035f}, {1.24f, 0.035f}},
                                                     {{1.24f, 0.035f}, {1.255f, 0.05f}, {1.27f, 0.055f}},
                                                     {{1.27f, 0.055f}, {1.35f, 0.06f}},
                                                     {{1.35f, 0.06f}, {1.375f, 0.075f}, {1.40f, 0.07f}, {1.41f, 0.05f}},
                                                     {{1.41f, 0.05f}, {1.41f, -0.01f}}};
  MeshBuilder builder("arcade trim");
  for (const auto& part : parts) {
    std::vector<glm::vec3> positions;
    for (const glm::vec2& p : part) {
      for (int i = 0; i <= arch_segments; ++i) {
        positions.emplace_back(glm::vec3(arch_point(p.x, i), -half_wall - p.y));
      }
    }
    builder.sheet(positions, part.size(), arch_segments + 1, false);
  }
  // Keystone: a wedge over the crown, and imposts at the springing.
  const float low = springing + arch_radius - 0.03f, high = springing + 1.46f;
  const glm::vec2 wedge[4] = {{-0.09f, low}, {0.09f, low}, {0.13f, high}, {-0.13f, high}};
  const float back = -half_wall + 0.05f, front = -half_wall - 0.11f;
  for (int i = 0; i < 4; ++i) {
    const glm::vec2 &a = wedge[i], &b = wedge[(i + 1) % 4];
    builder.quad({b, front}, {b, back}, {a, back}, {a, front});
  }
  builder.quad({wedge[3], front}, {wedge[2], front}, {wedge[1], front}, {wedge[0], front});
  builder.quad({wedge[0], back}, {wedge[1], back}, {wedge[2], back}, {wedge[3], back});
  return builder.take();
}

Mesh rib() {
  MeshBuilder builder("rib");
  add_soffit(builder, arch_radius);
  const float outer = vault_radius + 0.05f;  // ends inside the vault's hollow
  for (const float z : {half_wall, -half_wall}) {
    for (int i = 0; i < arch_segments; ++i) {
      add_wall_quad(builder, z, arch_point(arch_radius, i), arch_point(outer, i), arch_point(outer, i + 1),
                    arch_point(arch_radius, i + 1));
    }
  }
  return builder.take();
}

Mesh vault() {
  // Two barrels cross: the ceiling is the higher one. The web towards +X is a piece of the barrel along X; it reaches
  // from the diagonals x = |z| to the edge x = vault_radius. The other webs are turned by quarters.
  MeshBuilder builder("vault");
  for (int quarter = 0; quarter < 4; ++quarter) {
    std::vector<glm::vec3> positions;
    for (int i = 0; i <= arch_segments; ++i) {
      const glm::vec2 p = arch_point(vault_radius, i);
      const float z = p.x;
      for (const float x : {vault_radius, std::abs(z)}) {
        const glm::vec3 corners[4] = {{x, p.y, z}, {z, p.y, -x}, {-x, p.y, -z}, {-z, p.y, x}};
        positions.push_back(corners[quarter]);
      }
    }
    builder.sheet(positions, arch_segments + 1, 2, false);
  }
  return builder.take();
}

}  // namespace lucarium::atrium
