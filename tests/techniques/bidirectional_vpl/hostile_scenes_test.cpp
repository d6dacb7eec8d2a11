// SPDX-License-Identifier: Apache-2.0
// Scenes in which light paths keep nothing, or have extreme sizes and intensities: right or black, never NaN; and
// parameters that do not go together.
#include <glm/gtc/matrix_transform.hpp>

#include "bidirectional_rig.h"
#include "lucarium/base/error.h"
#include "made_scene.h"
#include "tolerance.h"

using namespace lucarium;
using namespace lucarium::test;

namespace {

/// A floor of albedo 0.5 below the camera.
Scene floor_scene() {
  Scene scene;
  add_horizontal(scene, 0, 0, 0, 2, 2, true, add_material(scene, lambert(0.5f)));
  scene.cameras = {look_orthographic({0, 0.8f, 0}, {0, 0, 0}, 0.5f)};
  return scene;
}

Picture small_picture() {
  Picture picture;
  picture.width = picture.height = 8;
  picture.max_bounces = 3;
  picture.iterations = 4;
  return picture;
}

const std::vector<Parameters>& variants() {
  static const std::vector<Parameters> all = {
      {}, {{"preset", "bdpt"}}, {{"vpl_choice", "all"}}, {{"vpl_choice", "pair"}, {"directions", "bundle"}}};
  return all;
}

/// All values are finite and not negative, by all kinds of connections. Returns the largest.
double largest(const Scene& scene) {
  double most = 0;
  for (const Parameters& parameters : variants())
    for (const float value : image_of(render(scene, "bidirectional_vpl", small_picture(), parameters))) {
      CHECK(std::isfinite(value));
      CHECK(value >= 0);
      most = std::max(most, static_cast<double>(value));
    }
  return most;
}

}  // namespace

TEST_CASE("scenes without a virtual light are as bright as their direct light, or black") {
  SUBCASE("all light leaves the scene") {
    Scene scene = floor_scene();
    add_light(scene, LightType::spot, 1, {0, 0.5f, 0}, {0, 1, 0});
    CHECK(largest(scene) == 0);
  }
  SUBCASE("a lamp inside a black solid") {
    Scene scene = floor_scene();
    add_box(scene, {-.1f, .2f, -.1f}, {.1f, .4f, .1f}, true, add_material(scene, lambert(0)));
    add_light(scene, LightType::point, 1, {0, 0.3f, 0}, {0, 1, 0});
    // The box faces inwards: from outside, its walls are backs, which are black and let nothing through.
    CHECK(largest(scene) == 0);
  }
  SUBCASE("black surfaces") {
    Scene scene;
    add_box(scene, glm::vec3(-1), glm::vec3(1), true, add_material(scene, lambert(0)));
    add_light(scene, LightType::point, 1, {0, 0.3f, 0}, {0, 1, 0});
    scene.cameras = floor_scene().cameras;
    CHECK(largest(scene) == 0);
  }
  SUBCASE("no light") { CHECK(largest(floor_scene()) == 0); }
  SUBCASE("light of intensity 0") {
    Scene scene = floor_scene();
    add_light(scene, LightType::point, 0, {0, 0.5f, 0}, {0, 0, 0});
    CHECK(largest(scene) == 0);
  }
  SUBCASE("no surface at all") {
    Scene scene;
    scene.cameras = floor_scene().cameras;
    set_environment(scene, 2);
    CHECK(largest(scene) == relative(2, 1e-5));
  }
}

TEST_CASE("lights in a surface, triangles without area and coverage everywhere bring finite light") {
  SUBCASE("a point light in the floor, and one at a corner") {
    Scene scene = floor_scene();
    add_light(scene, LightType::point, 1, {0, 0, 0}, {0, 1, 0});
    add_light(scene, LightType::point, 1, {1, 0, 1}, {0, 1, 0});
    largest(scene);
  }
  SUBCASE("triangles without area, some of which shine") {
    Scene scene = floor_scene();
    add_threads(scene, 6, 0, add_material(scene, emitter(5)));
    add_threads(scene, 6, 0, add_material(scene, lambert(0.5f)));
    add_light(scene, LightType::point, 1, {0, 0.5f, 0}, {0, 0, 0});
    CHECK(largest(scene) > 0);
  }
  SUBCASE("BLEND everywhere, down to nothing") {
    Scene scene;
    SceneMaterial veil = lambert(0.5f);
    veil.alpha_mode = AlphaMode::blend;
    veil.base_color.a = 0.3f;
    SceneMaterial nothing = veil;
    nothing.base_color.a = 0;
    add_box(scene, glm::vec3(-1), glm::vec3(1), true, add_material(scene, veil));
    add_box(scene, glm::vec3(-0.9f), glm::vec3(0.9f), true, add_material(scene, nothing));
    add_light(scene, LightType::point, 1, {0, 0.3f, 0}, {0, 1, 0});
    scene.cameras = floor_scene().cameras;
    CHECK(largest(scene) > 0);
  }
}

