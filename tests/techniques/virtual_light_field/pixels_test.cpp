// SPDX-License-Identifier: Apache-2.0
// Pictures of the field beside path_tracing's of the same light paths: bounces, rays of lobes, look-ups alone.
#include <doctest/doctest.h>

#include <string>
#include <utility>
#include <vector>

#include "field_rig.h"
#include "lucarium/scene/builtin/builder.h"
#include "lucarium/scene/load/load_scene.h"
#include "lucarium/session/session.h"
#include "registry.h"
#include "technique_session.h"
#include "test_support.h"
#include "tolerance.h"

using namespace lucarium;
using test::Options;
using test::relative;
using test::with;

namespace {

struct Means {
  double emission = 0, direct = 0, indirect = 0;
};

Means render(const Scene& scene, const std::string& technique, int max_bounces, uint64_t iterations,
             const Options& options = {}, uint64_t seed = 1) {
  RenderSettings settings;
  settings.width = settings.height = 32;
  settings.max_bounces = max_bounces;
  settings.seed = seed;
  settings.camera = scene.cameras.front();
  RenderSession session(test::test_device(), scene, test::registry().find(technique), settings, options);
  session.run({.iterations = iterations});
  const Film film = session.resolve();
  const auto mean = [&](const char* layer) {
    double sum = 0;
    const std::vector<float>& pixels = film.find(layer)->pixels;
    for (const float v : pixels) sum += static_cast<double>(v);
    return sum / static_cast<double>(pixels.size());
  };
  return {mean("emission"), mean("direct"), mean("indirect")};
}

const Options fine = {{"dir_n", "8"}, {"cells", "48"}, {"texels", "4096"}, {"camera_samples", "16"}};

/// A lit box whose back wall scatters by lobes, and its sides too if they are to: what a camera in front sees of it.
Scene lobes(float roughness, bool sides = false) {
  const SceneMaterial grey = test::lambert(0.6f), metal = test::mirror(0.8f, roughness);
  Scene scene = test::unit_box({{0, sides ? metal : grey},
                                {1, sides ? metal : grey},
                                {2, grey},
                                {3, test::emitter(2, 0.4f)},
                                {4, metal},
                                {5, grey}});
  scene.cameras.push_back(look_at_camera("inside", {0.45f, 0.4f, 0.9f}, {0.5f, 0.45f, 0.f}, 60.f));
  return scene;
}

}  // namespace

TEST_CASE("each number of bounces brings path_tracing's light") {
  const Scene scene = load_scene("builtin:cornell");
  const uint64_t samples = test::full_run() ? 4096 : 512;
  for (const int bounces : {0, 1, 2, -1}) {
    CAPTURE(bounces);
    const Means expected = render(scene, "path_tracing", bounces, samples),
                found = render(scene, "virtual_light_field", bounces, 96, fine);
    CHECK(found.direct == relative(expected.direct, 0.02));
    if (bounces == 0)
      CHECK(found.indirect == 0);
    else
      CHECK(found.indirect == relative(expected.indirect, 0.02));
  }
}

TEST_CASE("rays of lobes and look-ups show what path_tracing shows") {
  for (const float roughness : {0.f, 0.5f}) {
    CAPTURE(roughness);
    const Scene scene = lobes(roughness);
    const Means expected = render(scene, "path_tracing", -1, 512);
    const double all = expected.emission + expected.direct + expected.indirect;
    for (const Options& eye : {Options{}, Options{{"eye_glossy", "vlf"}}, Options{{"preset", "walkthrough"}}}) {
      const Means found = render(scene, "virtual_light_field", -1, 160, with(eye, fine));
      CAPTURE(eye.size());
      CAPTURE(found.direct);
      CAPTURE(found.indirect);
      CHECK(found.emission + found.direct + found.indirect == relative(all, 0.03));
      // What a mirror shows of a lamp is indirect light where its tiles are looked up.
      const bool mirrored = roughness == 0 && eye == Options{{"preset", "walkthrough"}};
      if (!mirrored) CHECK(found.indirect == relative(expected.indirect, 0.04));
    }
  }
}

