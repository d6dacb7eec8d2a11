// SPDX-License-Identifier: Apache-2.0
// Further samples of pixels (eye_share): light and edges have less noise, gathers keep their bits.
#include <doctest/doctest.h>

#include <utility>

#include "lucarium/base/interrupt.h"
#include "technique_fixture.h"
#include "test_support.h"
#include "tolerance.h"

using namespace lucarium;
using namespace lucarium::test;

namespace {

const Parameters shared = {{"eye_share", "0.25"}}, balanced = {{"eye_share", "-1"}};

/// cancelled: counts the iterations that were, each after one request more than the one before.
Film picture(const Parameters& more, uint64_t frames, int* cancelled = nullptr) {
  const Scene scene = load_scene("builtin:cornell");
  RenderSettings settings = settings_for(scene, 24, 1);
  settings.pixel_sampling = LUCARIUM_PIXEL_JITTER;
  RenderSession session(Device::open(), scene, registry().find("micro_rendering"), settings, with(small, more));
  for (int allowed = 1; cancelled && session.last().samples < frames; ++allowed) {
    int requests = 0;
    session.scheduler().set_cancel([&] { return requests++ >= allowed; });
    const uint64_t before = session.iterations();
    session.iterate();
    *cancelled += session.iterations() == before;
  }
  session.scheduler().set_cancel(interrupt_requested);
  session.run({.samples = frames});
  return session.resolve();
}

double rmse(const Film& film, const char* layer, const Film& truth) {
  return relative_rmse(film.find(layer)->pixels, truth.find(layer)->pixels);
}

}  // namespace

TEST_CASE("further samples of pixels take noise from emission and direct light, and leave gathers their bits") {
  const Film truth = picture({{"eye_share", "0.9"}, {"direct_samples", "16"}}, full_run() ? 64 : 24);
  const Film few = picture({{"eye_share", "0"}}, 2), more = picture(shared, 2);
  CHECK(few.find("indirect")->pixels == more.find("indirect")->pixels);
  for (const char* const layer : {"direct", "emission"}) {
    MESSAGE(std::string(layer) << ": " << rmse(few, layer, truth) << " without, " << rmse(more, layer, truth)
                               << " with");
    CHECK(rmse(more, layer, truth) < 0.6 * rmse(few, layer, truth));
    CHECK(mean(more.find(layer)->pixels) == relative(mean(truth.find(layer)->pixels), 0.02));
  }
}

TEST_CASE("frames with further samples of pixels have their bits after cancelled runs") {
  int cancelled = 0;
  for (const Parameters& share : {shared, balanced}) {
    const Film undisturbed = picture(share, 2), disturbed = picture(share, 2, &cancelled);
    CHECK(std::exchange(cancelled, 0) > 3);
    for (const char* const layer : {"direct", "emission", "indirect"})
      CHECK(undisturbed.find(layer)->pixels == disturbed.find(layer)->pixels);
  }
}

TEST_CASE("what scatters more gets more samples: noise of direct light, of gathers, and none of either") {
  const auto eye_samples = [](const Parameters& more) {
    const Scene scene = load_scene("builtin:cornell");
    RenderSettings settings = settings_for(scene, 24, 1);
    settings.pixel_sampling = LUCARIUM_PIXEL_JITTER;
    RenderSession session(Device::open(), scene, registry().find("micro_rendering"), settings,
                          with(with(small, balanced), more));
    session.run({.samples = 3});
    return session.technique().counters().at("eye samples");
  };
  const double one = eye_samples({{"direct_samples", "1"}}), many = eye_samples({{"direct_samples", "64"}});
  const double fine = eye_samples({{"direct_samples", "1"}, {"micro_size", "32"}});
  MESSAGE("samples of pixels in 3 frames: ", one, "; with 64 samples of direct light each ", many,
          "; with micro-buffers of 32 squared ", fine);
  CHECK(many >= 3);
  CHECK(one > 2 * many);
  CHECK(fine > one);
  CHECK(eye_samples({{"eye_share", "0"}}) == 3);
}

TEST_CASE("shares by measured variances: a restart has the bits of a fresh session, and frames may have many batches") {
  const Scene scene = load_scene("builtin:cornell");
  for (const Parameters& more : {Parameters{{"batch_gathers", "64"}}, Parameters{{"gather_step", "3"}},
                                 Parameters{{"multibounce", "instant_radiosity"}, {"gather_visible", "off"}}}) {
    RenderSettings settings = settings_for(scene, 24, 1);
    settings.pixel_sampling = LUCARIUM_PIXEL_JITTER;
    const auto session = [&](uint32_t seed) {
      settings.seed = seed;
      return std::make_unique<RenderSession>(Device::open(), scene, registry().find("micro_rendering"), settings,
                                             with(with(small, balanced), more));
    };
    const auto fresh = session(2), restarted = session(1);
    fresh->run({.samples = 3});
    restarted->run({.samples = 2});
    restarted->restart(2);
    restarted->run({.samples = 3});
    const double samples = fresh->technique().counters().at("eye samples");
    CHECK(samples > 3);
    CHECK(samples <= 3 * 65);
    CHECK(restarted->technique().counters().at("eye samples") == samples);
    const Film one = fresh->resolve(), other = restarted->resolve();
    for (const char* const layer : {"direct", "emission", "indirect"})
      CHECK(one.find(layer)->pixels == other.find(layer)->pixels);
  }
}

TEST_CASE("with gather_env what gathers see of the sky counts for the shares") {
  // A furnace of sky alone has no light by samples: nothing scatters but gathers and edges.
  const auto eye_samples = [](const char* gather_env) {
    Scene scene = load_scene("builtin:cornell");
    for (SceneMaterial& material : scene.materials) material.emissive_factor = glm::vec3(0);
    scene.environment.emplace();
    scene.environment->factor = glm::vec3(1);
    RenderSettings settings = settings_for(scene, 24, 1);
    RenderSession session(Device::open(), scene, registry().find("micro_rendering"), settings,
                          with(with(small, balanced), {{"gather_env", gather_env}, {"direct_samples", "1"}}));
    session.run({.samples = 3});
    return session.technique().counters().at("eye samples");
  };
  const double sampled = eye_samples("off"), gathered = eye_samples("on");
  MESSAGE("samples of pixels in 3 frames: ", sampled, ", with the sky gathered ", gathered);
  CHECK(gathered < 0.5 * sampled);
}
