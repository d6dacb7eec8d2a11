// SPDX-License-Identifier: Apache-2.0
// The image test of docs/validation.md beside the path tracer: by pixels, by blocks and as a whole, on scenes of all
// kinds of light and materials, with 1, 4 and unlimited bounces; and a hundredth of the energy does not pass.
#include "bidirectional_rig.h"
#include "lucarium/statistics/image_comparison.h"

using namespace lucarium;
using namespace lucarium::test;

namespace {

constexpr uint32_t kImages = 16;  ///< of each side
/// So that right pictures seldom fail in any of the many tests.
const ImageTestOptions kOptions = {.level = 2e-4, .image_level = 1e-4};

/// What is compared, and how long each picture takes until a hundredth stands out.
struct Compared {
  const char* scene;
  int max_bounces;
  uint64_t ours, theirs;  ///< iterations of a picture, bidirectional_vpl and path_tracing
  bool even = true;       ///< pixels of path_tracing find all light often enough for Student's t
  bool resolved = true;   ///< a hundredth is above the noise
};

/// Scattered light of independent pictures, by seed. What is emitted towards the eye is the same by both techniques;
/// few samples of a lamp's edge have few values, which Student's t is not made for.
std::vector<std::vector<float>> scattered(const Scene& scene, const char* technique, Picture picture,
                                          uint64_t iterations) {
  picture.iterations = iterations;
  std::vector<std::vector<float>> images;
  for (uint32_t i = 0; i < kImages; ++i) {
    picture.seed = 1000 + i;
    const Film film = render(scene, technique, picture);
    images.push_back(film.find("direct")->pixels);
    const std::vector<float>& indirect = film.find("indirect")->pixels;
    for (size_t k = 0; k < indirect.size(); ++k) images.back()[k] += indirect[k];
  }
  return images;
}

ImageTest compare(const Picture& picture, std::vector<std::vector<float>> ours, const ImageEstimate& expected,
                  float scale) {
  for (std::vector<float>& image : ours)
    for (float& value : image) value *= scale;
  const ImageEstimate estimate = ImageEstimate::from_replicates(picture.width, picture.height, std::move(ours));
  return test_images(estimate, expected, kOptions);
}

/// Ours agree, and do not any more with a hundredth more of energy.
void check_energy(const Compared& compared) {
  INFO(std::string(compared.scene), ", bounces ", compared.max_bounces);
  const Scene scene = load_scene(compared.scene);
  Picture picture;
  picture.max_bounces = compared.max_bounces;
  const ImageEstimate expected = ImageEstimate::from_replicates(
      picture.width, picture.height, scattered(scene, "path_tracing", picture, compared.theirs));
  const auto ours = scattered(scene, "bidirectional_vpl", picture, compared.ours);
  const ImageTest test = compare(picture, ours, expected, 1), brighter = compare(picture, ours, expected, 1.01f);
  const ImageTestLevel &pixels = test.levels[0], &blocks = test.levels[1], &image = test.levels[2];
  MESSAGE(std::string(compared.scene) << ", bounces " << compared.max_bounces << ": mean " << test.mean_a << " beside "
                                      << test.mean_b << ", t of the image " << image.worst_t << ", with 1 % more "
                                      << brighter.levels[2].worst_t);
  INFO(to_text(test));
  if (compared.even) CHECK(pixels.failures == 0);
  CHECK(blocks.failures + image.failures == 0);
  if (compared.resolved) CHECK(brighter.levels[2].failures > 0);
}

}  // namespace

TEST_CASE("the image test passes beside path_tracing, and fails with a hundredth more of energy") {
  if (!full_run()) {
    check_energy({"builtin:cornell", 1, 32, 64});
    check_energy({"builtin:room", 4, 16, 64});
    return;
  }
  for (const int bounces : {1, 4, -1}) {
    for (const char* scene : {"builtin:cornell", "builtin:cornell-glossy", "builtin:spheres", "builtin:atrium"})
      check_energy({scene, bounces, 64, 256});
    check_energy({"builtin:room", bounces, 16, 64});
    // Light that path_tracing finds seldom: by way of the mirror, out of the fixture, through glass.
    check_energy({"builtin:cornell-mirror", bounces, 64, 1024, false});
    check_energy({"builtin:fixture:lamp=1", bounces, 32, 512, false, false});
    check_energy({"builtin:caustic", bounces, 32, 512, false, false});
  }
}
