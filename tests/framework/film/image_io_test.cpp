// SPDX-License-Identifier: Apache-2.0
#include "lucarium/film/image_io.h"

#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <string>
#include <tuple>
#include <vector>

#include "file_size_limit.h"
#include "hostile_images.h"
#include "lucarium/base/error.h"
#include "lucarium/base/files/atomic_file.h"
#include "test_support.h"
#include "tolerance.h"

using namespace lucarium;

namespace {

Film example_film() {
  Film film(5, 3);
  FilmLayer& direct = film.layer("direct", {"R", "G", "B"}, true);
  FilmLayer& indirect = film.layer("indirect", {"R", "G", "B"}, true);
  FilmLayer& normal = film.layer("N", {"X", "Y", "Z"});
  for (size_t i = 0; i < direct.pixels.size(); ++i) {
    direct.pixels[i] = static_cast<float>(i) * 0.37f;
    indirect.pixels[i] = 1e5f / static_cast<float>(i + 1);
    normal.pixels[i] = -0.5f + static_cast<float>(i) * 0.01f;
  }
  film.metadata = {{"technique", "path_tracing"}, {"seconds", "1.5"}};
  return film;
}

}  // namespace

TEST_CASE("an EXR keeps layers, sum, names and metadata bit for bit") {
  const test::TemporaryFolder folder;
  const Film film = example_film();
  write_exr(folder.path() / "a.exr", film);
  const Film again = read_image(folder.path() / "a.exr");
  CHECK(again.width() == 5);
  CHECK(again.height() == 3);
  for (const FilmLayer& layer : film.layers()) {
    REQUIRE(again.find(layer.name));
    CHECK(again.find(layer.name)->channels == layer.channels);
    CHECK(again.find(layer.name)->pixels == layer.pixels);
    CHECK(again.find(layer.name)->additive == layer.additive);
  }
  CHECK(again.image() == film.image());
  CHECK(again.metadata == film.metadata);
}

TEST_CASE("half floats keep eleven bits, and what does not fit becomes infinite") {
  const test::TemporaryFolder folder;
  Film film(2, 1);
  FilmLayer& direct = film.layer("direct", {"R", "G", "B"}, true);
  direct.pixels = {0.1f, 2048, 65504, 70000, 0, 1};
  write_exr(folder.path() / "a.exr", film, {.half = true});
  const std::vector<float> again = read_image(folder.path() / "a.exr").image();
  CHECK(again[0] == test::relative(0.1, 5e-4));
  CHECK(again[0] != 0.1f);
  CHECK(again[1] == 2048);
  CHECK(again[2] == 65504);
  CHECK(std::isinf(again[3]));
}

TEST_CASE("a picture brightens by its exposure in stops, through the sRGB curve") {
  const test::TemporaryFolder folder;
  const std::vector<float> grey(2 * 2 * 3, 0.214041f);  // sRGB .5
  write_png(folder.path() / "a.png", 2, 2, grey);
  write_png(folder.path() / "b.png", 2, 2, grey, 1.0f);
  CHECK(read_image(folder.path() / "a.png").image()[0] == test::relative(grey[0], .01));
  CHECK(read_image(folder.path() / "b.png").image()[0] == test::relative(2 * grey[0], .01));
  CHECK(encode_png(2, 2, grey, 0).substr(1, 3) == "PNG");
}

TEST_CASE("bad pixels are found where they are") {
  Film film = example_film();
  CHECK(film.count_bad_pixels().total() == 0);  // normals may be negative
  film.layer("indirect").pixels[3 * 7 + 1] = std::numeric_limits<float>::quiet_NaN();
  film.layer("direct").pixels[3 * 8] = -1;
  const BadPixels bad = film.count_bad_pixels();
  CHECK(bad.nan == 1);
  CHECK(bad.negative == 1);
  CHECK(bad.first_layer == "direct");
  CHECK(bad.first_x == 3);
  CHECK(bad.first_y == 1);
}

