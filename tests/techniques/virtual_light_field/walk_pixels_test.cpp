// SPDX-License-Identifier: Apache-2.0
// Pixels of a walk, of which those of a row share what their triangle has in common (walk_field.cl): each shows its own
// surface all the same.
#include <doctest/doctest.h>

#include <cmath>
#include <vector>

#include "device_fixture.h"
#include "lucarium/scene/builtin/builder.h"
#include "lucarium/session/session.h"
#include "made_scene.h"
#include "registry.h"
#include "tolerance.h"

using namespace lucarium;

namespace {

constexpr int kWidth = 24, kStrip = 3;  // [pixels]
const float kEdge = 4 * std::tan(0.5f * 40.f * 3.14159265f / 180);

float left_of(int column) { return kEdge * (static_cast<float>(column) / kWidth - 0.5f); }

void add_strip(Scene& scene, int first, int end, bool faces_viewer, const SceneMaterial& material) {
  const float a = left_of(first), b = left_of(end), h = 0.5f * kEdge;
  std::vector<glm::vec3> corners = {{a, -h, 0}, {b, -h, 0}, {b, h, 0}, {a, h, 0}};
  if (!faces_viewer) std::swap(corners[1], corners[3]);
  test::add_polygon(scene, corners, test::add_material(scene, material));
}

/// Strips of a plane close to a black wall, under a sky of radiance 1 that their near sides see whole: they show their
/// albedo. Every other two show their backs; the last ones are one polygon that grows brighter from left to right.
Scene strips() {
  Scene scene;
  for (int strip = 0; strip < 6; ++strip) {
    SceneMaterial material = test::lambert(strip % 2 == 0 ? 0.6f : 0.3f);
    material.double_sided = true;
    add_strip(scene, kStrip * strip, kStrip * (strip + 1), strip / 2 % 2 == 0, material);
  }
  add_strip(scene, 6 * kStrip, kWidth, true, test::lambert(1));
  Mesh& graded = scene.meshes.back();
  for (const glm::vec3& p : graded.positions) {
    const float albedo = p.x < left_of(7 * kStrip) ? 0.2f : 0.8f;
    graded.colors.emplace_back(albedo, albedo, albedo, 1.f);
  }
  test::add_polygon(scene, {{-3, -3, -0.05f}, {3, -3, -0.05f}, {3, 3, -0.05f}, {-3, 3, -0.05f}},
                    test::add_material(scene, test::lambert(0)));
  Environment sky;
  sky.width = sky.height = 4;
  sky.radiance.assign(16, glm::vec3(1));
  scene.environment = sky;
  scene.cameras.push_back(look_at_camera("before", {0, 0, 2}, {0, 0, 0}, 40.f));
  return scene;
}

}  // namespace

TEST_CASE("each pixel of a walk shows the material and the side of its own surface") {
  const Scene scene = strips();
  RenderSettings settings;
  settings.width = settings.height = kWidth;
  settings.max_bounces = 0;
  settings.pixel_sampling = LUCARIUM_PIXEL_CENTRE;
  settings.camera = scene.cameras.front();
  RenderSession session(test::test_device(), scene, test::registry().find("virtual_light_field"), settings,
                        {{"preset", "walkthrough"}, {"direct_mode", "exchange"}, {"dir_n", "4"}, {"texels", "2048"}});
  session.finish_light();
  session.run({.samples = 1});
  const Film film = session.resolve();
  const std::vector<float>& direct = film.find("direct")->pixels;
  for (int row = 0; row < kWidth; ++row)
    for (int column = 0; column < kWidth; ++column) {
      CAPTURE(row);
      CAPTURE(column);
      const int strip = column / kStrip;
      const double graded = 0.2 + 0.6 * (column + 0.5 - 6 * kStrip) / (kWidth - 6 * kStrip);
      const double albedo = strip >= 6 ? graded : strip % 2 == 0 ? 0.6 : 0.3;
      CHECK(static_cast<double>(direct[static_cast<size_t>(3 * (kWidth * row + column))]) ==
            test::relative(albedo, 0.01));
    }
}