TEST_CASE("light paths and light samples see the same from lights that lie in a ceiling, in a pane and at a corner") {
  const glm::vec3 places[] = {{0.1f, 1, 0.2f}, {0.05f, -0.5f, 0}, {1, 1, -1}};
  // Upright, and turned so that no plane is exact; with a lamp at the origin, and far from there.
  for (const float angle : {0.f, 1.7f}) {
    for (const glm::vec3& middle : {glm::vec3(0), -places[0], glm::vec3(-100, 200, -300)}) {
      CAPTURE(angle);
      CAPTURE(middle.x);
      Scene scene;
      add_box(scene, glm::vec3(-1), glm::vec3(1), true, add_material(scene, lambert(0.5f)));
      SceneMaterial pane = lambert(0.5f);
      pane.double_sided = true;
      add_horizontal(scene, 0, -0.5f, 0, 0.6f, 0.6f, true, add_material(scene, pane));
      const glm::mat4 turn = glm::rotate(glm::mat4(1), angle, glm::normalize(glm::vec3(1, 2, 3)));
      const auto moved = [&](const glm::vec3& place) { return glm::vec3(turn * glm::vec4(middle + place, 1)); };
      for (Mesh& mesh : scene.meshes) {
        for (glm::vec3& position : mesh.positions) position = moved(position);
        for (glm::vec3& normal : mesh.normals) normal = glm::vec3(turn * glm::vec4(normal, 0));
      }
      for (const glm::vec3& place : places) {
        add_light(scene, LightType::point, 1, {0, 0, 0}, {0, 0, 1});
        scene.lights.back().world_from_light[3] = glm::vec4(moved(place), 1);
      }
      scene.cameras = {look_perspective(moved({0, 0, 0}), moved({0.3f, -0.2f, -1}), 1.5f)};
      Picture picture = small_picture();
      picture.iterations = 512;
      const double expected = mean_of(image_of(render(scene, "path_tracing", picture)));
      CHECK(expected == relative(0.245, 0.02));  // wherever it stands
      picture.iterations = 64;
      for (const Parameters& parameters : variants()) {
        CAPTURE(parameters.size());
        const std::vector<float> image = image_of(render(scene, "bidirectional_vpl", picture, parameters));
        CHECK(mean_of(image) == relative(expected, 0.03));
      }
    }
  }
}

TEST_CASE("scenes of 10^6 m and of huge intensities scale, and do not overflow") {
  // A scene that is s times as large has 1 / s^2 of the irradiance of a point light.
  const auto mean = [](float metres, float intensity) {
    Scene scene;
    add_box(scene, glm::vec3(-metres), glm::vec3(metres), true, add_material(scene, lambert(0.5f)));
    add_light(scene, LightType::point, intensity, {0, 0.3f * metres, 0}, {0, -metres, 0});
    scene.cameras = {look_orthographic({0, 0, 0}, {0, -metres, 0}, 0.5f * metres)};
    Picture picture = small_picture();
    picture.iterations = 32;
    return mean_of(image_of(render(scene, "bidirectional_vpl", picture)));
  };
  const double expected = mean(1, 1);
  CHECK(mean(1e6f, 1e12f) == relative(expected, 0.03));
  CHECK(mean(1, 1e25f) == relative(1e25 * expected, 0.03));
}

