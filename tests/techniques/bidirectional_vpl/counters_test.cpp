// SPDX-License-Identifier: Apache-2.0
// What bidirectional_vpl counts: rays by kind, candidates, splats, and paths that end at a limit.
#include <algorithm>
#include <cmath>

#include "bidirectional_rig.h"
#include "made_scene.h"

using namespace lucarium;
using namespace lucarium::test;

namespace {

std::map<std::string, double> counters(const Scene& scene, const Picture& picture, const Parameters& parameters) {
  RenderSettings settings;
  settings.width = picture.width;
  settings.height = picture.height;
  settings.max_bounces = picture.max_bounces;
  settings.seed = picture.seed;
  settings.pixel_sampling = picture.pixel_sampling;
  settings.camera = scene.cameras.front();
  RenderSession session(test_device(), scene, registry().find("bidirectional_vpl"), settings, parameters);
  session.run({.iterations = picture.iterations});
  return session.technique().counters();
}

/// A closed box with a point light; the camera inside sees walls alone.
Scene closed_box(bool open, float reflectance = 0.5f) {
  Scene scene;
  const int walls = add_material(scene, lambert(reflectance));
  if (open)
    add_horizontal(scene, 0, -0.5f, 0, 1, 1, true, walls);
  else
    add_box(scene, glm::vec3(-0.5f), glm::vec3(0.5f), true, walls);
  add_light(scene, LightType::point, 1, {0.1f, 0.1f, -0.2f}, {0, -1, 0});
  scene.cameras = {look_orthographic({0, 0, 0}, {0, -0.5f, 0}, 0.4f)};
  return scene;
}

Picture small_picture(int max_bounces, uint64_t iterations) {
  Picture picture;
  picture.width = picture.height = 16;
  picture.max_bounces = max_bounces;
  picture.iterations = iterations;
  return picture;
}

}  // namespace

TEST_CASE("counters of rays: every path of a closed box has the same number") {
  // One bounce: two vertices with a light sample each, the first with a connection, and the ray that would find a lamp.
  const double paths = 16 * 16 * 3, light_paths = 3 * 64;
  const auto found = counters(closed_box(false), small_picture(1, 3), {{"light_paths", "64"}, {"camera_edges", "3"}});
  CHECK(found.at("paths") == paths);
  CHECK(found.at("camera_rays") == 3 * paths);
  CHECK(found.at("light_sample_rays") == 2 * paths);
  CHECK(found.at("candidates") == 32 * paths);
  CHECK(found.at("light_paths") == light_paths);
  CHECK(found.at("light_path_rays") == 2 * light_paths);
  CHECK(found.at("light_path_misses") == 0);
  CHECK(found.at("light_vertices") == 2 * light_paths);
  // Connections between points of one wall bring nothing; the camera sees 0.64 of one wall of six.
  CHECK(found.at("connection_rays") > 0.5 * paths);
  CHECK(found.at("connection_rays") <= paths);
  CHECK(found.at("splat_rays") > 0);
  CHECK(found.at("splat_rays") < 0.5 * light_paths);
  CHECK(found.at("splats") == found.at("splat_rays"));
  CHECK(found.at("nonfinite") == 0);
  CHECK(found.at("terminated_by_cap") == 0);
  CHECK(found.at("terminated_in_mirrors") == 0);
}

TEST_CASE("counters of rays: no more candidates are counted than there are virtual lights") {
  const double paths = 16 * 16 * 3;
  for (const int light_paths : {2, 5, 8}) {
    const auto found = counters(closed_box(false), small_picture(1, 3),
                                {{"light_paths", std::to_string(light_paths)}, {"camera_edges", "3"}});
    CHECK(found.at("light_vertices") == 3 * 2 * light_paths);
    CHECK(found.at("candidates") == 2 * light_paths * paths);
  }
}

TEST_CASE("counters of rays: behind camera_edges as many paths go on as surfaces reflect, in the end") {
  // By the root of what a path carries, and 0.95 at most, so that paths between white surfaces end.
  const double paths = 16 * 16 * 64;
  for (const double reflectance : {0.5, 1.0}) {
    CAPTURE(reflectance);
    const auto found = counters(closed_box(false, static_cast<float>(reflectance)), small_picture(-1, 64),
                                {{"light_paths", "64"}, {"camera_edges", "1"}, {"adapt", "off"}});
    CHECK(found.at("paths") == paths);
    double rays = 1, squared = 1, share = 1, carried = 1;
    for (int k = 1; k < 1000; ++k) {
      carried *= reflectance;
      const double survival = std::min(0.95, std::sqrt(carried));
      carried /= survival;
      share *= survival;
      rays += share;
      squared += (2 * k + 1) * share;
    }
    const double error = std::sqrt((squared - rays * rays) / paths);
    CHECK(std::abs(found.at("camera_rays") / paths - rays) < 4 * error);
    CHECK(4 * error < 0.04 * rays);
  }
}

