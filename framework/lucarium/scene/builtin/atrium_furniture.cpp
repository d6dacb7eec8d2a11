// SPDX-License-Identifier: Apache-2.0
// Balustrades, lanterns, fountain and planters of builtin:atrium. Declared in atrium.h.
#include <cmath>

#include "lucarium/scene/builtin/atrium.h"
#include "lucarium/scene/builtin/builder.h"

namespace lucarium::atrium {

Mesh baluster() {
  return MeshBuilder("baluster")
      .revolve({{{0.075f, 0.f}, {0.075f, 0.05f}},
                {{0.075f, 0.05f},
                 {0.045f, 0.075f},
                 {0.06f, 0.13f},
                 {0.078f, 0.21f},
                 {0.07f, 0.31f},
                 {0.045f, 0.43f},
                 {0.032f, 0.55f},
                 {0.034f, 0.64f}},
                {{0.034f, 0.64f}, {0.055f, 0.66f}, {0.055f, 0.69f}},
                {{0.055f, 0.69f}, {0.07f, 0.71f}, {0.07f, 0.78f}}},
               10)
      .take();
}

Mesh rail() {
  return MeshBuilder("rail")
      .box({-bay / 2 + 0.2f, 0.76f, -0.12f}, {bay / 2 - 0.2f, 0.84f, 0.12f})
      .box({-bay / 2 + 0.21f, 0.83f, -0.15f}, {bay / 2 - 0.21f, 0.89f, 0.15f})
      .take();
}

Mesh lantern_glass() {
  return MeshBuilder("lantern glass")
      .revolve({{{0.f, -0.13f}, {0.075f, -0.13f}}, {{0.075f, -0.13f}, {0.11f, 0.12f}}}, 8)
      .take();
}

Mesh lantern_frame() {
  return MeshBuilder("lantern frame")
      .revolve({{{0.f, 0.115f}, {0.14f, 0.115f}},
                {{0.14f, 0.115f}, {0.14f, 0.135f}},
                {{0.14f, 0.135f}, {0.09f, 0.17f}, {0.05f, 0.23f}, {0.014f, 0.25f}},
                {{0.014f, 0.25f}, {0.014f, 1.1f}}},
               12)
      .take();
}

Mesh fountain_stone() {
  return MeshBuilder("fountain stone")
      // Basin: outer wall, rim, inner wall, floor.
      .revolve({{{1.62f, -0.02f}, {1.62f, 0.10f}},
                {{1.62f, 0.10f}, {1.52f, 0.14f}, {1.48f, 0.22f}, {1.50f, 0.34f}, {1.56f, 0.42f}},
                {{1.56f, 0.42f}, {1.62f, 0.43f}, {1.64f, 0.47f}, {1.61f, 0.51f}},
                {{1.61f, 0.51f}, {1.36f, 0.51f}},
                {{1.36f, 0.51f}, {1.34f, 0.49f}, {1.34f, 0.15f}},
                {{1.34f, 0.15f}, {0.f, 0.15f}}},
               64)
      // Stem and bowl.
      .revolve({{{0.34f, 0.14f}, {0.34f, 0.30f}},
                {{0.34f, 0.30f}, {0.24f, 0.36f}, {0.15f, 0.50f}, {0.12f, 0.70f}, {0.14f, 0.92f}, {0.20f, 1.02f}},
                {{0.20f, 1.02f}, {0.42f, 1.06f}, {0.66f, 1.15f}, {0.80f, 1.28f}, {0.84f, 1.36f}},
                {{0.84f, 1.36f}, {0.87f, 1.38f}, {0.86f, 1.41f}, {0.80f, 1.41f}},
                {{0.80f, 1.41f}, {0.74f, 1.32f}, {0.58f, 1.23f}, {0.36f, 1.18f}, {0.10f, 1.17f}}},
               48)
      .revolve({{{0.13f, 1.16f}, {0.07f, 1.24f}, {0.06f, 1.40f}, {0.09f, 1.50f}, {0.12f, 1.54f}}}, 32)
      .take();
}

Mesh fountain_water() {
  return MeshBuilder("fountain water")
      .revolve({{{1.345f, 0.40f}, {0.f, 0.40f}}}, 64)
      .revolve({{{0.765f, 1.345f}, {0.f, 1.345f}}}, 48)
      .take();
}

Mesh planter() {
  return MeshBuilder("planter")
      .revolve({{{0.30f, -0.02f}, {0.30f, 0.06f}},
                {{0.30f, 0.06f}, {0.24f, 0.10f}, {0.26f, 0.22f}, {0.33f, 0.42f}, {0.40f, 0.60f}},
                {{0.40f, 0.60f}, {0.44f, 0.62f}, {0.445f, 0.66f}, {0.42f, 0.69f}},
                {{0.42f, 0.69f}, {0.36f, 0.69f}},
                {{0.36f, 0.69f}, {0.35f, 0.60f}, {0.f, 0.60f}}},
               40)
      .take();
}

Mesh topiary() {
  // A clipped bush: a sphere with dents of fixed, irrational frequencies.
  MeshBuilder builder("topiary");
  const auto dented = [](const glm::vec3& p) {
    const float dent =
        std::sin(9.1f * p.x + 2.3f * p.y) + std::sin(8.3f * p.y + 3.7f * p.z) + std::sin(10.7f * p.z - 4.1f * p.x);
    return (0.52f + 0.012f * dent) * p + glm::vec3(0, 1.02f, 0);
  };
  for (const auto& [a, b, c] : icosphere(3)) builder.triangle(dented(a), dented(b), dented(c));
  return builder.take();
}

}  // namespace lucarium::atrium
