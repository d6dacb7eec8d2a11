// SPDX-License-Identifier: Apache-2.0
// Gathering at every n-th pixel of every n-th row, and interpolating.
#include <doctest/doctest.h>

#include <cmath>

#include "lucarium/scene/load_scene.h"
#include "lucarium/technique/session.h"
#include "test_support.h"

using namespace lucarium;

namespace {

double mean(const std::vector<float>& values) {
  double sum = 0;
  for (const float v : values) sum += static_cast<double>(v);
  return sum / static_cast<double>(values.size());
}

struct Picture {
  std::vector<float> indirect, failed;
  double visits = 0;  ///< of nodes per pixel
};

Picture render(const char* name, const std::vector<std::pair<std::string, std::string>>& extra) {
  static const TechniqueRegistry registry;
  std::vector<std::pair<std::string, std::string>> parameters = {{"points_log2", "13"}, {"micro_size", "12"}};
  parameters.insert(parameters.end(), extra.begin(), extra.end());
  RenderSettings settings;
  settings.width = settings.height = 40;
  settings.max_bounces = 1;
  settings.pixel_sampling = 1;  // the same points in all frames
  Scene scene = load_scene(name);
  settings.camera = scene.cameras.front();
  RenderSession session(Device::open(), std::move(scene), registry.find("micro_rendering"), settings, parameters);
  session.run({.iterations = 4});
  Film film = session.resolve();
  Picture picture;
  picture.indirect = film.find("indirect")->pixels;
  if (const FilmLayer* failed = film.find("upsample_failed")) picture.failed = failed->pixels;
  picture.visits = mean(film.find("node_visits")->pixels);
  return picture;
}

double relative_rms(const std::vector<float>& a, const std::vector<float>& b) {
  double sum = 0;
  for (size_t i = 0; i < a.size(); ++i) sum += static_cast<double>((a[i] - b[i]) * (a[i] - b[i]));
  return std::sqrt(sum / static_cast<double>(a.size())) / mean(b);
}

}  // namespace

TEST_CASE("interpolated light is close to that gathered at every pixel, at a fraction of the visits") {
  for (const char* scene : {"builtin:cornell", "builtin:cornell-glossy"}) {
    CAPTURE(scene);
    const Picture all = render(scene, {});
    // 40 pixels across: errors are those of edges, at which a step spans a tenth of the picture.
    for (const int step : {2, 3, 4}) {
      CAPTURE(step);
      const Picture some = render(scene, {{"gather_step", std::to_string(step)}});
      CHECK(some.visits < all.visits * (1.0 / (step * step) + 0.1));
      CHECK(mean(some.indirect) == doctest::Approx(mean(all.indirect)).epsilon(0.02));
      CHECK(relative_rms(some.indirect, all.indirect) < 0.1 * step);
    }
  }
}

TEST_CASE("pixels fail where nothing fits, more of them the stricter, none if never") {
  const Picture all = render("builtin:cornell", {});
  const Picture strict = render("builtin:cornell", {{"gather_step", "4"}, {"upsample_fail", "1"}});
  const Picture usual = render("builtin:cornell", {{"gather_step", "4"}});
  CHECK(mean(usual.failed) > 0.01);
  CHECK(mean(strict.failed) > 3 * mean(usual.failed));
  CHECK(strict.visits == doctest::Approx(all.visits * (1. / 16 + mean(strict.failed))).epsilon(0.1));
  CHECK(relative_rms(strict.indirect, all.indirect) < relative_rms(usual.indirect, all.indirect));
  CHECK(mean(render("builtin:cornell", {{"gather_step", "4"}, {"upsample_fail", "0"}}).failed) == 0);
}
