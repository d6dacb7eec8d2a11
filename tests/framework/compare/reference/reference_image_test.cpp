// SPDX-License-Identifier: Apache-2.0
// Merging of rounds into a reference, and its estimate of its own error, on noise of known variance.
#include "lucarium/compare/reference/reference_image.h"

#include <doctest/doctest.h>

#include <cmath>
#include <random>

#include "lucarium/base/error.h"
#include "lucarium/film/image_io.h"
#include "test_support.h"
#include "tolerance.h"

using namespace lucarium;

namespace {

constexpr uint32_t width = 64, height = 48;
constexpr double truth = 2.0, sample_variance = 0.36;

/// The mean of `samples` samples: truth plus normal noise of variance sample_variance / samples, half of the light in
/// each of two layers, with the variance layer that says so.
Film make_round(uint64_t samples, std::mt19937& random) {
  Film film(width, height);
  std::normal_distribution<float> noise(0.f,
                                        static_cast<float>(std::sqrt(sample_variance / static_cast<double>(samples))));
  for (float& value : film.layer("direct", {"R", "G", "B"}, true).pixels)
    value = static_cast<float>(truth / 2) + noise(random);
  for (float& value : film.layer("indirect", {"R", "G", "B"}, true).pixels) value = truth / 2;
  for (float& value : film.layer("Variance").pixels)
    value = static_cast<float>(sample_variance / static_cast<double>(samples));
  film.metadata["variance_dof"] = "15";
  return film;
}

double mean_squared_error(const Film& film) {
  double sum = 0;
  const std::vector<float> image = film.image();
  for (const float value : image) sum += (value - truth) * (value - truth);
  return sum / static_cast<double>(image.size());
}

}  // namespace

TEST_CASE("rounds merge by their samples, and halves give the error of the whole, also when they differ in size") {
  std::mt19937 random(7);
  for (const auto& rounds : {std::vector<std::pair<uint64_t, size_t>>{{16, 0}, {16, 1}, {32, 0}, {32, 1}},
                             std::vector<std::pair<uint64_t, size_t>>{{16, 0}, {16, 1}, {128, 0}, {5, 1}}}) {
    ReferenceImage image(width, height);
    uint64_t total = 0;
    for (const auto& [samples, half] : rounds) {
      image.add(make_round(samples, random), samples, half);
      total += samples;
    }
    CHECK(image.samples() == total);
    CHECK(image.rounds() == rounds.size());
    REQUIRE(image.error_known());
    // 9216 values: the mean of their squares has a relative standard deviation of √(2/9216) = 0.0147.
    const double expected = sample_variance / static_cast<double>(total);
    CHECK(mean_squared_error(image.film()) == test::relative(expected, 5 * 0.0147));
    CHECK(image.error().mse == test::relative(expected, 5 * 0.0147));
    CHECK(image.error().relmse == test::relative(expected / (truth * truth * 1.01), 5 * 0.0147));
    CHECK(image.film().find("Variance")->pixels[100] == test::relative(expected, 1e-5));
    CHECK(image.film().metadata.at("samples") == std::to_string(total));
  }
}

TEST_CASE("the whole is the weighted mean of the halves") {
  std::mt19937 random(8);
  ReferenceImage image(width, height);
  image.add(make_round(48, random), 48, 0);
  CHECK_FALSE(image.error_known());
  image.add(make_round(16, random), 16, 1);
  const std::vector<float> whole = image.film().image();
  for (const size_t i : {size_t{0}, size_t{777}, whole.size() - 1}) {
    const double a = image.film().find("HalfA")->pixels[i], b = image.film().find("HalfB")->pixels[i];
    CHECK(whole[i] == test::relative((48 * a + 16 * b) / 64, 1e-6));
  }
}

TEST_CASE("a reference goes on from its file") {
  const test::TemporaryFolder folder;
  std::mt19937 random(9);
  const Film first = make_round(16, random), second = make_round(16, random), third = make_round(32, random);
  ReferenceImage at_once(width, height), before(width, height);
  for (ReferenceImage* image : {&at_once, &before}) {
    image->add(first, 16, 0);
    image->add(second, 16, 1);
  }
  write_exr(folder.path() / "r.exr", before.film());
  ReferenceImage after(read_image(folder.path() / "r.exr"), "r.exr");
  at_once.add(third, 32, 0);
  after.add(third, 32, 0);
  CHECK(after.rounds() == 3);
  CHECK(after.samples(0) == 48);
  CHECK(after.film().image() == at_once.film().image());
  CHECK(after.error().mse == at_once.error().mse);
}

TEST_CASE("an image that is no reference is refused; one with a variance layer has an error nevertheless") {
  std::mt19937 random(10);
  const Film film = make_round(16, random);
  CHECK_THROWS_WITH_AS(ReferenceImage(film, "x.exr"), doctest::Contains("x.exr: not an image of lucarium reference"),
                       Error);
  ReferenceError error;
  CHECK(estimate_reference_error(film, error));
  CHECK(error.mse == test::relative(sample_variance / 16));
  // The noise of the denominators counts: the mean of 1 / r^2 is 1.7 % above 1 / truth^2.
  double relmse = 0;
  for (const float value : film.image()) relmse += sample_variance / 16 / (value * value + 0.01 * truth * truth);
  CHECK(error.relmse == test::relative(relmse / static_cast<double>(film.image().size()), 1e-4));
  Film bare(4, 4);
  bare.layer("direct", {"R", "G", "B"}, true);
  CHECK_FALSE(estimate_reference_error(bare, error));
  ReferenceImage image(width, height);
  CHECK_THROWS_AS(image.add(Film(3, 3), 1, 0), Error);
}

TEST_CASE("the halves agree unless one of them is wrong") {
  for (const bool wrong : {false, true}) {
    std::mt19937 random(12);
    ReferenceImage image(width, height);
    for (const size_t half : {0, 1}) {
      Film round = make_round(64, random);
      if (wrong && half == 1) {
        for (FilmLayer layer : round.layers()) {
          if (layer.additive)
            for (float& value : round.layer(layer.name, layer.channels, true).pixels) value *= 1.01f;
        }
      }
      image.add(round, 64, half);
    }
    CHECK(image.test_halves().passed == !wrong);
    CHECK(image.film().metadata.at("variance_dof") == "30");
  }
}
