// SPDX-License-Identifier: Apache-2.0
// adapt: what costs more than it brings is left out, and the image's mean and bits depend on nothing else.
#include "bidirectional_rig.h"
#include "bidirectional_vpl/effort/efficiency.h"
#include "bidirectional_vpl/effort/trials.h"
#include "made_scene.h"

const lucarium::EmbeddedSources& bidirectional_vpl_kernels();

using namespace lucarium;
using namespace lucarium::test;
using bidirectional::relative_variance;
using bidirectional::TrialImage;

namespace {

RenderSettings settings_of(const Scene& scene) {
  RenderSettings settings;
  settings.width = 40;
  settings.height = 32;
  settings.max_bounces = 4;
  settings.pixel_sampling = LUCARIUM_PIXEL_JITTER;
  settings.camera = scene.cameras.front();
  return settings;
}

/// A ball above a ground under an even sky: light paths find nothing that camera paths do not.
Scene under_the_sky() {
  Scene scene;
  const int grey = add_material(scene, lambert(0.6f));
  add_horizontal(scene, 0, 0, 0, 4, 4, true, grey);
  add_box(scene, {-0.5f, 0, -0.5f}, {0.5f, 1, 0.5f}, false, grey);
  set_environment(scene, 1);
  scene.cameras = {look_perspective({2, 1.5f, 2}, {0, 0.4f, 0}, 0.8f)};
  return scene;
}

struct Rendering {
  std::map<std::string, double> counters;
  std::vector<float> image;
};

Rendering render_adapted(const Scene& scene, uint64_t iterations, const Parameters& parameters = {}) {
  RenderSession session(test_device(), scene, registry().find("bidirectional_vpl"), settings_of(scene), parameters);
  session.run({.iterations = iterations});
  return {session.technique().counters(), image_of(session.resolve())};
}

TrialImage constant_image(uint32_t samples, size_t pixels, float value, float square) {
  const auto n = static_cast<float>(samples);
  const float4 sum = {value * n, value * n, value * n, 0}, squares = {square * n, square * n, square * n, 0};
  return {samples, std::vector<float4>(pixels, sum), std::vector<float4>(pixels, squares)};
}

}  // namespace

TEST_CASE("adapt: under an open sky light paths end after 16 samples, in a fixture they stay") {
  const auto sky = render_adapted(under_the_sky(), 18).counters;
  CHECK(sky.at("adapted_light_paths") == 0);
  CHECK(sky.at("adapted_splats") == 0);
  CHECK(sky.at("light_paths") == 16 * 40 * 32 / 8);
  CHECK(sky.at("paths") == 18 * 40 * 32);
  const auto fixture = render_adapted(load_scene("builtin:fixture"), 18).counters;
  CHECK(fixture.at("adapted_light_paths") == 1);
  CHECK(fixture.at("adapted_light_vertices") == 4);
  CHECK(fixture.at("light_paths") == 18 * 40 * 32 / 8);
  CHECK(render_adapted(under_the_sky(), 16).counters.count("adapted_light_paths") == 0);
  CHECK(render_adapted(under_the_sky(), 18, {{"adapt", "off"}}).counters.count("adapted_light_paths") == 0);
  CHECK(render_adapted(under_the_sky(), 18, {{"vpl_choice", "all"}}).counters.count("adapted_light_paths") == 0);
}

TEST_CASE("adapt: the first 16 samples stay in the image, and its mean is right") {
  const Scene sky = under_the_sky();
  CHECK(render_adapted(sky, 16).image == render_adapted(sky, 16, {{"adapt", "off"}}).image);
  CHECK(render_adapted(sky, 17).image != render_adapted(sky, 17, {{"adapt", "off"}}).image);
  Picture picture;
  picture.iterations = 40;
  check_agreement("sky", sky, picture, {}, {}, kSeeds);
  picture.max_bounces = 4;
  check_agreement("room", load_scene("builtin:room"), picture, {}, {}, kSeeds);
}

