// SPDX-License-Identifier: Apache-2.0
// Atlases laid out by TEXCOORD_1: taken where it is usable, refused by name where it is not.
#include "lucarium/base/error.h"
#include "lucarium/base/numbers.h"
#include "lucarium/scene/builtin/scenes.h"
#include "support.h"
#include "tolerance.h"
#include "touch.h"

using namespace lucarium;
using namespace lucarium::test;

namespace {

/// A grid of quads: position(u, v) for u, v in [0, 1], and its texture coordinates.
struct Sheet {
  std::function<glm::vec3(float, float)> position;
  std::function<glm::vec2(float, float)> texcoord = [](float u, float v) { return glm::vec2(u, v); };
  uint32_t cells_u = 8, cells_v = 8;
};

void add_sheet(AtlasGeometry& g, const Sheet& sheet, uint32_t instance) {
  const uint32_t first = static_cast<uint32_t>(g.positions.size()), row = sheet.cells_u + 1;
  for (uint32_t j = 0; j <= sheet.cells_v; ++j) {
    for (uint32_t i = 0; i <= sheet.cells_u; ++i) {
      const float u = float(i) / float(sheet.cells_u), v = float(j) / float(sheet.cells_v);
      g.positions.push_back(sheet.position(u, v));
      g.normals.emplace_back(0, 1, 0);
      g.texcoord1.push_back(sheet.texcoord(u, v));
    }
  }
  for (uint32_t j = 0; j < sheet.cells_v; ++j) {
    for (uint32_t i = 0; i < sheet.cells_u; ++i) {
      const uint32_t a = first + j * row + i;
      g.triangles.emplace_back(a, a + 1, a + row + 1);
      g.triangles.emplace_back(a, a + row + 1, a + row);
      g.instance.insert(g.instance.end(), 2, instance);
    }
  }
  g.two_sided.resize(instance + 1, 0);
  g.has_texcoord1.resize(instance + 1, 1);
  g.names.resize(instance + 1, "sheet");
}

/// A cylinder's wall of radius 1 and height 2, unrolled with its proportions.
Sheet cylinder() {
  Sheet sheet;
  sheet.position = [](float u, float v) {
    return glm::vec3(std::cos(2 * pi * double(u)), 2 * v, -std::sin(2 * pi * double(u)));
  };
  sheet.texcoord = [](float u, float v) { return glm::vec2(u, v / float(pi)); };
  sheet.cells_u = 48;
  return sheet;
}

Sheet plane(float size) {
  Sheet sheet;
  sheet.position = [size](float u, float v) { return glm::vec3(size * u, 0, -size * v); };
  return sheet;
}

std::string refusal(const AtlasGeometry& g) {
  AtlasLayoutOptions options;
  options.texel_count = 1000;
  try {
    make_atlas_layout(g, options);
  } catch (const Error& error) {
    CHECK(error.error_class() == ErrorClass::input);
    return error.what();
  }
  return "accepted";
}

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

}  // namespace

TEST_CASE("a cylinder is one chart when its coordinates say so") {
  AtlasGeometry g;
  add_sheet(g, cylinder(), 0);
  AtlasLayoutOptions options;
  options.texel_count = 2000;
  const AtlasLayout by_texcoord = make_atlas_layout(g, options);
  CHECK(by_texcoord.charts.size() == 1);
  CHECK(double(by_texcoord.info.texel_count) == test::relative(2000, 0.05));
  check_layout(g, by_texcoord, 5000);
  CHECK(bad_texels(g, by_texcoord).empty());
  for (const AtlasTexel& texel : by_texcoord.texels) CHECK(double(texel.area) == test::relative(4 * pi / 2000, 0.1));
  g.has_texcoord1.clear();
  CHECK(make_atlas_layout(g, options).charts.size() > 3);
}

