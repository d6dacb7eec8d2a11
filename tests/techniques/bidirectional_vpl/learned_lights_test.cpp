// SPDX-License-Identifier: Apache-2.0
// light_choice=learned: light paths leave lights alone that bring nothing, and nothing else changes.
#include "bidirectional_rig.h"
#include "made_scene.h"

using namespace lucarium;
using namespace lucarium::test;

namespace {

/// A room with a lamp, and beside it a closed chamber whose lights have many times the lamp's power.
Scene hidden_lights(int count, float lamp_side = 0.3f) {
  Scene scene;
  const int walls = add_material(scene, lambert(0.6f));
  add_box(scene, glm::vec3(-0.5f), glm::vec3(0.5f), true, walls);
  add_horizontal(scene, 0, 0.45f, 0, lamp_side, lamp_side, false,
                 add_material(scene, emitter(0.5f / (lamp_side * lamp_side))));
  add_box(scene, {2, -0.5f, -0.5f}, {3, 0.5f, 0.5f}, true, walls);
  for (int i = 0; i < count; ++i)
    add_light(scene, LightType::point, 0.6f, {2.2f + 0.07f * static_cast<float>(i), 0, 0}, {3, 0, 0.1f});
  scene.cameras = {look_perspective({-0.3f, 0.1f, 0.45f}, {0.1f, -0.2f, -0.3f}, 1.2f)};
  return scene;
}

Picture learned_picture(uint64_t iterations) {
  Picture picture;
  picture.max_bounces = 2;
  picture.iterations = iterations;
  return picture;
}

/// Sum over all pixels of what pictures of different seeds differ by from their mean. Not of squares, which the few
/// connections in corners decide, whatever the lights.
double spread(const std::vector<std::vector<float>>& images) {
  double sum = 0;
  for (size_t i = 0; i < images.front().size(); ++i) {
    double mean = 0;
    for (const std::vector<float>& image : images)
      mean += static_cast<double>(image[i]) / static_cast<double>(images.size());
    for (const std::vector<float>& image : images) sum += std::abs(static_cast<double>(image[i]) - mean);
  }
  return sum;
}

}  // namespace

TEST_CASE("learned lights: pictures agree with path tracing where most lights are hidden") {
  const Scene scene = hidden_lights(8);
  const Picture picture = learned_picture(full_run() ? 256 : 12);
  check_agreement("learned", scene, picture, {{"light_choice", "learned"}}, {}, kSeeds);
  // Weights of hits matter most where the lamp is large and splats are many.
  check_agreement("learned, many splats", hidden_lights(2, 0.9f), picture,
                  {{"light_choice", "learned"}, {"light_paths", "8192"}, {"candidates", "4"}}, {}, 2 * kSeeds);
}

TEST_CASE("learned lights: virtual lights and splats alone have less noise than by power, and the same mean") {
  const Scene scene = hidden_lights(8);
  for (const char* const strategy : {"vpl", "splat"}) {
    CAPTURE(strategy);
    const auto images = [&](const char* choice) {
      return pictures(scene, "bidirectional_vpl", learned_picture(full_run() ? 256 : 24),
                      {{"strategy", strategy}, {"light_choice", choice}}, kSeeds);
    };
    const auto learned = images("learned"), power = images("power");
    MESSAGE(std::string(strategy) << ": " << spread(learned) / spread(power) << " of the noise");
    CHECK(spread(learned) < 0.7 * spread(power));
    std::vector<double> ours, expected;
    for (const std::vector<float>& image : learned) ours.push_back(mean_of(image));
    for (const std::vector<float>& image : power) expected.push_back(mean_of(image));
    const Estimate a = estimate_of(ours), b = estimate_of(expected);
    INFO(a.mean, " +- ", a.error, ", by power ", b.mean, " +- ", b.error);
    CHECK(std::abs(a.mean - b.mean) <= 5 * std::hypot(a.error, b.error));
  }
}

TEST_CASE(
    "learned lights: the same seed gives the same bits, all kinds of connections learn, and one light is no loss") {
  const Scene scene = hidden_lights(3);
  for (const char* const choice : {"resample", "all", "own", "pair"}) {
    CAPTURE(choice);
    const Parameters parameters = {{"light_choice", "learned"}, {"vpl_choice", choice}};
    const std::vector<float> once = image_of(render(scene, "bidirectional_vpl", learned_picture(3), parameters));
    CHECK(once == image_of(render(scene, "bidirectional_vpl", learned_picture(3), parameters)));
    CHECK(once != image_of(render(scene, "bidirectional_vpl", learned_picture(3), {{"vpl_choice", choice}})));
  }
  Scene dark = hidden_lights(0);
  dark.materials.back().emissive_factor = glm::vec3(0);
  dark.materials[1].emissive_factor = glm::vec3(0);
  CHECK(mean_of(image_of(render(dark, "bidirectional_vpl", learned_picture(2), {{"light_choice", "learned"}}))) == 0);
}

TEST_CASE("learned lights: an iteration that is cancelled teaches nothing") {
  const Scene scene = hidden_lights(3);
  const auto image = [&](int requests_before) {
    RenderSettings settings;
    settings.width = settings.height = 16;
    settings.max_bounces = 2;
    settings.pixel_sampling = LUCARIUM_PIXEL_JITTER;
    settings.camera = scene.cameras.front();
    RenderSession session(test_device(), scene, registry().find("bidirectional_vpl"), settings,
                          {{"light_choice", "learned"}});
    session.run({.iterations = 2});
    if (requests_before > 0) {
      int requests = 0;
      session.scheduler().set_cancel([&] { return requests++ >= requests_before; });
      session.iterate();
      CHECK(session.last().samples == 2);
      session.scheduler().set_cancel([] { return false; });
    }
    session.run({.iterations = 2});
    CHECK(session.last().samples == 4);
    return image_of(session.resolve());
  };
  const std::vector<float> undisturbed = image(0);
  for (const int requests : {5, 20, 35}) CHECK(image(requests) == undisturbed);
}