TEST_CASE("rays of lobes show the lobes of what they meet") {
  const Scene scene = lobes(0.5f, true);
  const Means expected = render(scene, "path_tracing", -1, 512),
              found = render(scene, "virtual_light_field", -1, 160, fine);
  const double all = expected.emission + expected.direct + expected.indirect,
               seen = found.emission + found.direct + found.indirect;
  MESSAGE("off by ", seen / all - 1);
  CHECK(seen == relative(all, 0.03));
}

TEST_CASE("a wall half mirror and half diffuse shows its mirror once, however it is looked up") {
  Scene scene = lobes(0);
  for (SceneMaterial& material : scene.materials)
    if (material.metallic > 0) material.metallic = 0.5f;
  const Means expected = render(scene, "path_tracing", -1, 512);
  const double all = expected.emission + expected.direct + expected.indirect;
  for (const Options& eye : {Options{}, Options{{"eye_glossy", "vlf"}}, Options{{"eye_specular", "vlf"}},
                             Options{{"preset", "walkthrough"}}}) {
    CAPTURE(eye.empty() ? "" : eye.front().first);
    CAPTURE(eye.empty() ? "" : eye.front().second);
    const Means found = render(scene, "virtual_light_field", -1, 160, with(eye, fine));
    const double seen = found.emission + found.direct + found.indirect;
    MESSAGE("off by ", seen / all - 1);
    CHECK(seen == relative(all, 0.02));
  }
}

TEST_CASE("rough volumes of index 1 let light straight through, whichever lobes are looked up") {
  Scene scene = lobes(0.5f);
  SceneMaterial mist;  // ideal transmission, but no ideal reflection
  mist.base_color = glm::vec4(0.9f);
  mist.metallic = 0;
  mist.roughness = 0.5f;
  mist.transmission = 0.5f;
  mist.thickness = 1;
  mist.ior = 1;
  add_instance(scene, add_mesh(scene, MeshBuilder("mist").box({0.3f, 0.2f, 0.3f}, {0.7f, 0.6f, 0.5f}).take()),
               test::add_material(scene, mist));
  const Means expected = render(scene, "path_tracing", -1, 256);
  const double all = expected.emission + expected.direct + expected.indirect;
  for (const auto& [specular, glossy] :
       std::vector<std::pair<std::string, std::string>>{{"trace", "vlf"}, {"vlf", "trace"}, {"vlf", "vlf"}}) {
    CAPTURE(specular);
    CAPTURE(glossy);
    const Means found = render(
        scene, "virtual_light_field", -1, 64,
        {{"dir_n", "6"}, {"cells", "32"}, {"texels", "2048"}, {"eye_specular", specular}, {"eye_glossy", glossy}});
    const double seen = found.emission + found.direct + found.indirect;
    MESSAGE(specular, ", ", glossy, ": off by ", seen / all - 1);
    CHECK(seen == relative(all, 0.03));
  }
}

TEST_CASE("coats that keep no tiles are folded into the albedo or left out, as weak_lobes says") {
  Scene scene = lobes(0.5f);
  for (SceneMaterial& material : scene.materials)
    if (material.ior == 1.f) material.ior = 1.5f;  // coats of F0 0.04 on the grey walls
  const Means expected = render(scene, "path_tracing", -1, 512);
  const Means folded = render(scene, "virtual_light_field", -1, 160, fine),
              dropped = render(scene, "virtual_light_field", -1, 160, with(fine, {{"weak_lobes", "drop"}}));
  CHECK(folded.indirect == relative(expected.indirect, 0.03));
  CHECK(dropped.indirect < 0.97 * folded.indirect);
}

TEST_CASE("lamps of any strength fit into the cells") {
  const auto mean = [](float strength) {
    Scene scene = lobes(0);
    for (SceneMaterial& material : scene.materials) material.emissive_strength *= strength;
    return render(scene, "virtual_light_field", 3, 96, fine).indirect;
  };
  const double one = mean(1);
  CHECK(mean(0x1p30f) == relative(one * 0x1p30, 1e-5));
  CHECK(mean(0x1p-30f) == relative(one * 0x1p-30, 1e-5));
}