TEST_CASE("adapt: the same bits after a new beginning, and when the decision was interrupted") {
  const Scene scene = under_the_sky();
  const Rendering expected = render_adapted(scene, 20);
  RenderSession session(test_device(), scene, registry().find("bidirectional_vpl"), settings_of(scene));
  session.run({.iterations = 20});
  session.restart(1);
  CHECK(session.technique().counters().count("adapted_light_paths") == 0);
  session.run({.iterations = 16});
  for (const int requests : {3, 40, 200}) {
    int seen = 0;
    session.scheduler().set_cancel([&] { return seen++ >= requests; });
    session.iterate();
    CHECK(session.last().samples == 16);
    session.scheduler().set_cancel([] { return false; });
  }
  session.run({.iterations = 4});
  CHECK(session.last().samples == 20);
  CHECK(image_of(session.resolve()) == expected.image);
  CHECK(session.technique().counters() == expected.counters);
}

TEST_CASE("adapt: relative variance of a sample, and light that a trial has missed") {
  // Values 0 and 2 by halves: mean 1, variance 1 over n - 1; weight 1 / (1 + 0.01).
  const TrialImage noisy = constant_image(8, 100, 1, 2), still = constant_image(8, 100, 1, 1);
  CHECK(relative_variance(noisy, noisy) == doctest::Approx(8.0 / 7 / 1.01));
  CHECK(relative_variance(still, noisy) == doctest::Approx(0));
  // All light of one pixel of a hundred is missing, and no trial's noise says so: an event with the light of its eight
  // samples was due.
  TrialImage dark = still;
  dark.sums[7] = dark.squares[7] = {0, 0, 0, 0};
  const double missing = 3 * 8 / std::sqrt(1.01);
  CHECK(relative_variance(dark, still) == doctest::Approx(missing * missing / 8 / 300));
  // More light than the reference's is not missing.
  CHECK(relative_variance(constant_image(8, 100, 2, 4), still) == doctest::Approx(0));
  // Black images have no noise.
  CHECK(relative_variance(constant_image(8, 4, 0, 0), constant_image(8, 4, 0, 0)) == 0);
}

TEST_CASE("adapt: moments are those of all layers together") {
  constexpr uint32_t kPixels = 3;
  std::vector<float4> sample;
  for (int i = 0; i < 9; ++i) {
    const auto v = static_cast<float>(i + 1);
    sample.push_back({v, 10 * v, 100 * v, 7});
  }
  const auto light = test_buffer(sample);
  const auto moments = test_buffer(std::vector<float4>(2 * kPixels, float4{1, 1, 1, 0}));
  const Program program =
      make_program(*test_device(), bidirectional_vpl_kernels(), {"bidirectional_vpl/effort/trial_moments"}, {});
  run_kernel(program, "add_trial_moments", kPixels, 1,
             [&](PassBuilder& pass) { pass.arg("sample", light).arg("pixels", kPixels).arg("moments", moments); });
  const std::vector<float4> found = moments.download();
  for (uint32_t i = 0; i < kPixels; ++i) {
    const float sum = static_cast<float>(i + 1 + i + 4 + i + 7);
    CHECK(found[i].x == 1 + sum);
    CHECK(found[i].y == 1 + 10 * sum);
    CHECK(found[i].z == 1 + 100 * sum);
    CHECK(found[kPixels + i].x == 1 + sum * sum);
    CHECK(found[kPixels + i].z == 1 + 10000 * sum * sum);
  }
}

TEST_CASE("adapt: trials are small, and of the image's shape") {
  RenderSettings settings;
  settings.width = 1280;
  settings.height = 720;
  RenderSettings small = bidirectional::Trials::trial_settings(settings);
  CHECK(small.width * small.height == doctest::Approx(8192).epsilon(0.02));
  CHECK(static_cast<double>(small.width) / small.height == doctest::Approx(16.0 / 9).epsilon(0.02));
  settings.width = settings.height = 16;
  small = bidirectional::Trials::trial_settings(settings);
  CHECK(small.width == 16);
  CHECK(small.height == 16);
  settings.width = 1;
  settings.height = 100000;
  small = bidirectional::Trials::trial_settings(settings);
  CHECK(small.width == 1);
}
