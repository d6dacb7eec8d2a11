// SPDX-License-Identifier: Apache-2.0
// Ray-bundles that are rasterized: what camera paths meet along them is looked up in stored fragments. All modes take
// the same directions, so that pictures of one seed differ only by what is met.
#include <algorithm>

#include "bidirectional_rig.h"
#include "made_scene.h"

using namespace lucarium;
using namespace lucarium::test;

namespace {

Picture bundle_picture(uint64_t iterations) {
  Picture picture;
  picture.iterations = iterations;
  return picture;
}

/// Of one seed.
std::vector<float> image(const Scene& scene, const Picture& picture, const std::string& mode, const Parameters& more) {
  Parameters parameters = {{"directions", "bundle"}, {"bundle_mode", mode}};
  parameters.insert(parameters.end(), more.begin(), more.end());
  return image_of(render(scene, "bidirectional_vpl", picture, parameters));
}

/// A room whose walls are in part MASK and BLEND, with a mirror and a block of glass, under a sky.
Scene mixed_room() {
  Scene scene = load_scene("builtin:cornell-mirror");
  SceneMaterial leaf = lambert(0.5f);
  leaf.alpha_mode = AlphaMode::blend;
  leaf.base_color.a = 0.5f;
  leaf.double_sided = true;
  add_horizontal(scene, 0.6f, 0.1f, 0.1f, 0.5f, 0.5f, true, add_material(scene, leaf));
  scene.environment = Environment{};
  return scene;
}

/// Mean of the first picture less that of the second, over the second's.
double relative_difference(const std::vector<float>& a, const std::vector<float>& b) {
  return mean_of(a) / mean_of(b) - 1;
}

}  // namespace

TEST_CASE("stored bundles with all triangles of a pixel show what rays show, BLEND, mirrors and sky included") {
  const Scene scene = mixed_room();
  const Picture picture = bundle_picture(4);
  for (const char* reuse : {"per_depth", "distinct", "shared"}) {
    const Parameters more = {{"bundles", "5"}, {"bundle_res", "128"}, {"reuse", reuse}};
    const std::vector<float> rays = image(scene, picture, "rays", more), exact = image(scene, picture, "exact", more);
    // A ray that meets an edge may take either side of it.
    size_t different = 0;
    for (size_t i = 0; i < rays.size(); ++i)
      different += std::abs(rays[i] - exact[i]) > 1e-4f * std::max(std::abs(rays[i]), 1e-3f);
    INFO(std::string(reuse) << ": " << different << " of " << rays.size());
    CHECK(different <= rays.size() / 500);
    CHECK(std::abs(relative_difference(exact, rays)) < 1e-3);
  }
}

TEST_CASE("stored bundles from linked lists are those from tiles, bit for bit") {
  const Scene scene = mixed_room();
  const Picture picture = bundle_picture(1);
  const Parameters more = {{"bundles", "3"}, {"bundle_res", "48"}};
  CHECK(image(scene, picture, "linked_list", more) == image(scene, picture, "raster", more));
}

TEST_CASE("stored bundles: the error of their resolution has a sign, and goes away with it") {
  // Under an even sky, blocks on a floor: what a point sees is a surface or the sky alone.
  Scene scene;
  const int grey = add_material(scene, lambert(0.5f));
  add_horizontal(scene, 0, 0, 0, 2, 2, true, grey);
  for (int i = -2; i <= 2; ++i)
    for (int j = -2; j <= 2; ++j) {
      const glm::vec3 corner(0.35f * static_cast<float>(i) - 0.1f, 0, 0.35f * static_cast<float>(j) - 0.1f);
      add_box(scene, corner, corner + glm::vec3(0.2f, 0.2f + 0.05f * static_cast<float>(i), 0.2f), false, grey);
    }
  set_environment(scene, 1);
  scene.cameras = {look_perspective({0.5f, 1.5f, 1.2f}, {0, 0, 0}, 0.9f)};
  Picture picture = bundle_picture(full_run() ? 64 : 8);
  picture.max_bounces = 0;
  // Points at the feet of blocks see less of the sky than they should.
  std::vector<double> coarse, fine;
  for (uint64_t seed = 1; seed <= 8; ++seed) {
    picture.seed = seed;
    const auto of = [&](const char* mode, const char* resolution) {
      return image(scene, picture, mode, {{"strategy", "hit"}, {"bundle_res", resolution}});
    };
    const std::vector<float> rays = of("rays", "32");
    coarse.push_back(relative_difference(of("raster", "32"), rays));
    fine.push_back(relative_difference(of("raster", "512"), rays));
  }
  const Estimate at_32 = estimate_of(coarse), at_512 = estimate_of(fine);
  MESSAGE("32: " << at_32.mean << " +- " << at_32.error << ", 512: " << at_512.mean << " +- " << at_512.error);
  CHECK(at_32.mean < -4 * at_32.error);
  CHECK(at_32.mean > -0.03);
  CHECK(std::abs(at_512.mean) < 4 * at_512.error + 2e-4);
  CHECK(std::abs(at_512.mean) < -0.1 * at_32.mean);
}