TEST_CASE("mirrored islands, and meshes without coordinates, are no obstacle") {
  AtlasGeometry g;
  Sheet mirrored = plane(2);
  mirrored.texcoord = [](float u, float v) { return glm::vec2(1 - u, v); };
  add_sheet(g, mirrored, 0);
  add_sheet(g, cylinder(), 1);
  Sheet without = plane(1);
  without.texcoord = [](float, float) { return glm::vec2(0); };
  add_sheet(g, without, 2);
  g.has_texcoord1[2] = 0;
  AtlasLayoutOptions options;
  options.texel_count = 5000;
  const AtlasLayout layout = make_atlas_layout(g, options);
  CHECK(layout.charts.size() == 3);
  CHECK(double(layout.info.texel_count) == test::relative(5000, 0.05));
  check_layout(g, layout, 5000);
  CHECK(bad_texels(g, layout).empty());
}

TEST_CASE("what cannot be used is refused by name and triangle") {
  AtlasGeometry g;
  Sheet sheet = plane(1);
  SUBCASE("folded") {
    sheet.texcoord = [](float u, float v) { return glm::vec2(u < 0.5f ? u : 1.f - u, v); };
    add_sheet(g, sheet, 0);
    CHECK(contains(refusal(g), "folded"));
  }
  SUBCASE("two islands over each other") {
    sheet.cells_u = 1;
    sheet.texcoord = [](float u, float v) { return glm::vec2(0.4f * u, 0.4f * v); };
    add_sheet(g, sheet, 0);
    Sheet other = sheet;
    other.position = [](float u, float v) { return glm::vec3(u, 3, -v); };
    other.texcoord = [](float u, float v) { return glm::vec2(0.3f + 0.4f * u, 0.3f + 0.4f * v); };
    add_sheet(g, other, 0);
    const std::string text = refusal(g);
    CHECK(contains(text, "overlaps itself"));
    CHECK(contains(text, "mesh \"sheet\" (instance 0)"));
  }
  SUBCASE("islands that only touch are accepted") {
    sheet.texcoord = [](float u, float v) { return glm::vec2(0.5f * u, 0.5f * v); };
    add_sheet(g, sheet, 0);
    Sheet other = sheet;
    other.position = [](float u, float v) { return glm::vec3(u, 3, -v); };
    other.texcoord = [](float u, float v) { return glm::vec2(0.5f + 0.5f * u, 0.5f * v); };
    add_sheet(g, other, 0);
    CHECK(refusal(g) == "accepted");
  }
  SUBCASE("uneven density") {
    sheet.texcoord = [](float u, float v) { return glm::vec2(u * u * u, v); };
    add_sheet(g, sheet, 0);
    CHECK(contains(refusal(g), "density"));
  }
  SUBCASE("stretched to one side, though of even area") {
    sheet.texcoord = [](float u, float v) { return glm::vec2(2.2f * u, v / 2.2f); };
    add_sheet(g, sheet, 0);
    CHECK(contains(refusal(g), "density"));
  }
  SUBCASE("stretched by less than two is accepted") {
    sheet.texcoord = [](float u, float v) { return glm::vec2(1.8f * u, v / 1.8f); };
    add_sheet(g, sheet, 0);
    CHECK(refusal(g) == "accepted");
  }
  SUBCASE("all in one point") {
    sheet.texcoord = [](float, float) { return glm::vec2(0.5f); };
    add_sheet(g, sheet, 0);
    CHECK(contains(refusal(g), "has no area"));
  }
  SUBCASE("none there") {
    add_sheet(g, sheet, 0);
    g.has_texcoord1[0] = 0;
    CHECK(contains(refusal(g), "no mesh of the scene has TEXCOORD_1"));
  }
}

TEST_CASE("a scene's second set of coordinates reaches the atlas") {
  Scene scene = make_builtin_scene("cornell");
  CHECK_THROWS_AS(make_atlas_layout(geometry_of(scene, true), {}), Error);
  for (Mesh& mesh : scene.meshes) mesh.uv[1] = std::vector<glm::vec2>(mesh.positions.size(), glm::vec2(0.25f));
  const AtlasGeometry g = geometry_of(scene, true);
  CHECK(g.texcoord1.at(0) == glm::vec2(0.25f));
  CHECK(contains(refusal(g), "has no area"));
}
