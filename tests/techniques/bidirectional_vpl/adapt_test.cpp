// SPDX-License-Identifier: Apache-2.0
// adapt: what costs more than it brings is left out, and the image's mean and bits depend on nothing else.
#include <random>

#include "bidirectional_rig.h"
#include "bidirectional_vpl/effort/efficiency.h"
#include "bidirectional_vpl/effort/trials.h"
#include "made_scene.h"
#include "tolerance.h"

const lucarium::EmbeddedSources& bidirectional_vpl_kernels();

using namespace lucarium;
using namespace lucarium::test;
using bidirectional::hidden_variance;
using bidirectional::pixel_weights;
using bidirectional::PixelWeights;
using bidirectional::relative_variance;
using bidirectional::TrialImage;

namespace {

RenderSettings settings_of(const Scene& scene) {
  RenderSettings settings;
  settings.width = 72;
  settings.height = 57;
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

/// Of `samples` samples, which all have one value.
TrialImage constant_image(uint32_t samples, uint32_t side, float value, float square) {
  TrialImage image;
  image.width = image.height = side;
  const auto filled = [&](float v) { return std::vector<float4>(size_t{side} * side, float4{v, v, v, 0}); };
  for (uint32_t i = 1; i <= samples; ++i) image.sums.push_back(filled(value * static_cast<float>(i)));
  image.squares = filled(square * static_cast<float>(samples));
  return image;
}

/// Mean 1 and variance 1 / shape, independent in all pixels and samples.
TrialImage noisy_image(uint32_t seed, uint32_t samples, uint32_t side, double shape) {
  std::mt19937 random(seed);
  std::gamma_distribution<float> light(static_cast<float>(shape), static_cast<float>(1 / shape));
  TrialImage image = constant_image(0, side, 0, 0);
  std::vector<float4> sum(image.squares);
  for (uint32_t i = 0; i < samples; ++i) {
    for (size_t pixel = 0; pixel < sum.size(); ++pixel) {
      const float x = light(random);
      for (float float4::*channel : {&float4::x, &float4::y, &float4::z}) {
        sum[pixel].*channel += x;
        image.squares[pixel].*channel += x * x;
      }
    }
    image.sums.push_back(sum);
  }
  return image;
}

}  // namespace

TEST_CASE("adapt: under an open sky light paths end after 16 samples, in a fixture they stay") {
  const auto sky = render_adapted(under_the_sky(), 20).counters;
  CHECK(sky.at("adapted_light_paths") == 0);
  CHECK(sky.at("adapted_splats") == 0);
  CHECK(sky.at("light_paths") == 17 * (72 * 57 / 8));
  CHECK(sky.at("paths") == 20 * 72 * 57);
  // Trials are counted apart: 8 samples each of a quarter of the pixels, and more rays than paths.
  CHECK(sky.at("trials") >= 2);
  CHECK(sky.at("trial_paths") / sky.at("trials") == within(8.0 * 72 * 57 / 4, 0.02 * 8 * 72 * 57 / 4));
  CHECK(sky.at("trial_rays") > 1.5 * sky.at("trial_paths"));
  const auto fixture = render_adapted(load_scene("builtin:fixture"), 26).counters;
  CHECK(fixture.at("adapted_light_paths") == 1);
  CHECK(fixture.at("adapted_light_vertices") == 4);
  CHECK(fixture.at("light_paths") == 26 * (72 * 57 / 8));
  const auto before = render_adapted(under_the_sky(), 16).counters;
  CHECK(before.count("adapted_light_paths") == 0);
  CHECK(before.count("trials") == 0);
  CHECK(render_adapted(under_the_sky(), 26, {{"adapt", "off"}}).counters.count("adapted_light_paths") == 0);
  CHECK(render_adapted(under_the_sky(), 26, {{"vpl_choice", "all"}, {"light_paths", "1"}})
            .counters.count("adapted_light_paths") == 0);
}

TEST_CASE("adapt: the first 16 samples stay in the image, and its mean is right") {
  const Scene sky = under_the_sky();
  CHECK(render_adapted(sky, 17).image == render_adapted(sky, 17, {{"adapt", "off"}}).image);
  CHECK(render_adapted(sky, 18).image != render_adapted(sky, 18, {{"adapt", "off"}}).image);
  Picture picture;
  picture.width = 72;
  picture.height = 57;
  picture.iterations = 24;
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
  for (uint64_t samples = 16; samples < 20; ++samples) {
    for (const int requests : {1, 20, 60}) {
      int seen = 0;
      session.scheduler().set_cancel([&] { return seen++ >= requests; });
      session.iterate();
      CHECK(session.last().samples == samples);
      session.scheduler().set_cancel([] { return false; });
    }
    session.iterate();
    CHECK(session.last().samples == samples + 1);
  }
  CHECK(image_of(session.resolve()) == expected.image);
  CHECK(session.technique().counters() == expected.counters);
}

TEST_CASE("adapt: relative variance of a sample, and light that a trial has missed") {
  // Values 0 and 2 by halves: mean 1, variance 1 over n - 1; weight 1 / (1 + 0.01).
  const TrialImage noisy = constant_image(8, 10, 1, 2), still = constant_image(8, 10, 1, 1);
  const PixelWeights weights = pixel_weights(noisy);
  CHECK(relative_variance(noisy, weights) == relative(8.0 / 7 / 1.01));
  CHECK(relative_variance(still, weights) == within(0, 1e-5));
  CHECK(hidden_variance(still, noisy, weights) == 0);
  // All light of one pixel of a hundred is missing, and no noise says so: an event with the light of its eight samples
  // was due.
  TrialImage dark = still;
  for (std::vector<float4>& sums : dark.sums) sums[7] = {0, 0, 0, 0};
  const double missing = 3 * 8 / std::sqrt(1.01);
  CHECK(hidden_variance(dark, still, weights) == relative(missing * missing / 8 / 300));
  // More light than the reference's is not missing.
  CHECK(hidden_variance(still, dark, weights) == 0);
  // Bright surroundings weigh less.
  TrialImage half = constant_image(8, 20, 1, 1);
  for (size_t i = 0; i < 200; ++i) half.sums.back()[i] = {80, 80, 80, 0};
  const PixelWeights uneven = pixel_weights(half);
  CHECK(uneven[0][0] == relative(1 / (100 + 0.01 * 5.5 * 5.5)));
  CHECK(uneven[399][2] == relative(1 / (1 + 0.01 * 5.5 * 5.5)));
  CHECK(lit_pixels(dark) == 99);
}

TEST_CASE("adapt: an estimator is not better than itself") {
  for (const double variance : {0.1, 1.0, 3.0}) {
    CAPTURE(variance);
    const TrialImage first = noisy_image(1, 8, 48, 1 / variance), second = noisy_image(2, 8, 48, 1 / variance);
    const PixelWeights weights = pixel_weights(first);
    const double expected = relative_variance(first, weights);
    CHECK(expected == test::relative(variance / 1.01, 0.15));
    CHECK(relative_variance(second, weights) == test::relative(expected, 0.1));
    CHECK(hidden_variance(second, first, weights) == 0);
    // A twentieth less light is seen where noise is small.
    if (variance > 0.1) continue;
    TrialImage darker = second;
    for (std::vector<float4>& sums : darker.sums)
      for (float4& sum : sums) sum = {0.95f * sum.x, 0.95f * sum.y, 0.95f * sum.z, 0};
    CHECK(hidden_variance(darker, first, weights) > 0);
  }
  // Half of the light of a block of 8 x 8 pixels, a hundredth of all, drowns in the noise of the whole.
  const TrialImage first = noisy_image(1, 8, 80, 1), second = noisy_image(2, 8, 80, 1);
  const PixelWeights weights = pixel_weights(first);
  CHECK(hidden_variance(second, first, weights) == 0);
  TrialImage darker = second;
  for (std::vector<float4>& sums : darker.sums)
    for (size_t y = 16; y < 24; ++y)
      for (size_t x = 40; x < 48; ++x) sums[y * 80 + x] = {0.5f * sums[y * 80 + x].x, 0, 0, 0};
  CHECK(hidden_variance(darker, first, weights) > 0.1);
}

TEST_CASE("adapt: work counts rays, vertices and candidates") {
  using bidirectional::work_of;
  CHECK(work_of({}) == 0);
  CHECK(work_of({{"light_sample_rays", 7}}) == 7);
  double before = 0;
  std::map<std::string, double> counters;
  for (const char* const name : {"paths", "camera_rays", "light_sample_rays", "connection_rays", "candidates",
                                 "light_path_rays", "splat_rays"}) {
    counters[name] = 100;
    CHECK(work_of(counters) > before);
    before = work_of(counters);
  }
  // A vertex of a camera path costs more than a shadow ray, a candidate less.
  CHECK(work_of({{"camera_rays", 1}}) > 1);
  CHECK(work_of({{"candidates", 1}}) < 1);
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

TEST_CASE("adapt: trials are small, of the image's shape, and not before what they cost") {
  using bidirectional::Trials;
  RenderSettings settings;
  settings.width = 1280;
  settings.height = 720;
  RenderSettings small = Trials::trial_settings(settings);
  CHECK(small.width * small.height == relative(8192, 0.02));
  CHECK(static_cast<double>(small.width) / small.height == relative(16.0 / 9, 0.02));
  CHECK(Trials::samples_before({}, settings) == 16);
  // One pixel has trials of the same view, of enough pixels.
  settings.width = settings.height = 1;
  small = Trials::trial_settings(settings);
  CHECK(small.width == 32);
  CHECK(small.height == 32);
  CHECK(Trials::samples_before({}, settings) == 8 * 8 * 1024);
  settings.height = 100000;
  small = Trials::trial_settings(settings);
  CHECK(small.width == 1);
  CHECK(small.height == 8192);
}

TEST_CASE("adapt: a picture without light, or with hardly any, changes nothing") {
  Scene scene = under_the_sky();
  set_environment(scene, 0);
  add_light(scene, LightType::point, 1, {50, 0.1f, 50}, {0, -1, 0});
  scene.cameras = {look_perspective({2, 1.5f, 2}, {4, 4.0f, 4}, 0.2f)};
  const Rendering dark = render_adapted(scene, 26);
  CHECK(mean_of(dark.image) == 0);
  if (dark.counters.count("adapted_light_paths")) CHECK(dark.counters.at("adapted_light_paths") == 1);
}
