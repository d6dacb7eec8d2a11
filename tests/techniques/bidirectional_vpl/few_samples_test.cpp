// SPDX-License-Identifier: Apache-2.0
// Pictures of few samples: interleaved bundles and virtual lights, the filter over their tiles, and caches of light
// from frame to frame.
#include "bidirectional_rig.h"
#include "made_scene.h"
#include "tolerance.h"

using namespace lucarium;
using namespace lucarium::test;

namespace {

Picture few(uint64_t iterations) {
  Picture picture;
  picture.max_bounces = 2;
  picture.iterations = iterations;
  return picture;
}

/// Of eight pictures' layer, by pixel: the variance summed over pixels, and the mean.
std::pair<double, double> variance_and_mean(const Scene& scene, Picture picture, const Parameters& parameters) {
  std::vector<double> sums, squares;
  picture.seed = 5;
  for (const Film& film : films(scene, "bidirectional_vpl", picture, parameters, kSeeds)) {
    const std::vector<float>& pixels = film.find("indirect")->pixels;
    sums.resize(pixels.size());
    squares.resize(pixels.size());
    for (size_t p = 0; p < pixels.size(); ++p) {
      sums[p] += double{pixels[p]} / kSeeds;
      squares[p] += double{pixels[p]} * double{pixels[p]} / kSeeds;
    }
  }
  double variance = 0, mean = 0;
  for (size_t p = 0; p < sums.size(); ++p) {
    variance += squares[p] - sums[p] * sums[p];
    mean += sums[p] / static_cast<double>(sums.size());
  }
  return {variance, mean};
}

}  // namespace

TEST_CASE("interleaved pixels take other virtual lights and bundles, and agree with path tracing") {
  const Scene scene = load_scene("builtin:cornell");
  check_agreement("resampled", scene, few(8), {{"interleave", "4"}}, {}, kSeeds);
  // All pixels share few light paths: errors of neighbours are alike and skew.
  check_agreement("one in nine of all", scene, few(9),
                  {{"interleave", "3"}, {"vpl_choice", "all"}, {"directions", "bundle"}}, {}, 2 * kSeeds);
}

TEST_CASE("the filter takes noise away, keeps the mean, and is off once pixels have as many samples as a tile") {
  const Scene scene = load_scene("builtin:cornell");
  const Parameters plain = {{"interleave", "4"}}, filtered = {{"interleave", "4"}, {"filter", "on"}};
  const auto [noise, mean] = variance_and_mean(scene, few(2), plain);
  const auto [less, same] = variance_and_mean(scene, few(2), filtered);
  MESSAGE("variance " << noise << " and filtered " << less << ", mean " << mean << " and " << same);
  CHECK(less < 0.25 * noise);
  CHECK(same == test::relative(mean, 0.04));
  const Film a = render(scene, "bidirectional_vpl", few(16), plain),
             b = render(scene, "bidirectional_vpl", few(16), filtered);
  CHECK(a.find("indirect")->pixels == b.find("indirect")->pixels);
}

TEST_CASE("the filter does not mix walls: an edge between black and white stays where it is") {
  Scene scene;
  add_box(scene, glm::vec3(-1), glm::vec3(1), true, add_material(scene, emitter(1, 0.8f)));
  add_box(scene, {-0.1f, -0.9f, -0.1f}, {0.1f, 0.3f, 0.1f}, false, add_material(scene, lambert(0)));
  scene.cameras = {look_perspective({0.2f, 0.2f, 0.95f}, {0, -0.2f, 0}, 1.2f)};
  Picture picture = few(1);
  picture.pixel_sampling = LUCARIUM_PIXEL_CENTRE;
  const Film filtered = render(scene, "bidirectional_vpl", picture, {{"interleave", "8"}, {"filter", "on"}});
  picture.iterations = 32;
  const Film more = render(scene, "bidirectional_vpl", picture, {});
  const std::vector<float>&direct = more.find("direct")->pixels, &pixels = filtered.find("indirect")->pixels;
  size_t black = 0, white = 0;
  for (size_t p = 0; p < pixels.size(); ++p) {
    if (direct[p] > 0) {  // walls: of one sample each, some are black before the filter
      ++white;
      CHECK(pixels[p] > 0.1f);
    } else {
      ++black;
      CHECK(pixels[p] == 0);
    }
  }
  CHECK(white > 1000);
  CHECK(black > 20);
}

TEST_CASE("caches bring light along with camera and objects, for fewer rays, and a seed is a new beginning") {
  Scene scene = load_scene("builtin:cornell");
  RenderSettings settings;
  settings.width = settings.height = 48;
  settings.max_bounces = 2;
  settings.camera = scene.cameras.front();
  settings.pixel_sampling = 2;
  const auto rays = [](RenderSession& session) { return session.technique().counters().at("connection_rays"); };
  RenderSession session(test_device(), scene, registry().find("bidirectional_vpl"), settings, {{"caches", "on"}});
  session.run({.iterations = 4});
  const double first = rays(session);
  const std::vector<float> begun = image_of(session.resolve());

  // A still object and a camera that moves by a pixel a frame.
  const double side = 0.01;
  SceneCamera camera = settings.camera;
  for (int frame = 0; frame < 4; ++frame) {
    camera.world_from_camera =
        glm::translate(glm::mat4(1), glm::vec3(static_cast<float>(side), 0, 0)) * camera.world_from_camera;
    session.set_camera(camera);
    session.run({.iterations = 4});
    CHECK(rays(session) < 0.45 * first);
    CHECK(rays(session) > 0.2 * first);
  }
  const std::vector<float> moved = image_of(session.resolve());
  RenderSettings there = settings;
  there.camera = camera;
  RenderSession fresh(test_device(), scene, registry().find("bidirectional_vpl"), there, {});
  fresh.run({.iterations = 64});
  const double expected = mean_of(image_of(fresh.resolve()));
  CHECK(mean_of(moved) == test::relative(expected, 0.03));

  // A new seed is a new beginning.
  session.restart(settings.seed);
  session.set_camera(settings.camera);
  session.restart(settings.seed);
  session.run({.iterations = 4});
  CHECK(image_of(session.resolve()) == begun);
}

TEST_CASE("direct light is the same however many light paths there are") {
  // Splats do not find paths of one scattering, and no weight of theirs may depend on them.
  const Picture picture = few(2);
  const Scene scene = load_scene("builtin:cornell");
  const auto direct = [&](const char* light_paths) {
    return render(scene, "bidirectional_vpl", picture, {{"light_paths", light_paths}, {"light_vertices", "3"}})
        .find("direct")
        ->pixels;
  };
  const std::vector<float> one = direct("1"), many = direct("100000");
  REQUIRE(one.size() == many.size());
  CHECK(mean_of(one) > 0.01);
  double worst = 0;
  for (size_t p = 0; p < one.size(); ++p) worst = std::max(worst, std::abs(double{one[p]} - double{many[p]}));
  CHECK(worst <= 1e-6);
}
