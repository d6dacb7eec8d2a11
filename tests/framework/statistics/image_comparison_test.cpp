// SPDX-License-Identifier: Apache-2.0
// The image test on made noise: what is equal passes, what is not fails, p-values are uniform.
#include "lucarium/statistics/image_comparison.h"

#include <doctest/doctest.h>

#include <cmath>
#include <random>

#include "lucarium/base/error.h"
#include "tolerance.h"

using namespace lucarium;

namespace {

constexpr uint32_t kWidth = 96, kHeight = 52;  // blocks at the lower border are cut

/// R noisy images of a slope with values of 0.5 to 1.5, some noise per pixel, times `scale`.
std::vector<std::vector<float>> noisy_images(uint32_t seed, double scale, uint32_t replicates = 16,
                                             double noise = 0.2) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal(0, noise);
  std::vector<std::vector<float>> images(replicates);
  for (auto& image : images)
    for (uint32_t y = 0; y < kHeight; ++y)
      for (uint32_t i = 0; i < kWidth * 3; ++i)
        image.push_back(static_cast<float>(scale * (0.5 + double(y) / kHeight + normal(random))));
  return images;
}

ImageEstimate estimate(uint32_t seed, double scale = 1, uint32_t replicates = 16, double noise = 0.2) {
  return ImageEstimate::from_replicates(kWidth, kHeight, noisy_images(seed, scale, replicates, noise));
}

uint64_t failures(const ImageTest& test, size_t level) { return test.levels.at(level).failures; }

}  // namespace

TEST_CASE("image test: images that differ by noise alone are the same, and their p-values are uniform") {
  int passed = 0;
  for (uint32_t pair = 0; pair < 10; ++pair) {
    const ImageTest test = test_images(estimate(2 * pair), estimate(2 * pair + 1, 1, 24));
    INFO(to_text(test));
    passed += test.passed;
    CHECK(test.levels[0].tests == kWidth * kHeight * 3);
    CHECK(test.levels[1].tests == 12 * 7 * 3);
    CHECK(test.levels[2].tests == 3);
    CHECK(test.levels[0].ks_p > 1e-3);
    CHECK(test.levels[1].ks_p > 1e-3);
  }
  CHECK(passed == 10);
}

TEST_CASE("image test: one per cent of energy, a wrong block and a wrong pixel are found where they should be") {
  const ImageTest energy = test_images(estimate(1), estimate(2, 1.01));
  INFO(to_text(energy));
  CHECK_FALSE(energy.passed);
  CHECK(failures(energy, 2) == 3);
  CHECK(test_images(estimate(1), estimate(2, 1.01), {.tolerance = 0.02}).passed);

  // 5 % in 8 x 8 pixels: too little for a pixel and for the image.
  auto images = noisy_images(2, 1);
  for (auto& image : images)
    for (uint32_t y = 16; y < 24; ++y)
      for (uint32_t x = 40; x < 48; ++x) image[(y * kWidth + x) * 3 + 1] *= 1.1f;
  const ImageTest block = test_images(estimate(1), ImageEstimate::from_replicates(kWidth, kHeight, images));
  INFO(to_text(block));
  CHECK_FALSE(block.passed);
  CHECK(failures(block, 1) == 1);
  CHECK(block.levels[1].worst_x == 5);
  CHECK(block.levels[1].worst_y == 2);
  CHECK(block.levels[1].worst_channel == 1);
  CHECK(block.levels[1].worst_t < 0);

  images = noisy_images(2, 1);
  for (auto& image : images) image[(7 * kWidth + 11) * 3 + 2] += 1;
  const ImageTest pixel = test_images(estimate(1), ImageEstimate::from_replicates(kWidth, kHeight, images));
  CHECK(failures(pixel, 0) == 1);
  CHECK(pixel.levels[0].worst_x == 11);
  CHECK(pixel.levels[0].worst_y == 7);
}

TEST_CASE("image test: values without noise are compared, not tested") {
  const auto constant = [](float value) {
    return ImageEstimate::from_replicates(4, 4, {std::vector<float>(48, value), std::vector<float>(48, value)});
  };
  const ImageTest same = test_images(constant(2), constant(2));
  CHECK(same.passed);
  CHECK(same.levels[0].constant == 48);
  CHECK(same.levels[0].tests == 0);
  CHECK(test_images(constant(0), constant(0)).passed);
  CHECK(test_images(constant(2), constant(2.00002f)).passed);
  CHECK_FALSE(test_images(constant(2), constant(2.02f)).passed);
  CHECK_FALSE(test_images(constant(0), constant(0.1f)).passed);
}

TEST_CASE("image test: mean and variance in a film serve as well as the replicates") {
  const auto film_of = [](const ImageEstimate& e) {
    Film film(kWidth, kHeight);
    film.layer("direct", {"R", "G", "B"}, true).pixels.assign(e.mean.begin(), e.mean.end());
    film.layer("Variance").pixels.assign(e.variance.begin(), e.variance.end());
    film.metadata["variance_dof"] = "15";
    return ImageEstimate::from_film(film, "film");
  };
  const ImageEstimate a = estimate(5), b = estimate(6), wrong = estimate(6, 1.01);
  const ImageTest by_replicates = test_images(a, b), by_film = test_images(film_of(a), film_of(b));
  CHECK(by_film.passed);
  CHECK(by_film.levels[0].worst_t == test::relative(by_replicates.levels[0].worst_t, 1e-4));
  CHECK(by_film.levels[2].ks_statistic == test::relative(by_replicates.levels[2].ks_statistic, 0.5));
  CHECK_FALSE(test_images(film_of(a), film_of(wrong)).passed);
}

TEST_CASE("image test: what cannot be compared is an error") {
  CHECK_THROWS_AS(ImageEstimate::from_replicates(kWidth, kHeight, noisy_images(1, 1, 1)), Error);
  auto images = noisy_images(1, 1, 2);
  images[1].pop_back();
  CHECK_THROWS_AS(ImageEstimate::from_replicates(kWidth, kHeight, images), Error);
  images = noisy_images(1, 1, 2);
  images[1][5] = NAN;
  CHECK_THROWS_AS(ImageEstimate::from_replicates(kWidth, kHeight, images), Error);
  CHECK_THROWS_AS(ImageEstimate::from_film(Film(2, 2), "film"), Error);
  CHECK_THROWS_AS(test_images(estimate(1), ImageEstimate::from_replicates(1, 1, {{1, 1, 1}, {1, 2, 1}})), Error);
}

TEST_CASE("image test: Kolmogorov's distribution") {
  // Critical values of the limit: P(K > 1.3581) = .05, P(K > 1.6276) = .01.
  CHECK(kolmogorov_tail(1.3581 / 1000, 1000000) == test::relative(0.05, 0.01));
  CHECK(kolmogorov_tail(1.6276 / 1000, 1000000) == test::relative(0.01, 0.01));
  CHECK(kolmogorov_tail(0, 10) == 1);
  CHECK(kolmogorov_tail(1, 10) < 1e-6);
}
