// SPDX-License-Identifier: Apache-2.0
// Pictures of bidirectional_vpl agree with the path tracer's, block by block and on the whole, on scenes of all kinds
// of lights and materials.
#include "bidirectional_rig.h"
#include "made_scene.h"

using namespace lucarium;
using namespace lucarium::test;

namespace {

Picture path_picture(int max_bounces) {
  Picture picture;
  picture.max_bounces = max_bounces;
  picture.iterations = full_run() ? 256 : 8;
  return picture;
}

}  // namespace

TEST_CASE("pictures of rooms agree with path tracing at 1, 4 and unlimited bounces") {
  check_agreement("room, 1 bounce", load_scene("builtin:room"), path_picture(1), {}, {}, kSeeds);
  check_agreement("cornell-glossy, 4 bounces", load_scene("builtin:cornell-glossy"), path_picture(4), {}, {}, kSeeds);
  check_agreement("spheres, unlimited", load_scene("builtin:spheres"), path_picture(-1), {}, {}, kSeeds);
}

TEST_CASE("pictures of hard light agree with path tracing: inside a fixture, by a spot, through glass and mirrors") {
  Picture picture = path_picture(4);
  check_agreement("room, spot", load_scene("builtin:room:lamp=3"), picture, {}, {}, kSeeds);
  check_agreement("cornell-mirror, power heuristic", load_scene("builtin:cornell-mirror"), picture, {{"beta", "2"}}, {},
                  kSeeds);
  check_agreement("cornell-mirror, direct light only", load_scene("builtin:cornell-mirror"), path_picture(0), {}, {},
                  kSeeds);
  if (!full_run()) return;
  check_agreement("fixture, lamp", load_scene("builtin:fixture:lamp=1"), picture, {}, {}, kSeeds);
  check_agreement("caustic", load_scene("builtin:caustic"), picture, {}, {}, kSeeds);
  check_agreement("cornell", load_scene("builtin:cornell"), picture, {}, {}, kSeeds);
  check_agreement("atrium", load_scene("builtin:atrium"), picture, {}, {}, kSeeds);
}

TEST_CASE("bidirectional path tracing with light paths of its own agrees, and so does any number of samples") {
  const Picture picture = path_picture(3);
  const Scene scene = load_scene("builtin:cornell-glossy");
  check_agreement("bdpt", scene, picture, {{"preset", "bdpt"}}, {}, kSeeds);
  check_agreement("few paths", scene, picture, {{"light_paths", "37"}, {"candidates", "5"}, {"light_vertices", "2"}},
                  {}, kSeeds);
  // Few light paths for all pixels: errors of neighbours are alike and skew, which takes more pictures to judge.
  check_agreement("many candidates", scene, picture,
                  {{"light_paths", "300"}, {"candidates", "256"}, {"camera_edges", "1"}, {"beta", "2"}}, {},
                  2 * kSeeds);
}

TEST_CASE("camera paths connected to all virtual lights, or to those of their bundle's number, agree") {
  // All pixels share few light paths: see above.
  const Picture picture = path_picture(3);
  const Scene scene = load_scene("builtin:cornell-glossy");
  check_agreement("all", scene, picture, {{"vpl_choice", "all"}}, {}, 3 * kSeeds);
  check_agreement("pairs", scene, picture, {{"vpl_choice", "pair"}, {"directions", "bundle"}, {"light_vertices", "2"}},
                  {}, 2 * kSeeds);
}

TEST_CASE("light that rough glass passes on agrees with path tracing, a solid block and a pane") {
  SceneMaterial glass;
  glass.metallic = 0;
  glass.roughness = 0.35f;
  glass.transmission = 1;
  glass.thickness = 1;
  glass.attenuation_color = glm::vec3(0.4f, 0.6f, 0.9f);
  glass.attenuation_distance = 0.5f;
  SceneMaterial pane = glass;
  pane.thickness = 0;
  Scene scene;
  add_box(scene, glm::vec3(-1), glm::vec3(1), true, add_material(scene, lambert(0.6f)));
  add_box(scene, {-0.8f, -0.6f, -0.4f}, {-0.1f, -0.2f, 0.4f}, false, add_material(scene, glass));
  add_horizontal(scene, 0.45f, -0.4f, 0, 0.7f, 0.8f, true, add_material(scene, pane));
  add_light(scene, LightType::point, 1, {0, 0.3f, 0.1f}, {0, -1, 0});
  scene.cameras = {look_perspective({0.2f, 0.2f, 0.95f}, {0, -0.5f, 0}, 1.2f)};
  check_agreement("rough glass", scene, path_picture(4), {}, {}, kSeeds);
}

