// SPDX-License-Identifier: Apache-2.0
// Pixels of a walk, of which those of a row share what their triangle has in common (walk_field.cl): each shows its own
// surface all the same.
#include <doctest/doctest.h>

#include <cmath>
#include <vector>

#include "device_fixture.h"
#include "lucarium/scene/builtin/builder.h"
#include "lucarium/scene/load/load_scene.h"
#include "lucarium/session/session.h"
#include "made_scene.h"
#include "registry.h"
#include "tolerance.h"

using namespace lucarium;

namespace {

constexpr int kWidth = 24, kStrip = 3;  // [pixels]
const float kEdge = 4 * std::tan(0.5f * 40.f * 3.14159265f / 180);

float left_of(int column) { return kEdge * (static_cast<float>(column) / kWidth - 0.5f); }

void add_strip(Scene& scene, int first, int end, bool faces_viewer, const SceneMaterial& material, float bottom = -1,
               float top = 1) {
  const float a = left_of(first), b = left_of(end), h = 0.5f * kEdge;
  std::vector<glm::vec3> corners = {{a, h * bottom, 0}, {b, h * bottom, 0}, {b, h * top, 0}, {a, h * top, 0}};
  if (!faces_viewer) std::swap(corners[1], corners[3]);
  test::add_polygon(scene, corners, test::add_material(scene, material));
}

/// Strips of a plane close to a black wall, under a sky of radiance 1 that their near sides see whole: they show their
/// albedo. Two of them show their backs, and the lower half of the sixth; the last ones are one polygon that grows
/// brighter from left to right, so that its pixels, and those of the sixth beside it, are shown one by one.
Scene strips() {
  Scene scene;
  for (int strip = 0; strip < 6; ++strip) {
    SceneMaterial material = test::lambert(strip % 2 == 0 ? 0.6f : 0.3f);
    material.double_sided = true;
    if (strip < 5) {
      add_strip(scene, kStrip * strip, kStrip * (strip + 1), strip / 2 % 2 == 0, material);
      continue;
    }
    add_strip(scene, kStrip * strip, kStrip * (strip + 1), true, material, 0, 1);
    add_strip(scene, kStrip * strip, kStrip * (strip + 1), false, material, -1, 0);
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

/// What a settled field shows: direct and indirect light of pixels.
std::vector<float> shown(const Scene& scene, const std::vector<std::pair<std::string, std::string>>& eye,
                         const std::string& store) {
  RenderSettings settings;
  settings.width = 61;
  settings.height = 23;
  settings.pixel_sampling = LUCARIUM_PIXEL_CENTRE;
  settings.camera = scene.cameras.front();
  std::vector<std::pair<std::string, std::string>> parameters = {
      {"preset", "walkthrough"}, {"dir_n", "4"}, {"cells", "48"}, {"texels", "2048"}, {"store", store}};
  parameters.insert(parameters.end(), eye.begin(), eye.end());
  RenderSession session(test::test_device(), scene, test::registry().find("virtual_light_field"), settings, parameters);
  session.finish_light();
  session.run({.samples = 1});
  const Film film = session.resolve();
  std::vector<float> result = film.find("direct")->pixels;
  const std::vector<float>& indirect = film.find("indirect")->pixels;
  result.insert(result.end(), indirect.begin(), indirect.end());
  return result;
}

}  // namespace

TEST_CASE("pixels of a walk show by blocks of eight what points of a G-buffer show one by one") {
  // Without ideal lobes eye_specular=trace has nothing to trace, but goes by the G-buffer.
  SceneOverrides rough;
  rough.materials = {"mirror:roughness=0.6", "glass:roughness=0.6"};
  SceneOverrides metal;
  metal.materials = {"mirror:roughness=0.6"};
  const std::pair<Scene, const char*> cases[] = {{load_scene("builtin:cornell-mirror", metal), "tiles"},
                                                 {load_scene("builtin:cornell-mirror", metal), "csr"},
                                                 {load_scene("builtin:solids", rough), "tiles"},
                                                 {load_scene("builtin:blocks:triangles=10000"), "tiles"}};
  for (const auto& [scene, store] : cases)
    for (const char* interpolation : {"bary", "nearest"}) {
      CAPTURE(scene.materials.front().name);
      const std::pair<std::string, std::string> all = {"eye_interp", interpolation};
      const std::vector<float> walked = shown(scene, {all}, store);
      const std::vector<float> expected = shown(scene, {all, {"eye_specular", "trace"}}, store);
      REQUIRE(walked.size() == expected.size());
      size_t differ = 0, lit = 0;
      for (size_t i = 0; i < walked.size(); ++i) {
        lit += expected[i] > 0;
        differ += std::abs(walked[i] - expected[i]) > 1e-4f * expected[i] + 1e-6f;
      }
      CAPTURE(interpolation);
      CHECK(differ == 0);
      CHECK(4 * lit > walked.size());
    }
}

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
