// SPDX-License-Identifier: Apache-2.0
// The strategies of bidirectional_vpl: each alone finds what it can find, and their weighted light sums to the image.
#include "bidirectional_rig.h"
#include "made_scene.h"
#include "tolerance.h"

using namespace lucarium;
using namespace lucarium::test;

namespace {

/// Means over independent pictures of a layer.
Estimate layer_estimate(const Scene& scene, const std::string& technique, const Picture& picture, const char* layer,
                        const Parameters& parameters) {
  return estimate_of(layer_means(scene, technique, picture, layer, parameters, 100));
}

/// A layer of a scene by path tracing.
struct Reference {
  Reference(const Scene& scene_, const Picture& picture_, const char* layer_)
      : scene(scene_), picture(picture_), layer(layer_) {
    Picture more = picture;
    more.iterations *= 4;
    expected = layer_estimate(scene, "path_tracing", more, layer, {});
  }
  /// Both means agree within what their errors allow; in quick runs the errors are small enough to see a factor of 1.3.
  void check(const std::string& name, const Parameters& parameters, uint64_t times = 1) const {
    Picture some = picture;
    some.iterations *= times;
    const Estimate ours = layer_estimate(scene, "bidirectional_vpl", some, layer, parameters);
    const double error = std::hypot(ours.error, expected.error);
    INFO(name, ": ", ours.mean, " +- ", ours.error, ", path tracing ", expected.mean, " +- ", expected.error);
    CHECK(std::abs(ours.mean - expected.mean) <= 5 * error + 2e-4 * expected.mean);
    CHECK(error <= (full_run() ? 0.01 : 0.06) * expected.mean);
  }

  const Scene& scene;
  Picture picture;
  const char* layer;
  Estimate expected;
};

Picture strategy_picture(int max_bounces) {
  Picture picture;
  picture.width = 32;
  picture.height = 24;
  picture.max_bounces = max_bounces;
  picture.iterations = full_run() ? 1024 : 24;
  return picture;
}

}  // namespace

TEST_CASE("the strategies' layers sum to direct and indirect light, pixel by pixel") {
  Picture picture;
  picture.iterations = 3;
  for (const char* const name : {"builtin:cornell-mirror", "builtin:spheres"}) {
    CAPTURE(name);
    const Film film =
        render(load_scene(name), "bidirectional_vpl", picture, {{"show_strategies", "on"}, {"light_vertices", "3"}});
    const std::vector<float>&direct = film.find("direct")->pixels, &indirect = film.find("indirect")->pixels;
    double worst = 0;
    for (size_t i = 0; i < direct.size(); ++i) {
      double sum = 0;
      for (const char* const strategy : {"hit", "nee", "vpl1", "vpl2", "vpl3", "splat"})
        sum += static_cast<double>(film.find(strategy)->pixels[i]);
      const double expected = static_cast<double>(direct[i]) + static_cast<double>(indirect[i]);
      worst = std::max(worst, std::abs(sum - expected) / (1e-6 + expected));
    }
    CHECK(worst <= 1e-5);
    for (const char* const strategy : {"hit", "nee", "vpl1", "vpl2", "vpl3", "splat"}) {
      CAPTURE(strategy);
      CHECK(mean_of(film.find(strategy)->pixels) > 0);
    }
  }
}

TEST_CASE("each strategy alone finds the paths that it can find") {
  // A box of one lamp: hits and light samples find all light, connections and splats all that is indirect.
  const Scene scene = load_scene("builtin:cornell");
  const Reference direct(scene, strategy_picture(2), "direct"), indirect(scene, strategy_picture(2), "indirect");
  direct.check("hit", {{"strategy", "hit"}}, 8);
  direct.check("nee", {{"strategy", "nee"}});
  indirect.check("nee", {{"strategy", "nee"}});
  indirect.check("vpl", {{"strategy", "vpl"}});
  indirect.check("vpl of one vertex", {{"strategy", "vpl"}, {"light_vertices", "1"}});
  indirect.check("all virtual lights", {{"strategy", "vpl"}, {"vpl_choice", "all"}});
  indirect.check("virtual lights in pairs", {{"strategy", "vpl"}, {"vpl_choice", "pair"}, {"light_paths", "96"}}, 4);
  indirect.check("splat", {{"strategy", "splat"}});
}

TEST_CASE("spots, skies and two-sided lamps: virtual lights and splats alone carry the right light") {
  const Scene spot = load_scene("builtin:room:lamp=3");
  const Reference by_spot(spot, strategy_picture(1), "indirect");
  by_spot.check("spot, vpl", {{"strategy", "vpl"}});
  by_spot.check("spot, splat", {{"strategy", "splat"}}, 2);

  // The box is open in front, towards the sky.
  Scene open = load_scene("builtin:cornell");
  open.environment = Environment{};
  const Reference by_sky(open, strategy_picture(1), "indirect");
  by_sky.check("sky and lamp, vpl", {{"strategy", "vpl"}});
  by_sky.check("sky and lamp, splat", {{"strategy", "splat"}});
  by_sky.check("sky and lamp, many light paths", {{"light_paths", "8192"}}, 2);

  Scene two_sided = load_scene("builtin:room");
  two_sided.lights.clear();
  SceneMaterial lamp = emitter(40);
  lamp.double_sided = true;
  add_triangles(two_sided, {{-0.3f, 1.1f, 0}, {0.1f, 1.1f, 0}, {-0.1f, 1.4f, 0.1f}}, add_material(two_sided, lamp));
  const Reference by_lamp(two_sided, strategy_picture(1), "indirect");
  by_lamp.check("two-sided, vpl", {{"strategy", "vpl"}});
  by_lamp.check("two-sided, splat", {{"strategy", "splat"}});
  by_lamp.check("two-sided, all", {});
}

TEST_CASE("orthographic cameras see the same splats") {
  Scene scene = load_scene("builtin:room:lamp=1");
  SceneCamera camera;
  camera.perspective = false;
  camera.xmag = 0.7f;
  camera.ymag = 0.6f;
  camera.world_from_camera =
      glm::inverse(glm::lookAt(glm::vec3(0.2f, 1.9f, 0.3f), glm::vec3(0.1f, 0, 0.2f), {0, 0, -1}));
  scene.cameras = {camera};
  const Reference reference(scene, strategy_picture(1), "indirect");
  reference.check("splat", {{"strategy", "splat"}}, 2);
  reference.check("many splats beside connections", {{"light_paths", "8192"}, {"candidates", "1"}}, 2);
}