TEST_CASE("splats alone show indirect light where camera paths see it") {
  check_agreement("splats", load_scene("builtin:cornell"), path_picture(2), {{"strategy", "splat"}},
                  {{"direct", "off"}}, kSeeds);
}

TEST_CASE("camera paths along ray-bundles agree with path tracing, uniform and after the sky") {
  Picture picture = path_picture(3);
  check_agreement("uniform", load_scene("builtin:cornell-glossy"), picture, {{"directions", "bundle"}}, {}, kSeeds);
  // Lacquer: an ideal lobe, with an edge of its own, over a diffuse one.
  Scene lacquer = load_scene("builtin:cornell");
  for (SceneMaterial& material : lacquer.materials) {
    if (material.emissive_strength > 1 || material.emissive_factor != glm::vec3(0)) continue;
    material.ior = 3;
    material.roughness = 0;
  }
  check_agreement("distinct", lacquer, picture, {{"directions", "bundle"}, {"reuse", "distinct"}, {"bundles", "3"}}, {},
                  3 * kSeeds);
  Scene open = load_scene("builtin:cornell");
  open.environment = Environment{};
  check_agreement("sky", open, picture, {{"directions", "bundle"}, {"dir_pdf", "env"}}, {}, kSeeds);
  check_agreement("one-sided", open, picture, {{"directions", "bundle"}, {"dir_pdf", "env"}, {"bundle_sides", "one"}},
                  {}, 2 * kSeeds);
}

TEST_CASE("camera paths along ray-bundles and the BSDF in turn agree with path tracing, after odd numbers of samples") {
  Picture picture = path_picture(3);
  picture.iterations += 1;
  check_agreement("both", load_scene("builtin:cornell-glossy"), picture, {{"directions", "both"}}, {}, kSeeds);
  check_agreement("both, power heuristic", load_scene("builtin:cornell-mirror"), picture,
                  {{"directions", "both"}, {"beta", "2"}, {"light_vertices", "2"}}, {}, kSeeds);
}

TEST_CASE("one stratified set of bundles shared between depths is biased, and a set for each depth is not") {
  // Directions of one path that depend on each other are drawn with no product of densities. Two directions show most,
  // and so do camera paths that no light path helps.
  const Scene scene = load_scene("builtin:cornell");
  Picture picture = path_picture(3);
  picture.iterations *= 4;
  const auto z = [&](const char* reuse) {
    const Parameters parameters = {{"directions", "bundle"}, {"bundles", "2"}, {"reuse", reuse}, {"strategy", "nee"}};
    std::vector<double> ours, expected;
    for (const std::vector<float>& image : pictures(scene, "bidirectional_vpl", picture, parameters, kSeeds))
      ours.push_back(mean_of(image));
    for (const std::vector<float>& image : pictures(scene, "path_tracing", picture, {}, kSeeds))
      expected.push_back(mean_of(image));
    const Estimate a = estimate_of(ours), b = estimate_of(expected);
    MESSAGE(std::string(reuse) << ": " << a.mean << " +- " << a.error << ", expected " << b.mean << " +- " << b.error);
    return std::abs(a.mean - b.mean) / std::hypot(a.error, b.error);
  };
  CHECK(z("shared") > 5);
  CHECK(z("per_depth") < 4);
}

TEST_CASE("without jittered pixels there are no splats, and the picture is right") {
  Picture picture = path_picture(2);
  picture.pixel_sampling = LUCARIUM_PIXEL_CENTRE;
  const Scene scene = load_scene("builtin:cornell-glossy");
  check_agreement("centres", scene, picture, {}, {}, kSeeds);
  const Film film = render(scene, "bidirectional_vpl", picture, {{"show_strategies", "on"}});
  CHECK(mean_of(film.find("splat")->pixels) == 0);
}