TEST_CASE("the image is the sum of the additive layers, at every pixel of a large one") {
  Film film(67, 41);
  const std::vector<std::string> rgb = {"R", "G", "B"};
  std::vector<float> expected(film.pixel_count() * 3);
  for (const auto& [name, factor, additive] : {std::tuple("a", 1.f, true), {"b", 0.25f, true}, {"c", 8.f, false}}) {
    std::vector<float>& pixels = film.layer(name, rgb, additive).pixels;
    for (size_t i = 0; i < pixels.size(); ++i) {
      pixels[i] = factor * static_cast<float>(i);
      if (additive) expected[i] += pixels[i];
    }
  }
  CHECK(film.image() == expected);
}

TEST_CASE("one bad value of any kind is found, and zeros of either sign, the largest and the least number are none") {
  constexpr float largest = std::numeric_limits<float>::max(), infinite = std::numeric_limits<float>::infinity();
  const auto count = [](float value, bool additive) {
    Film film(5, 3);
    film.layer("layer", {"R", "G", "B"}, additive).pixels[38] = value;
    return film.count_bad_pixels();
  };
  for (const float good : {0.f, -0.f, largest, std::numeric_limits<float>::denorm_min()})
    for (const bool additive : {false, true}) CHECK(count(good, additive).total() == 0);
  for (const bool additive : {false, true}) {
    CHECK(count(std::numeric_limits<float>::quiet_NaN(), additive).nan == 1);
    CHECK(count(-std::numeric_limits<float>::quiet_NaN(), additive).nan == 1);
    CHECK(count(infinite, additive).infinite == 1);
    CHECK(count(-infinite, additive).infinite == 1);
    for (const float negative : {-largest, -std::numeric_limits<float>::denorm_min()})
      CHECK(count(negative, additive).negative == (additive ? 1 : 0));
  }
}

TEST_CASE("unwritable and unreadable files are one clear error, and leave nothing behind") {
  const test::TemporaryFolder folder;
  CHECK_THROWS_AS(write_exr(folder.path() / "missing" / "a.exr", example_film()), Error);
  CHECK_THROWS_AS(read_image(folder.path() / "none.exr"), Error);
  write_file_atomically(folder.path() / "broken.exr", "not an image");
  CHECK_THROWS_AS(read_image(folder.path() / "broken.exr"), Error);
  CHECK(std::distance(std::filesystem::directory_iterator(folder.path()), {}) == 1);
}

TEST_CASE("a full disk replaced a good picture by an empty one, without an error") {
  const test::TemporaryFolder folder;
  const std::filesystem::path png = folder.path() / "a.png", exr = folder.path() / "a.exr";
  const std::vector<float> grey(2 * 2 * 3, 0.2f);
  write_png(png, 2, 2, grey);
  write_exr(exr, example_film());
  const std::string png_before = read_file(png), exr_before = read_file(exr);
  for (const rlim_t room : {0, 40}) {  // 0: nothing can be written, 40: only the end is missing
    const test::FileSizeLimit full(room);
    CHECK_THROWS_WITH_AS(write_png(png, 2, 2, grey), doctest::Contains("a.png: File too large"), Error);
    CHECK_THROWS_WITH_AS(write_exr(exr, example_film()), doctest::Contains("a.exr: File too large"), Error);
  }
  CHECK(read_file(png) == png_before);
  CHECK(read_file(exr) == exr_before);
  CHECK(std::distance(std::filesystem::directory_iterator(folder.path()), {}) == 2);
}

TEST_CASE("a JPEG of a few hundred bytes that states billions of pixels took gigabytes when it was opened") {
  const test::TemporaryFolder folder;
  const std::filesystem::path file = folder.path() / "bomb.jpg";
  write_file_atomically(file, test::jpeg_that_states(65500, 65500, true));
  CHECK_THROWS_WITH_AS(read_image(file), doctest::Contains("bomb.jpg: damaged image: it is cut off"), Error);
  write_file_atomically(file, test::jpeg_that_states(8, 8, true));
  CHECK(read_image(file).width() == 8);
}

TEST_CASE("an EXR with tiff:RowsPerStrip 0 ended the program with a division by zero") {
  const test::TemporaryFolder folder;
  write_file_atomically(folder.path() / "a.exr", test::exr_without_rows_per_strip(3, 200));
  const Film film = read_image(folder.path() / "a.exr");
  CHECK(film.height() == 200);
  CHECK(film.image() == std::vector<float>(3 * 3 * 200, 0.5f));
}