TEST_CASE("counters of light paths: what leaves an open scene is missed") {
  const auto found = counters(closed_box(true), small_picture(1, 3), {{"light_paths", "4096"}});
  const double emitted = found.at("light_paths"), rays = found.at("light_path_rays"),
               misses = found.at("light_path_misses");
  // Floor alone: what meets it once does not meet it again.
  CHECK(misses > 0.5 * emitted);
  CHECK(rays - emitted == found.at("light_vertices"));
  CHECK(misses == emitted);
}

TEST_CASE("counters of connections to all: every virtual light has its ray") {
  const auto found = counters(closed_box(false), small_picture(1, 1),
                              {{"light_paths", "8"}, {"light_vertices", "1"}, {"vpl_choice", "all"}});
  CHECK(found.at("connection_rays") > 0.5 * 8 * 16 * 16);
  CHECK(found.at("connection_rays") <= 8 * 16 * 16);
  CHECK(found.count("candidates") == 0);
}

TEST_CASE("counters of light paths: as many as bundles where all are connected, unless light_paths says") {
  for (const char* const choice : {"all", "pair"}) {
    CAPTURE(choice);
    const Parameters common = {{"vpl_choice", choice}, {"bundles", "8"}};
    CHECK(counters(closed_box(false), small_picture(1, 1), common).at("light_paths") == 8);
    Parameters explicitly = common;
    explicitly.emplace_back("light_paths", "9");
    CHECK(counters(closed_box(false), small_picture(1, 1), explicitly).at("light_paths") == 9);
  }
}

TEST_CASE("counters of bundles: the same set at later depths is looked up again, others are rasterized") {
  const Scene scene = closed_box(false);
  const auto count = [&](const char* reuse, const char* bundles, const char* resolution) {
    Picture picture = small_picture(2, 3);
    picture.width = picture.height = 48;
    return counters(scene, picture,
                    {{"directions", "bundle"},
                     {"bundle_mode", "raster"},
                     {"bundle_res", resolution},
                     {"bundles", bundles},
                     {"reuse", reuse},
                     {"camera_edges", "3"}});
  };
  // Three edges of camera paths; 2304 paths take all of 4 bundles at each.
  const auto shared = count("shared", "4", "32"), apart = count("per_depth", "4", "32");
  CHECK(shared.at("bundles") == 3 * 4);
  CHECK(shared.at("bundles_again") == 3 * 4 * 2);
  CHECK(apart.at("bundles") == 3 * 4 * 3);
  CHECK(apart.at("bundles_again") == 0);
  // There is memory for 512 MiB / 36 B / 2048^2 = 3 of them.
  const auto some = count("shared", "4", "2048");
  CHECK(some.at("bundles") == 3 * (4 + 2));
  CHECK(some.at("bundles_again") == 3 * 3 * 2);
}

TEST_CASE("counters of limits: paths caught between mirrors are counted, before and behind the first other surface") {
  SceneMaterial mirror;
  mirror.roughness = 0;
  Scene scene;
  const int mirrors = add_material(scene, mirror);
  add_box(scene, glm::vec3(-0.5f), glm::vec3(0.5f), true, mirrors);
  add_light(scene, LightType::point, 1, {0.1f, 0.1f, -0.2f}, {0, -1, 0});
  scene.cameras = {look_perspective({0.11f, 0.05f, 0.13f}, {-0.23f, -0.3f, -0.5f}, 1)};
  Picture picture = small_picture(-1, 1);
  picture.width = picture.height = 3;
  CHECK(counters(scene, picture, {{"light_paths", "1"}}).at("terminated_in_mirrors") == 9);

  // The camera looks at a patch that is small in the room of mirrors: most paths do not come back to it in time.
  add_horizontal(scene, 0, -0.499f, 0, 0.005f, 0.005f, true, add_material(scene, lambert(0.5f)));
  scene.cameras = {look_orthographic({0, 0, 0}, {0, -0.499f, 0}, 0.002f)};
  const auto found = counters(scene, picture, {{"light_paths", "1"}, {"camera_edges", "64"}});
  CHECK(found.at("terminated_in_mirrors") == 0);
  CHECK(found.at("terminated_by_cap") >= 1);
  CHECK(found.at("terminated_by_cap") <= 9);
}

TEST_CASE("memory of connections to all virtual lights is stated, up to a tenth") {
  const auto held = [] { return static_cast<double>(test_device()->memory().by_owner()["bidirectional_vpl"]); };
  Scene scene = load_scene("builtin:room");
  RenderSettings settings;
  settings.width = settings.height = 128;
  settings.camera = scene.cameras.front();
  for (const std::string visibility : {"rays", "map"}) {
    CAPTURE(visibility);
    const double others = held();
    RenderSession session(test_device(), scene, registry().find("bidirectional_vpl"), settings,
                          {{"vpl_choice", "all"},
                           {"bundles", "1"},
                           {"light_vertices", "1"},
                           {"light_choice", "learned"},
                           {"vpl_visibility", visibility},
                           {"map_res", "32"}});
    session.run({.iterations = 1});
    CHECK(held() - others <= 1.1 * static_cast<double>(session.technique().estimate_bytes(scene, settings)));
  }
}