TEST_CASE("combinations of parameters that find nothing, or do not fit, are refused") {
  const Scene scene = load_scene("builtin:cornell");
  DeviceOptions little;  // whatever the machine has free
  little.memory_limit_bytes = size_t{1} << 30;
  const std::shared_ptr<Device> device = Device::open(little);
  const auto refused = [&](Picture picture, const Parameters& parameters) {
    try {
      render(scene, "bidirectional_vpl", picture, parameters, device);
    } catch (const Error& error) {
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  Picture picture = small_picture();
  picture.max_bounces = 0;
  CHECK(refused(picture, {{"strategy", "vpl"}}).find("--max-bounces") != std::string::npos);
  picture.max_bounces = 3;
  CHECK(refused(picture, {{"strategy", "splat"}, {"light_vertices", "1"}}).find("light_vertices") != std::string::npos);
  picture.pixel_sampling = LUCARIUM_PIXEL_CENTRE;
  CHECK(refused(picture, {{"strategy", "splat"}}).find("--pixel-sampling") != std::string::npos);
  picture.pixel_sampling = LUCARIUM_PIXEL_JITTER;
  CHECK(refused(picture, {{"light_paths", "4194304"}, {"light_vertices", "16"}, {"show_strategies", "on"}})
            .find("light_paths") != std::string::npos);
}

namespace {

/// Whether the technique says so of the scene.
bool says(const Scene& scene, const std::string& line, const Parameters& parameters, int max_bounces = 3) {
  const auto technique = registry().find("bidirectional_vpl").create();
  for (const auto& [name, value] : parameters) technique->parameters().set(name, value);
  RenderSettings settings;
  settings.max_bounces = max_bounces;
  const std::vector<std::string> lines = technique->limitations(scene, settings);
  return std::any_of(lines.begin(), lines.end(), [&](const std::string& one) { return one.find(line) == 0; });
}

}  // namespace

TEST_CASE("what strategy=hit cannot find in a scene is said") {
  Scene scene = floor_scene();
  add_light(scene, LightType::point, 1, {0, 0.6f, 0}, {0, 0, 0});
  const char* const nothing = "strategy=hit finds nothing";
  CHECK(says(scene, nothing, {{"strategy", "hit"}}));
  CHECK_FALSE(says(scene, nothing, {{"strategy", "nee"}}));
  CHECK_FALSE(says(load_scene("builtin:cornell"), nothing, {{"strategy", "hit"}}));
  set_environment(scene, 1);
  CHECK_FALSE(says(scene, nothing, {{"strategy", "hit"}}));
}

TEST_CASE("parameters that others leave without effect are named, and none where they have one") {
  Scene room = load_scene("builtin:room");
  set_environment(room, 1);
  const struct {
    std::string name, value;
    Parameters idle, used;  // without effect beside the first, with effect beside the second
  } rows[] = {
      {"splat", "off", {{"strategy", "splat"}}, {}},
      {"light_vertices", "8", {{"strategy", "nee"}}, {{"strategy", "splat"}}},
      {"vpl_choice", "pair", {{"strategy", "hit"}}, {{"strategy", "splat"}}},
      {"vpl_lights", "punctual", {{"strategy", "nee"}}, {}},
      {"candidates", "8", {{"vpl_choice", "all"}}, {}},
      {"candidates", "8", {{"strategy", "hit"}}, {{"strategy", "vpl"}}},
      {"bundles", "8", {}, {{"vpl_choice", "pair"}}},
      {"bundles", "8", {{"vpl_choice", "own"}}, {{"directions", "both"}}},
      {"bundles", "8", {{"vpl_choice", "all"}, {"strategy", "hit"}}, {{"vpl_choice", "all"}, {"strategy", "vpl"}}},
      {"bundles", "8", {{"vpl_choice", "pair"}, {"light_paths", "9"}}, {{"light_paths", "9"}, {"directions", "both"}}},
      {"dir_pdf", "env", {}, {{"directions", "bundle"}}},
      {"bundle_sides", "one", {}, {{"directions", "bundle"}}},
      {"reuse", "shared", {}, {{"directions", "bundle"}}},
      {"bundle_mode", "raster", {}, {{"directions", "bundle"}}},
      {"bundle_res", "64", {{"directions", "bundle"}}, {{"directions", "bundle"}, {"bundle_mode", "exact"}}},
      {"map_res", "64", {}, {{"vpl_visibility", "map"}}},
      {"g_max", "2", {}, {{"two_bounce", "clamp"}}},
      {"reuse", "shared", {{"directions", "both"}}, {{"directions", "bundle"}}},
      {"m_prime", "8", {}, {{"gloss", "clamp"}}},
      {"m_prime", "8", {{"gloss", "vsl"}}, {{"gloss", "roughness"}}},
      {"gloss", "vsl", {{"strategy", "hit"}}, {}},
      {"interleave", "4", {{"strategy", "hit"}}, {}},
      {"interleave", "4", {{"vpl_choice", "own"}}, {{"vpl_choice", "own"}, {"filter", "on"}}},
      {"two_bounce", "clamp", {{"strategy", "nee"}}, {}},
      {"direct", "maps", {{"strategy", "vpl"}}, {{"strategy", "nee"}}},
      {"light_choice", "learned", {{"strategy", "hit"}}, {{"strategy", "splat"}}},
      {"light_trace", "rsm", {{"strategy", "nee"}}, {}},
      {"vpl_visibility", "map", {{"strategy", "splat"}}, {}},
      {"filter", "on", {}, {{"interleave", "2"}}},
      {"light_paths", "50", {{"vpl_choice", "own"}}, {}},
      {"light_paths", "50", {{"strategy", "nee"}}, {}},
  };
  for (const auto& row : rows) {
    CAPTURE(row.name);
    const auto with = [&](Parameters parameters) {
      parameters.emplace_back(row.name, row.value);
      return says(room, row.name + " has no effect", parameters) ||
             says(room, row.name + "=" + row.value + " has no effect", parameters);
    };
    CHECK(with(row.idle));
    CHECK_FALSE(with(row.used));
  }
}

TEST_CASE("what bundles, caches and skies do not do is said") {
  Scene room = load_scene("builtin:room");
  const char* const biased = "reuse=shared is biased";
  CHECK(says(room, biased, {{"directions", "bundle"}, {"reuse", "shared"}}, 1));  // the second one behind the first
  CHECK_FALSE(says(room, biased, {{"directions", "bundle"}, {"reuse", "shared"}}, 0));
  CHECK_FALSE(says(room, biased, {{"directions", "both"}, {"reuse", "shared"}}));
  const char* const no_reuse = "reuse has no effect";
  CHECK(says(room, no_reuse, {{"directions", "bundle"}, {"reuse", "shared"}}, 0));
  CHECK_FALSE(says(room, no_reuse, {{"directions", "bundle"}, {"reuse", "shared"}}, 1));
  CHECK(says(room, "caches=on leaves", {{"caches", "on"}, {"show_strategies", "on"}}));
  const char* const no_sky = "dir_pdf=env has no effect";
  CHECK(says(room, no_sky, {{"directions", "bundle"}, {"dir_pdf", "env"}}));
  set_environment(room, 1);
  CHECK_FALSE(says(room, no_sky, {{"directions", "bundle"}, {"dir_pdf", "env"}}));
}

TEST_CASE("reuse changes no bit where paths take one bundle") {
  const Scene room = load_scene("builtin:room");
  Picture picture = small_picture();
  const auto image = [&](const char* directions, const char* reuse) {
    return image_of(render(room, "bidirectional_vpl", picture, {{"directions", directions}, {"reuse", reuse}}));
  };
  const auto same = [&](const char* directions, const char* reuse) {
    return image(directions, reuse) == image(directions, "per_depth");
  };
  for (const char* const reuse : {"distinct", "shared"}) {
    CAPTURE(reuse);
    picture.max_bounces = 1;
    CHECK(same("both", reuse));
    CHECK_FALSE(same("bundle", reuse));
    picture.max_bounces = 0;
    CHECK(same("bundle", reuse));
  }
}

TEST_CASE("punctual light behind glass is named as left out where the glass is clear, not where it is rough") {
  const auto limitations = [](float roughness) {
    Scene scene = floor_scene();
    SceneMaterial glass;
    glass.metallic = 0;
    glass.transmission = 1;
    glass.roughness = roughness;
    add_box(scene, {-.1f, .2f, -.1f}, {.1f, .4f, .1f}, false, add_material(scene, glass));
    add_light(scene, LightType::point, 1, {0, 0.6f, 0}, {0, 0, 0});
    const auto technique = registry().find("bidirectional_vpl").create();
    return technique->limitations(scene, RenderSettings()).size();
  };
  CHECK(limitations(0) == 1);
  CHECK(limitations(0.3f) == 0);
}
