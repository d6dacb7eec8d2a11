// SPDX-License-Identifier: Apache-2.0
// Maps in place of rays: shadow maps of virtual lights and of lights, reflective shadow maps. Pictures of one seed take
// the same paths, so that they differ only by what maps show of them.
#include "bidirectional_rig.h"
#include "made_scene.h"
#include "tolerance.h"

using namespace lucarium;
using namespace lucarium::test;

namespace {

/// Blocks on a floor before a wall, with a point light above.
Scene blocks() {
  Scene scene;
  const int grey = add_material(scene, lambert(0.6f));
  add_horizontal(scene, 0, 0, 0, 1.5f, 1.5f, true, grey);
  for (int i = -1; i <= 1; ++i)
    for (int j = -1; j <= 1; ++j) {
      const glm::vec3 corner(0.6f * static_cast<float>(i) - 0.15f, 0, 0.6f * static_cast<float>(j) - 0.15f);
      add_box(scene, corner, corner + glm::vec3(0.3f, 0.3f + 0.1f * static_cast<float>(i + j), 0.3f), false, grey);
    }
  add_box(scene, {-1.5f, 0, -1.6f}, {1.5f, 1.2f, -1.5f}, false, grey);
  add_light(scene, LightType::point, 5, {0.3f, 1.5f, 0.35f}, {0, -1, 0});
  scene.cameras = {look_perspective({0.7f, 1.8f, 1.6f}, {0, 0, -0.2f}, 0.9f)};
  return scene;
}

Picture few() {
  Picture picture;
  picture.width = picture.height = 24;
  picture.max_bounces = 2;
  picture.iterations = full_run() ? 64 : 4;
  return picture;
}

Film with(const Scene& scene, const Picture& picture, Parameters parameters) {
  parameters.insert(parameters.begin(), {{"vpl_choice", "pair"}, {"light_vertices", "1"}, {"bundles", "16"}});
  return render(scene, "bidirectional_vpl", picture, parameters);
}

/// Relative difference of a layer's mean to that by rays, and how much pixels differ.
struct Difference {
  Estimate bias;
  double pixels = 0;  ///< mean of absolute differences over the mean
};

Difference difference(const Scene& scene, const std::string& layer, const Parameters& parameters) {
  std::vector<double> relative;
  Difference result;
  for (uint32_t i = 0; i < kSeeds; ++i) {
    Picture picture = few();
    picture.seed = 20 + i;
    const Film a = with(scene, picture, parameters), b = with(scene, picture, {});
    const std::vector<float>&x = a.find(layer)->pixels, &y = b.find(layer)->pixels;
    relative.push_back(mean_of(x) / mean_of(y) - 1);
    std::vector<float> apart(x.size());
    for (size_t p = 0; p < x.size(); ++p) apart[p] = std::abs(x[p] - y[p]);
    result.pixels += mean_of(apart) / mean_of(y) / kSeeds;
  }
  result.bias = estimate_of(relative);
  MESSAGE(layer << (parameters.empty() ? "" : " by " + parameters.front().first + "=" + parameters.front().second)
                << (parameters.size() > 1 ? ", " + parameters.back().second : "") << ": " << result.bias.mean << " +- "
                << result.bias.error << ", pixels " << result.pixels);
  return result;
}

}  // namespace

TEST_CASE("shadow maps of virtual lights: coarse ones are wrong at edges, fine ones show what rays show") {
  const Scene scene = blocks();
  const auto at = [&](const char* side) {
    return difference(scene, "indirect", {{"vpl_visibility", "map"}, {"map_res", side}});
  };
  const Difference coarse = at("32"), fine = at("256");
  CHECK(coarse.pixels > 4 * fine.pixels);
  CHECK(std::abs(coarse.bias.mean) < 4 * coarse.bias.error + 5e-3);
  CHECK(std::abs(fine.bias.mean) < 4 * fine.bias.error + 1e-3);
}

TEST_CASE("shadow maps of virtual lights: neighbours on a wall do not hide points of it") {
  // Nothing hides anything in a sphere. With all virtual lights, eight look-ups go to the map of one.
  const Scene scene = sphere_room(0.6f, {0.5f, 0.3f, -0.2f});
  const auto light = [&](const char* choice, const Parameters& more) {
    Parameters parameters = {{"vpl_choice", choice}};
    parameters.insert(parameters.end(), more.begin(), more.end());
    return mean_of(with(scene, few(), parameters).find("indirect")->pixels);
  };
  for (const char* const choice : {"all", "pair"}) {
    const double rays = light(choice, {});
    const auto lost = [&](const char* side) {
      return 1 - light(choice, {{"vpl_visibility", "map"}, {"map_res", side}}) / rays;
    };
    // Where rays graze the sphere, a texel sees what is nearer: the less, the smaller it is.
    const double coarse = lost("64"), fine = lost("256");
    MESSAGE(std::string(choice), ": ", coarse, ", ", fine);
    CHECK(std::abs(coarse) < 0.01);
    CHECK(std::abs(fine) < 0.5 * std::abs(coarse));
  }
}