TEST_CASE("rough metal throws on what point, spot and directional lights send it") {
  const SceneMaterial dark = test::lambert(0.1f);
  for (const LightType type : {LightType::point, LightType::spot, LightType::directional}) {
    CAPTURE(static_cast<int>(type));
    Scene scene = test::unit_box(
        {{0, dark}, {1, dark}, {2, test::mirror(0.9f, 0.6f)}, {3, dark}, {4, test::mirror(0.9f, 0.45f)}});
    SceneLight light;
    light.intensity = glm::vec3(0);  // dark lights have no place among those that shine
    scene.lights.push_back(light);
    light.type = type;
    light.intensity = glm::vec3(1);
    light.outer_angle = 0.9f;
    light.world_from_light = frame_along({0.5f, 0.8f, 0.6f}, {0.1f, -0.6f, -0.8f});
    if (type == LightType::spot) {  // two: each shines at metal of its own, the darker one stands first
      light.outer_angle = 0.6f;
      light.intensity = glm::vec3(0.6f);
      light.world_from_light = frame_along({0.5f, 0.8f, 0.6f}, {0.f, -1.f, 0.f});
      scene.lights.push_back(light);
      light.intensity = glm::vec3(1);
      light.world_from_light = frame_along({0.5f, 0.6f, 0.8f}, {0.f, 0.f, -1.f});
    }
    scene.lights.push_back(light);
    scene.cameras.push_back(look_at_camera("inside", {0.5f, 0.5f, 0.9f}, {0.1f, 0.6f, 0.f}, 70.f));
    const Means expected = render(scene, "path_tracing", 2, 2048);
    // A lobe lit from one direction is sampled by the directions of the grid, 0.22 rad apart, and interpolated between
    // them up to the horizon: right to a few per cent, on average over rotations.
    Means found;
    constexpr int seeds = 4;
    for (uint64_t seed = 1; seed <= seeds; ++seed) {
      const Means one = render(scene, "virtual_light_field", 2, 64, fine, seed);
      found.direct += one.direct / seeds;
      found.indirect += one.indirect / seeds;
    }
    MESSAGE("direct " << found.direct / expected.direct << ", indirect " << found.indirect / expected.indirect);
    CHECK(found.direct == relative(expected.direct, 0.02));
    CHECK(found.indirect == relative(expected.indirect, 0.05));
  }
}

TEST_CASE("the picture of a line shows a mirror under the sky from its front only") {
  Scene scene;
  test::add_polygon(scene, {{0, 0, 0}, {0, 0, 1}, {1, 0, 1}, {1, 0, 0}}, test::add_material(scene, test::mirror()));
  Environment sky;
  sky.width = sky.height = 4;
  sky.radiance.assign(16, glm::vec3(1));
  scene.environment = sky;
  scene.cameras.push_back(look_at_camera("above", {0.5f, 2.f, 0.5f}, {0.5f, 0.f, 0.51f}, 40.f));
  int fronts = 0, others = 0;
  for (int line = 0; line < 9; ++line) {
    RenderSettings settings;
    settings.width = settings.height = 24;
    settings.camera = scene.cameras.front();
    RenderSession session(test::test_device(), scene, test::registry().find("virtual_light_field"), settings,
                          {{"dir_n", "2"}, {"cells", "32"}, {"texels", "512"}, {"inspect_line", std::to_string(line)}});
    session.run({.iterations = 24});
    double sum = 0;
    const Film film = session.resolve();
    for (const float v : film.find("subfield")->pixels) {
      CHECK((v == 0 || (v > 0.99f && v < 1.01f)));
      sum += static_cast<double>(v);
    }
    (sum > 0 ? fronts : others) += 1;
  }
  CHECK(fronts >= 2);
  CHECK(others >= 2);
}
