// SPDX-License-Identifier: Apache-2.0
// References that grow, and errors measured against them.
#include <doctest/doctest.h>

#include "lucarium/base/json.h"
#include "lucarium/view/truth/error_history.h"
#include "technique_session.h"
#include "tolerance.h"

using namespace lucarium;
using nlohmann::json;

namespace {

constexpr uint64_t grown = 2048;  // samples of the reference

std::unique_ptr<GrowingReference> reference_of(const std::shared_ptr<SceneOnDevice>& scene,
                                               const RenderSettings& settings, const PathSet& paths) {
  return std::make_unique<GrowingReference>(test::test_device(), scene, test::registry().find("path_tracing"), settings,
                                            paths, RenderSession::OnPreparing{}, [] { return false; });
}

}  // namespace

TEST_CASE("the error of an unbiased picture is its noise and the reference's own, that of a biased one is more") {
  const std::shared_ptr<SceneOnDevice> scene = share_scene(load_scene("builtin:cornell"));
  RenderSettings settings;
  settings.width = settings.height = 24;
  settings.camera = load_scene("builtin:cornell").cameras.front();
  const TechniqueType& type = test::registry().find("path_tracing");
  RenderSession session(test::test_device(), scene, type, settings, {{"replicates", "16"}});
  const PathSet paths = session.technique().path_set(session.scene(), session.settings());
  const auto reference = reference_of(scene, settings, paths);
  CHECK(reference->measured_samples() == 0);
  while (reference->measured_samples() < grown) reference->work();
  while (session.last().samples < 128) session.iterate();
  // Few samples: a pixel that has caught much light is off by much, and it is not for its brightness that this is
  // little.
  RenderSession few(test::test_device(), scene, type, settings, {{"replicates", "16"}});
  while (few.last().samples < 16) few.iterate();
  const Film early = few.resolve();
  const double early_noise = reference->noise(early.find("Variance")->pixels);
  CHECK(reference->relmse(early.image()) == test::relative(early_noise + reference->own_relmse(), 0.3));
  ErrorHistory history;
  history.keep({"path_tracing", {}}, "", 1, 16, early);
  CHECK(history.measure_one("", *reference));
  CHECK(history.describe()[0]["points"][0]["noise"] == early_noise);
  const Film film = session.resolve();
  const double noise = reference->noise(film.find("Variance")->pixels), own = reference->own_relmse();
  CHECK(noise > 0);
  CHECK(own < 0.2 * noise);
  // 576 pixels of three channels: the sum of their squares is within a tenth or so of what is expected.
  CHECK(reference->relmse(film.image()) == test::relative(noise + own, 0.3));
  std::vector<float> brighter = film.image();
  for (float& value : brighter) value *= 1.5f;
  CHECK(reference->relmse(brighter) > 4 * (noise + own));
  CHECK(reference->flip(brighter) > reference->flip(film.image()));
}

TEST_CASE("a reference has the bounces that the technique has, though more are asked for") {
  const std::shared_ptr<SceneOnDevice> scene = share_scene(load_scene("builtin:cornell"));
  RenderSettings settings;
  settings.width = settings.height = 16;
  settings.camera = load_scene("builtin:cornell").cameras.front();
  RenderSettings direct = settings;
  direct.max_bounces = 0;
  RenderSession session(test::test_device(), scene, test::registry().find("path_tracing"), direct,
                        {{"replicates", "16"}});
  const auto reference = reference_of(scene, settings, session.technique().path_set(session.scene(), direct));
  while (reference->measured_samples() < 256) reference->work();
  while (session.last().samples < 64) session.iterate();
  const Film film = session.resolve();
  // Indirect light would make it thousands of times as much.
  CHECK(reference->relmse(film.image()) <
        3 * (reference->noise(film.find("Variance")->pixels) + reference->own_relmse()));
}

TEST_CASE("errors of all that was tried stay, and are measured again when the reference is better") {
  const std::shared_ptr<SceneOnDevice> scene = share_scene(load_scene("builtin:cornell"));
  RenderSettings settings;
  settings.width = settings.height = 16;
  settings.camera = load_scene("builtin:cornell").cameras.front();
  const auto reference = reference_of(scene, settings, {});
  while (reference->measured_samples() == 0) reference->work();
  Film film(16, 16);
  FilmLayer& layer = film.layer("direct", {"R", "G", "B"}, true);
  std::fill(layer.pixels.begin(), layer.pixels.end(), 0.25f);

  ErrorHistory history;
  const ViewTechnique first{"a", {}}, second{"a", {{"b", "1"}}};
  CHECK_FALSE(history.wants(first, 0, false));
  CHECK(history.wants(first, 0.5, false));
  history.keep(first, "paths", 0.5, 1, film);
  CHECK_FALSE(history.wants(first, 0.6, false));
  CHECK(history.wants(first, 0.6, true));
  CHECK_FALSE(history.wants(first, 0.5, true));
  CHECK(history.wants(first, 0.8, false));
  history.keep(first, "paths", 0.8, 2, film);
  CHECK(history.wants(second, 0.1, false));
  history.keep(second, "other paths", 0.1, 1, film);
  CHECK(history.measure_one("paths", *reference));
  CHECK(history.measure_one("paths", *reference));
  CHECK_FALSE(history.measure_one("paths", *reference));
  json curves = history.describe();
  REQUIRE(curves.size() == 2);
  REQUIRE(curves[0]["points"].size() == 2);
  CHECK(curves[1]["points"].empty());  // other paths: another reference
  CHECK(curves[0]["points"][0]["relmse"] == reference->relmse(film.image()));
  CHECK(curves[0]["points"][0]["noise"].is_null());
  const double own = reference->own_relmse();
  CHECK(curves[0]["points"][0]["own"] == own);

  const uint64_t before = reference->measured_samples();
  while (reference->measured_samples() == before) reference->work();
  CHECK(reference->measured_samples() == 2 * before);
  CHECK(reference->own_relmse() < own);
  curves = history.describe();
  CHECK(curves[0]["points"][0]["own"] == own);  // not yet measured again: that of the reference which it met
  CHECK(history.measure_one("paths", *reference));
  CHECK(history.measure_one("paths", *reference));
  curves = history.describe();
  CHECK(curves[0]["points"][0]["relmse"] == reference->relmse(film.image()));
  CHECK(curves[0]["points"][0]["own"] == reference->own_relmse());
}
