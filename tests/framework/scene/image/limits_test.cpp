// SPDX-License-Identifier: Apache-2.0
// Images that ask for more than they hold: what they may cost, and that nothing is lost on the way.
#include <doctest/doctest.h>

#include <fstream>
#include <random>

#include "gltf_builder.h"
#include "hostile_images.h"
#include "lucarium/base/error.h"
#include "lucarium/base/files/atomic_file.h"
#include "lucarium/scene/image/environment_file.h"
#include "lucarium/scene/image/image_decode.h"
#include "scene_support.h"
#include "test_support.h"

using namespace lucarium;
using test::GltfBuilder;
using test::load;

namespace {

/// A PNG of noise, or of one colour where `seed` is 0.
std::string png_of(uint32_t width, uint32_t height, int channels, uint32_t seed) {
  OIIO::ImageSpec spec(static_cast<int>(width), static_cast<int>(height), channels, OIIO::TypeDesc::UINT8);
  spec.attribute("oiio:UnassociatedAlpha", 1);
  std::vector<uint8_t> pixels(size_t{width} * height * static_cast<size_t>(channels), 100);
  std::mt19937 random(seed);
  if (seed) std::generate(pixels.begin(), pixels.end(), [&] { return static_cast<uint8_t>(random() >> 8); });
  return test::encode_image("png", spec, OIIO::TypeDesc::UINT8, pixels.data());
}

std::span<const uint8_t> bytes_of(const std::string& text) {
  return {reinterpret_cast<const uint8_t*>(text.data()), text.size()};
}

/// A triangle with a material for each of the images.
GltfBuilder with_images(const std::vector<std::string>& images) {
  GltfBuilder builder = GltfBuilder::textured_triangle(images.at(0), "image/png");
  for (size_t i = 1; i < images.size(); ++i) {
    const int view = builder.add_view(images[i].data(), images[i].size());
    const int image = builder.append("images", {{"bufferView", view}, {"mimeType", "image/png"}});
    const int texture = builder.append("textures", {{"source", image}});
    const int material =
        builder.append("materials", {{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", texture}}}}}});
    auto primitive = builder.json["meshes"][0]["primitives"][0];
    primitive["material"] = material;
    builder.json["meshes"][0]["primitives"].push_back(primitive);
  }
  return builder;
}

/// Resident memory in KiB, "VmRSS:" now or "VmHWM:" at its peak.
long memory(const std::string& key) {
  std::ifstream status("/proc/self/status");
  for (std::string word; status >> word;) {
    long kib = 0;
    if (word == key && status >> kib) return kib;
  }
  return 0;
}

}  // namespace

TEST_CASE("--texture-size did not lower the memory in which an image is decoded") {
  constexpr uint32_t width = 8192, height = 4096;  // 128 MiB as RGBA
  const std::string png = png_of(width, height, 1, 0);
  ImportOptions options;
  options.max_texture_size = 64;
  std::ofstream("/proc/self/clear_refs") << 5;  // the peak begins here
  const long before = memory("VmRSS:");
  const DecodedImage decoded = decode_image(bytes_of(png), "it", options);
  const long grown = memory("VmHWM:") - before;
  CHECK(decoded.shrunk);
  CHECK(decoded.image.width == 64);
  CHECK(decoded.image.height == 32);
  CHECK(decoded.image.rgba[4 * 64 * 31] == 100);
#ifdef __SANITIZE_ADDRESS__
  MESSAGE("the sanitizer keeps freed memory: " << grown << " KiB, not judged");
#else
  CHECK(grown < 80 * 1024);
#endif
}

TEST_CASE("an image is halved row by row as it is halved whole, odd sizes too") {
  for (const auto& [width, height] : {std::pair(64u, 64u), {37u, 23u}, {1u, 13u}, {29u, 1u}, {5u, 200u}}) {
    const std::string png = png_of(width, height, 4, width);
    ImportOptions options;
    Image expected = decode_image(bytes_of(png), "it", options).image;
    for (uint32_t limit = 16; limit > 0; limit /= 4) {
      options.max_texture_size = limit;
      while (std::max(expected.width, expected.height) > limit) {
        const uint32_t w = std::max(1u, expected.width / 2), h = std::max(1u, expected.height / 2);
        std::vector<uint8_t> rgba;
        for (uint32_t i = 0; i < 4 * w * h; ++i) {
          const uint32_t x = i / 4 % w, y = i / 4 / w;
          const auto at = [&](uint32_t column, uint32_t row) {
            column = std::min(column, expected.width - 1), row = std::min(row, expected.height - 1);
            return uint32_t{expected.rgba[4 * (size_t{row} * expected.width + column) + i % 4]};
          };
          rgba.push_back(static_cast<uint8_t>(
              (at(2 * x, 2 * y) + at(2 * x + 1, 2 * y) + at(2 * x, 2 * y + 1) + at(2 * x + 1, 2 * y + 1) + 2) / 4));
        }
        expected.width = w, expected.height = h, expected.rgba = rgba;
      }
      const Image image = decode_image(bytes_of(png), "it", options).image;
      CHECK(image.width == expected.width);
      CHECK(image.height == expected.height);
      CHECK(image.rgba == expected.rgba);
      const ImageSize size = decoded_size(bytes_of(png), "it", options);
      CHECK(size.width == image.width);
      CHECK(size.height == image.height);
    }
  }
}

TEST_CASE("a progressive JPEG of a few hundred bytes and 65500 x 65500 pixels took gigabytes before it was refused") {
  for (const bool progressive : {true, false}) {
    GltfBuilder builder =
        GltfBuilder::textured_triangle(test::jpeg_that_states(65500, 65500, progressive), "image/jpeg");
    CHECK_THROWS_WITH_AS(load(builder), doctest::Contains("has 65500x65500 pixels, more than the 268435456"), Error);
    builder = GltfBuilder::textured_triangle(test::jpeg_that_states(16000, 16000, progressive), "image/jpeg");
    CHECK_THROWS_WITH_AS(load(builder), doctest::Contains("damaged JPEG: it is cut off"), Error);
    builder = GltfBuilder::textured_triangle(test::jpeg_that_states(8, 8, progressive), "image/jpeg");
    CHECK(load(builder).images.at(0).width == 8);
  }
}

TEST_CASE("textures that each are small enough took all memory together") {
  std::string damaged = png_of(64, 64, 3, 1);
  damaged[damaged.size() / 2] ^= 1;
  const GltfBuilder builder = with_images({damaged, png_of(64, 32, 3, 2), png_of(64, 64, 3, 3)});
  ImportOptions options;
  options.max_texture_bytes = 30 * 1024;  // 40 KiB are needed
  // It is refused before anything is decoded: nobody has seen that the first is damaged.
  CHECK_THROWS_WITH_AS(load(builder, options),
                       doctest::Contains("test.gltf: its textures need more than 30.0 KiB together, which is the "
                                         "maximum; scale them down with --texture-size 32"),
                       Error);
  options.max_texture_size = 32;
  CHECK_THROWS_WITH_AS(load(builder, options), doctest::Contains("damaged PNG: a checksum is wrong"), Error);
  const GltfBuilder good = with_images({png_of(64, 64, 3, 1), png_of(64, 32, 3, 2), png_of(64, 64, 3, 3)});
  CHECK(load(good, options).images.size() == 3);
}

TEST_CASE("textures of gigabytes were loaded without a word about the time and memory that they take") {
  const GltfBuilder builder = with_images({png_of(64, 64, 3, 1), png_of(64, 32, 3, 2), png_of(64, 64, 3, 3)});
  ImportOptions options;
  options.max_texture_bytes = 4 * 40 * 1024;  // 40 KiB are needed, a quarter
  CHECK(load(builder, options).warnings.empty());
  --options.max_texture_bytes;
  const std::vector<std::string> warnings = load(builder, options).warnings;
  REQUIRE(warnings.size() == 1);
  CHECK(warnings[0].find("its textures take 40.0 KiB together; --texture-size 32 takes less") != std::string::npos);
}

TEST_CASE("one image under several names was decoded and kept once for each") {
  const std::string same = png_of(16, 16, 3, 7);
  const Scene scene = load(with_images({same, png_of(16, 16, 3, 8), same, same}));
  REQUIRE(scene.materials.size() == 4);
  CHECK(scene.images.size() == 2);
  CHECK(scene.textures.size() == 2);
  const int first = scene.materials[0].base_color_texture.texture;
  CHECK(scene.materials[1].base_color_texture.texture != first);
  CHECK(scene.materials[2].base_color_texture.texture == first);
  CHECK(scene.materials[3].base_color_texture.texture == first);
}

TEST_CASE("an environment with tiff:RowsPerStrip 0 ended the program with a division by zero") {
  const test::TemporaryFolder folder;
  write_file_atomically(folder.path() / "a.exr", test::exr_without_rows_per_strip(8, 100));
  const Environment environment = load_environment(folder.path() / "a.exr");
  CHECK(environment.radiance == std::vector<glm::vec3>(800, glm::vec3(0.5f)));
}

TEST_CASE("an environment is read in bands: tiles, many rows, and colours that are not the first channels") {
  const test::TemporaryFolder folder;
  const std::filesystem::path file = folder.path() / "a.exr";
  constexpr int width = 2000, height = 700;  // more than a band of 16 MiB
  std::vector<float> values(size_t{4} * width * height);
  for (size_t i = 0; i < values.size(); ++i) values[i] = static_cast<float>(i % 5003);
  for (const int tile : {0, 64}) {
    OIIO::ImageSpec spec(width, height, 4, OIIO::TypeDesc::FLOAT);
    spec.channelnames = {"Z", "R", "G", "B"};
    spec.tile_width = spec.tile_height = tile;
    if (tile) spec.tile_depth = 1;
    spec.y = spec.full_y = tile ? 0 : -40;
    write_file_atomically(file, test::encode_image("openexr", spec, OIIO::TypeDesc::FLOAT, values.data()));
    const Environment environment = load_environment(file);
    REQUIRE(environment.radiance.size() == size_t{width} * height);
    size_t wrong = 0;
    for (size_t i = 0; i < environment.radiance.size(); ++i) {
      wrong += environment.radiance[i] != glm::vec3(values[4 * i + 1], values[4 * i + 2], values[4 * i + 3]);
    }
    CHECK(wrong == 0);
  }
}
