// SPDX-License-Identifier: Apache-2.0
// builtin:atrium: a courtyard of 12 x 18 m under an open sky, surrounded by two storeys of vaulted aisles behind
// arcades. Shell, slabs and roof are closed bodies and everything else overlaps them, so no light leaks in.
#include "lucarium/scene/builtin/atrium.h"

#include <cmath>
#include <glm/gtc/constants.hpp>
#include <glm/gtc/matrix_transform.hpp>

#include "lucarium/scene/builtin/builder.h"

namespace lucarium {

namespace {

using namespace atrium;

struct Palette {
  int stone, trim, plaster, wall, wainscot, upper_floor, ground;
  int light_tile, dark_tile, red_tile, cream_tile;
  int bronze, water, leaf, clay, iron, glow;
};

Palette add_palette(Scene& scene) {
  Palette p;
  p.stone = add_lambert(scene, "sandstone", {0.66f, 0.58f, 0.45f});
  p.trim = add_lambert(scene, "limestone", {0.74f, 0.70f, 0.61f});
  p.plaster = add_lambert(scene, "plaster", {0.76f, 0.73f, 0.66f});
  p.wall = add_lambert(scene, "ochre wall", {0.68f, 0.47f, 0.26f});
  p.wainscot = add_lambert(scene, "red wainscot", {0.40f, 0.11f, 0.07f});
  p.upper_floor = add_lambert(scene, "terracotta floor", {0.52f, 0.25f, 0.15f});
  p.ground = add_lambert(scene, "foundation", {0.35f, 0.32f, 0.28f});
  p.light_tile = add_dielectric(scene, "light marble", {0.72f, 0.68f, 0.60f}, 0.35f);
  p.dark_tile = add_dielectric(scene, "green marble", {0.10f, 0.20f, 0.16f}, 0.30f);
  p.red_tile = add_dielectric(scene, "red tile", {0.45f, 0.17f, 0.10f}, 0.55f);
  p.cream_tile = add_dielectric(scene, "cream tile", {0.70f, 0.60f, 0.44f}, 0.55f);
  p.bronze = add_metal(scene, "bronze", {0.72f, 0.48f, 0.24f}, 0.25f);
  p.water = add_dielectric(scene, "water", {0.03f, 0.09f, 0.10f}, 0.08f);
  p.leaf = add_lambert(scene, "leaves", {0.12f, 0.26f, 0.06f});
  p.clay = add_lambert(scene, "clay", {0.60f, 0.30f, 0.17f});
  p.iron = add_metal(scene, "iron", {0.35f, 0.33f, 0.31f}, 0.5f);
  p.glow = add_emitter(scene, "lantern light", {60.f, 36.f, 16.f});
  return p;
}

glm::mat4 placed(const glm::vec3& position, float quarter_turns = 0) {
  return glm::rotate(glm::translate(glm::mat4(1.f), position), quarter_turns * glm::half_pi<float>(),
                     glm::vec3(0, 1, 0));
}

int columns_along(float half) { return static_cast<int>(std::lround(2 * half / bay)) + 1; }

std::vector<glm::vec2> rectangle(float d0, float y0, float d1, float y1) {
  return {{d0, y0}, {d1, y0}, {d1, y1}, {d0, y1}};
}

/// Closed bodies that run around the court: walls, slabs, cornices.
void add_shell(Scene& scene, const Palette& p) {
  const auto add = [&](const char* name, const std::vector<glm::vec2>& polygon, int material) {
    add_instance(scene, add_mesh(scene, MeshBuilder(name).sweep_around(polygon, half_court).take()), material);
  };
  const float wall_face = aisle - half_wall;
  add("outer wall", rectangle(wall_face, -0.3f, wall_face + 0.5f, 2 * storey + 0.9f), p.wall);
  add("wainscot", rectangle(wall_face - 0.05f, -0.1f, wall_face + 0.1f, 1.1f), p.wainscot);
  add("wainscot cap", rectangle(wall_face - 0.08f, 1.06f, wall_face + 0.12f, 1.14f), p.trim);
  add("upper wainscot", rectangle(wall_face - 0.05f, storey - 0.1f, wall_face + 0.1f, storey + 0.9f), p.wainscot);
  add("upper floor", rectangle(-half_wall + 0.1f, storey - 0.35f, wall_face + 0.2f, storey), p.upper_floor);
  add("roof", rectangle(-half_wall + 0.1f, 2 * storey - 0.35f, wall_face + 0.3f, 2 * storey), p.upper_floor);
  const float face = -half_wall;
  const auto cornice = [&](float y, float top) {
    return std::vector<glm::vec2>{{half_wall + 0.04f, y - 0.16f}, {half_wall + 0.04f, y + top},
                                  {face - 0.17f, y + top},        {face - 0.17f, y + top - 0.07f},
                                  {face - 0.12f, y - 0.04f},      {face - 0.05f, y - 0.09f},
                                  {face - 0.03f, y - 0.16f}};
  };
  add("cornice", cornice(storey, 0.07f), p.trim);
  add("roof cornice", cornice(2 * storey, 0.16f), p.trim);
  add("parapet", rectangle(-0.1f, 2 * storey + 0.1f, 0.18f, 2 * storey + 0.75f), p.stone);
  add("parapet cap", rectangle(-0.15f, 2 * storey + 0.7f, 0.23f, 2 * storey + 0.82f), p.trim);
}

/// Calls `place(position, quarter turns)` for every bay of the court's four sides; the bay's -Z side faces the court.
template <class Place>
void for_each_arcade_bay(Place&& place) {
  for (int side = 0; side < 4; ++side) {
    const bool along_z = side % 2 == 0;  // sides 0 and 2 are the long ones at x = +-half_court.x
    const float half = along_z ? half_court.y : half_court.x, sign = side < 2 ? 1.f : -1.f;
    for (int i = 0; i + 1 < columns_along(half); ++i) {
      const float t = -half + (static_cast<float>(i) + 0.5f) * bay;
      const glm::vec3 position = along_z ? glm::vec3(sign * half_court.x, 0, t) : glm::vec3(t, 0, sign * half_court.y);
      // A turn by q quarters takes -Z to -X (q = 1), +Z (2), +X (3).
      place(position, along_z ? (sign > 0 ? 1.f : 3.f) : (sign > 0 ? 0.f : 2.f));
    }
  }
}

void add_columns(Scene& scene, const Palette& p) {
  const int shaft = add_mesh(scene, column_shaft()), blocks = add_mesh(scene, column_blocks());
  for (int level = 0; level < 2; ++level) {
    for (int i = 0; i < columns_along(half_court.x); ++i) {
      for (int j = 0; j < columns_along(half_court.y); ++j) {
        const bool on_edge =
            i == 0 || j == 0 || i + 1 == columns_along(half_court.x) || j + 1 == columns_along(half_court.y);
        if (!on_edge) continue;
        const glm::vec3 foot(-half_court.x + static_cast<float>(i) * bay, static_cast<float>(level) * storey,
                             -half_court.y + static_cast<float>(j) * bay);
        add_instance(scene, shaft, p.trim, placed(foot));
        add_instance(scene, blocks, p.stone, placed(foot));
      }
    }
  }
}

void add_arcades(Scene& scene, const Palette& p) {
  const int wall = add_mesh(scene, arcade_wall()), trim = add_mesh(scene, arcade_trim());
  const int post = add_mesh(scene, baluster()), top = add_mesh(scene, rail());
  constexpr int posts = 8;
  for_each_arcade_bay([&](const glm::vec3& position, float turn) {
    for (int level = 0; level < 2; ++level) {
      const glm::mat4 place = placed(position + glm::vec3(0, static_cast<float>(level) * storey, 0), turn);
      add_instance(scene, wall, p.stone, place);
      add_instance(scene, trim, p.trim, place);
    }
    const glm::mat4 gallery = placed(position + glm::vec3(0, storey + 0.06f, 0), turn);
    add_instance(scene, top, p.trim, gallery);
    for (int i = 0; i < posts; ++i) {
      const float x = (static_cast<float>(i) - 0.5f * (posts - 1)) * 0.27f;
      add_instance(scene, post, p.trim, gallery * glm::translate(glm::mat4(1.f), glm::vec3(x, 0, 0)));
    }
  });
}

/// Ribs from the columns to the wall, pilasters under them, and a vault over every bay between.
void add_aisles(Scene& scene, const Palette& p) {
  const int arch = add_mesh(scene, rib()), ceiling = add_mesh(scene, vault());
  const float face = aisle - half_wall;
  const int pilaster = add_mesh(scene, MeshBuilder("pilaster")
                                           .box({-0.2f, -0.05f, -0.18f}, {0.2f, 2.5f, 0.1f})
                                           .box({-0.25f, -0.04f, -0.22f}, {0.25f, 0.22f, 0.1f})
                                           .box({-0.26f, 2.47f, -0.2f}, {0.26f, springing, 0.1f})
                                           .take());
  for (int level = 0; level < 2; ++level) {
    const float y = static_cast<float>(level) * storey;
    for (const float sign : {1.f, -1.f}) {
      for (int j = 0; j < columns_along(half_court.y); ++j) {
        const float z = -half_court.y + static_cast<float>(j) * bay;
        add_instance(scene, arch, p.trim, placed({sign * (half_court.x + aisle / 2), y, z}));
        add_instance(scene, pilaster, p.trim, placed({sign * (half_court.x + face), y, z}, sign > 0 ? 1.f : 3.f));
      }
      for (int i = 0; i < columns_along(half_court.x); ++i) {
        const float x = -half_court.x + static_cast<float>(i) * bay;
        add_instance(scene, arch, p.trim, placed({x, y, sign * (half_court.y + aisle / 2)}, 1.f));
        add_instance(scene, pilaster, p.trim, placed({x, y, sign * (half_court.y + face)}, sign > 0 ? 0.f : 2.f));
      }
    }
    const int nx = columns_along(half_court.x) + 1, nz = columns_along(half_court.y) + 1;
    for (int i = 0; i < nx; ++i) {
      for (int j = 0; j < nz; ++j) {
        if (i > 0 && j > 0 && i + 1 < nx && j + 1 < nz) continue;
        const glm::vec3 center(-half_court.x + (static_cast<float>(i) - 0.5f) * bay, y,
                               -half_court.y + (static_cast<float>(j) - 0.5f) * bay);
        add_instance(scene, ceiling, p.plaster, placed(center));
      }
    }
  }
}

/// Tiles of one size over a rectangle, shared out to materials by `choose(column, row)`.
template <class Choose>
void add_tiles(Scene& scene, const char* name, const glm::vec2& low, const glm::vec2& high, float size,
               const std::vector<int>& materials, Choose&& choose) {
  std::vector<MeshBuilder> builders(materials.size(), MeshBuilder(name));
  const int columns = static_cast<int>(std::lround((high.x - low.x) / size));
  const int rows = static_cast<int>(std::lround((high.y - low.y) / size));
  for (int i = 0; i < columns; ++i) {
    for (int j = 0; j < rows; ++j) {
      const float x0 = low.x + static_cast<float>(i) * size, z0 = low.y + static_cast<float>(j) * size;
      const float x1 = x0 + size, z1 = z0 + size;
      const int which = choose(i, j, columns, rows);
      builders[static_cast<size_t>(which)].quad({x0, 0, z0}, {x0, 0, z1}, {x1, 0, z1}, {x1, 0, z0});
    }
  }
  for (size_t k = 0; k < materials.size(); ++k) {
    if (builders[k].triangle_count() > 0) add_instance(scene, add_mesh(scene, builders[k].take()), materials[k]);
  }
}

void add_floor(Scene& scene, const Palette& p) {
  const glm::vec2 outer = half_court + glm::vec2(aisle);
  add_instance(scene,
               add_mesh(scene, MeshBuilder("foundation")
                                   .box({-outer.x - 1, -0.6f, -outer.y - 1}, {outer.x + 1, -0.03f, outer.y + 1})
                                   .take()),
               p.ground);
  add_tiles(scene, "court floor", -half_court, half_court, 0.75f, {p.light_tile, p.dark_tile, p.red_tile},
            [](int i, int j, int columns, int rows) {
              const int border = std::min(std::min(i, columns - 1 - i), std::min(j, rows - 1 - j));
              if (border == 1) return 2;
              return border == 0 ? 0 : (i + j) % 2;
            });
  const auto checker = [](int i, int j, int, int) { return (i + j) % 2; };
  const std::vector<int> tiles = {p.red_tile, p.cream_tile};
  for (const float sign : {1.f, -1.f}) {
    const float z0 = sign > 0 ? half_court.y : -outer.y, x0 = sign > 0 ? half_court.x : -outer.x;
    add_tiles(scene, "aisle floor", {-outer.x, z0}, {outer.x, z0 + aisle}, 0.5f, tiles, checker);
    add_tiles(scene, "aisle floor", {x0, -half_court.y}, {x0 + aisle, half_court.y}, 0.5f, tiles, checker);
  }
}

void add_furniture(Scene& scene, const Palette& p) {
  add_instance(scene, add_mesh(scene, fountain_stone()), p.trim);
  add_instance(scene, add_mesh(scene, fountain_water()), p.water);
  MeshBuilder ball("finial");
  std::vector<std::vector<glm::vec2>> arc(1);
  for (int i = 0; i <= 24; ++i) {
    const float angle = glm::pi<float>() * (static_cast<float>(i) / 24 - 0.5f);
    arc[0].emplace_back(i == 0 || i == 24 ? 0.f : 0.21f * std::cos(angle), 1.72f + 0.21f * std::sin(angle));
  }
  add_instance(scene, add_mesh(scene, ball.revolve(arc, 48).take()), p.bronze);

  const int pot = add_mesh(scene, planter()), bush = add_mesh(scene, topiary());
  for (const float x : {-4.3f, 4.3f}) {
    for (const float z : {-7.2f, -2.6f, 2.6f, 7.2f}) {
      add_instance(scene, pot, p.clay, placed({x, 0, z}));
      add_instance(scene, bush, p.leaf, placed({x, 0, z}, x + z));
    }
  }

  // A row of lanterns under the vaults of both long aisles.
  const int glass = add_mesh(scene, lantern_glass()), frame = add_mesh(scene, lantern_frame());
  for (const float sign : {1.f, -1.f}) {
    for (int i = 0; i + 1 < columns_along(half_court.y); ++i) {
      const glm::vec3 position(sign * (half_court.x + aisle / 2), 2.95f,
                               -half_court.y + (static_cast<float>(i) + 0.5f) * bay);
      add_instance(scene, glass, p.glow, placed(position));
      add_instance(scene, frame, p.iron, placed(position));
    }
  }
}

}  // namespace

Scene make_atrium() {
  Scene scene;
  const Palette palette = add_palette(scene);
  add_shell(scene, palette);
  add_columns(scene, palette);
  add_arcades(scene, palette);
  add_aisles(scene, palette);
  add_floor(scene, palette);
  add_furniture(scene, palette);

  scene.environment = clear_sky(1.6f);
  SceneLight sun;
  sun.name = "sun";
  sun.type = LightType::directional;
  sun.intensity = 26.f * glm::vec3(1.f, 0.9f, 0.72f);
  sun.world_from_light = frame_along(glm::vec3(0), {0.55f, -0.95f, -0.38f});
  scene.lights.push_back(sun);
  scene.exposure = -1.8f;

  scene.cameras.push_back(look_at_camera("court", {-2.7f, 1.7f, 8.5f}, {1.5f, 2.9f, -6.f}, 62.f));
  scene.cameras.push_back(look_at_camera("aisle", {7.75f, 1.6f, 10.4f}, {7.1f, 1.9f, -8.f}, 58.f));
  scene.cameras.push_back(look_at_camera("gallery", {-6.35f, 6.3f, 7.6f}, {2.5f, 1.6f, -3.5f}, 65.f));
  return scene;
}

}  // namespace lucarium