TEST_CASE("shadow maps of virtual lights: light leaks below what is nearer than texels are wide, and not with more") {
  // A plate a centimetre above a floor in a grey box, and the middle of the floor below it.
  Scene scene;
  const int grey = add_material(scene, lambert(0.6f));
  add_box(scene, {-1, 0, -1}, {1, 1.5f, 1}, true, grey);
  add_box(scene, {-0.4f, 0.01f, -0.4f}, {0.4f, 0.02f, 0.4f}, false, grey);
  add_light(scene, LightType::point, 5, {0.3f, 1.2f, 0.2f}, {0, -1, 0});
  const auto brightness = [&](const Parameters& parameters, bool below) {
    scene.cameras = {below ? look_orthographic({0, 0.005f, 0}, {0, 0, 0}, 0.1f)
                           : look_orthographic({0.7f, 0.1f, 0}, {0.7f, 0, 0}, 0.1f)};
    return mean_of(with(scene, few(), parameters).find("indirect")->pixels);
  };
  const Parameters coarse = {{"vpl_visibility", "map"}, {"map_res", "32"}},
                   fine = {{"vpl_visibility", "map"}, {"map_res", "1024"}};
  const double beside = brightness({}, false);
  CHECK(brightness({}, true) < 1e-2 * beside);
  CHECK(brightness(coarse, true) > 0.2 * beside);
  CHECK(brightness(fine, true) < 1e-2 * beside);
}

TEST_CASE("reflective shadow maps find what rays of light paths find") {
  const Difference found = difference(blocks(), "indirect", {{"light_trace", "rsm"}});
  CHECK(std::abs(found.bias.mean) < 4 * found.bias.error + 1e-3);
  CHECK(found.pixels < 0.02);
}

TEST_CASE("shadow maps of lights: shadows are those of rays, soft over some texels") {
  const Difference found = difference(blocks(), "direct", {{"direct", "maps"}});
  CHECK(std::abs(found.bias.mean) < 4 * found.bias.error + 1e-3);
  CHECK(found.pixels < 0.01);
  CHECK(found.pixels > 0);  // they are maps
}

TEST_CASE("maps answer what rays would, and the counters say so") {
  RenderSettings settings;
  settings.width = settings.height = 16;
  settings.max_bounces = 2;
  const Scene scene = blocks();
  settings.camera = scene.cameras.front();
  const auto counters = [&](const Parameters& more) {
    Parameters parameters = {{"vpl_choice", "pair"}, {"light_vertices", "1"}, {"bundles", "8"}};
    parameters.insert(parameters.end(), more.begin(), more.end());
    RenderSession session(test_device(), scene, registry().find("bidirectional_vpl"), settings, parameters);
    session.run({.iterations = 2});
    return session.technique().counters();
  };
  auto rays = counters({}), maps = counters({{"vpl_visibility", "map"}, {"direct", "maps"}, {"light_trace", "rsm"}});
  CHECK(rays.count("map_look_ups") == 0);
  CHECK(maps["light_path_rays"] == 0);
  CHECK(maps["light_sample_rays"] == 0);
  CHECK(maps["connection_rays"] < 0.01 * rays["connection_rays"]);
  const double answered = maps["map_look_ups"] + maps["connection_rays"],
               traced = rays["connection_rays"] + rays["light_sample_rays"];
  CHECK(answered == test::relative(traced, 0.02));
  CHECK(maps["map_faces"] == 2 * 6 * 2 + 5 * maps["light_vertices"]);
}

TEST_CASE("maps of virtual lights show the same where they answer all connections and where some are traced") {
  // Glass within a block, which no light reaches: rays may be left then.
  const Scene opaque = blocks();
  Scene glass = opaque;
  SceneMaterial clear;
  clear.transmission = 1;
  add_box(glass, {-0.05f, 0.05f, -0.05f}, {0.05f, 0.1f, 0.05f}, false, add_material(glass, clear));
  const auto indirect = [](const Scene& scene, const char* choice) {
    const Parameters parameters = {{"vpl_choice", choice},
                                   {"light_vertices", "2"},
                                   {"bundles", "9"},
                                   {"vpl_visibility", "map"},
                                   {"map_res", "64"}};
    return render(scene, "bidirectional_vpl", few(), parameters).find("indirect")->pixels;
  };
  for (const char* choice : {"all", "pair"}) {
    CAPTURE(choice);
    const std::vector<float> alone = indirect(opaque, choice);
    CHECK(mean_of(alone) > 0);
    CHECK(alone == indirect(glass, choice));
  }
}

TEST_CASE("shadow maps of virtual lights: of connections to all of them") {
  const Scene scene = blocks();
  const auto indirect = [&](const char* visibility) {
    const Parameters parameters = {
        {"vpl_choice", "all"}, {"light_vertices", "2"}, {"bundles", "9"}, {"vpl_visibility", visibility}};
    return render(scene, "bidirectional_vpl", few(), parameters).find("indirect")->pixels;
  };
  const std::vector<float> maps = indirect("map"), rays = indirect("rays");
  double apart = 0;
  for (size_t i = 0; i < maps.size(); ++i) apart += std::abs(maps[i] - rays[i]) / static_cast<double>(maps.size());
  CHECK(apart < 0.02 * mean_of(rays));
  CHECK(apart > 0);  // they are maps
}

TEST_CASE("vpl_lights=punctual leaves lamps to camera paths, clamped or not") {
  const Scene lamp = load_scene("builtin:cornell");
  Picture picture;
  picture.max_bounces = 3;
  for (const char* mode : {"mis", "clamp"})
    check_agreement(mode, lamp, picture, {{"vpl_lights", "punctual"}, {"two_bounce", mode}}, {}, kSeeds);
  Scene both = lamp;
  add_light(both, LightType::point, 0.5f, {0.2f, 0.4f, 0.3f}, {0, -1, 0});
  check_agreement("lamp and point light", both, picture, {{"vpl_lights", "punctual"}}, {}, kSeeds);
}
