// SPDX-License-Identifier: Apache-2.0
// Half floats, and pictures as the viewer sends them.
#include "lucarium/view/picture_code.h"

#include <doctest/doctest.h>

#include <bit>
#include <cmath>
#include <random>

#include "lucarium/base/error.h"
#include "lucarium/base/json.h"

using namespace lucarium;

TEST_CASE("half_bits gives every half float back, and the nearest one of what lies between, ties to even") {
  for (uint32_t bits = 0; bits < 0x10000; ++bits) {
    const float value = half_value(static_cast<uint16_t>(bits));
    if (std::isnan(value)) {
      CHECK(std::isnan(half_value(half_bits(value))));
    } else {
      CHECK(half_bits(value) == bits);
    }
  }
  for (uint16_t bits = 0; bits < 0x7bff; ++bits) {
    const float low = half_value(bits), high = half_value(static_cast<uint16_t>(bits + 1)),
                middle = 0.5f * (low + high);
    CHECK(half_bits(middle) == (bits % 2 == 0 ? bits : bits + 1));
    CHECK(half_bits(std::nextafter(middle, 0.0f)) == bits);
    CHECK(half_bits(std::nextafter(middle, 1e9f)) == bits + 1);
  }
  CHECK(half_bits(65519.0f) == 0x7bff);
  CHECK(half_bits(65520.0f) == 0x7c00);
  CHECK(half_bits(-INFINITY) == 0xfc00);
}

TEST_CASE("a picture comes back with 11 bits of every value, whatever its brightness") {
  std::mt19937 random(7);
  std::uniform_real_distribution<float> exponent(-20, 0), sign(0, 1);
  for (const float brightness : {1e-30f, 1e-6f, 1.0f, 3e5f, 1e30f}) {
    CAPTURE(brightness);
    constexpr uint32_t width = 31, height = 17;
    std::vector<float> rgb(3 * width * height);
    for (float& value : rgb) value = brightness * std::exp2(exponent(random)) * (sign(random) < 0.01f ? -1.0f : 1.0f);
    rgb[5] = 0;
    rgb[6] = NAN;
    rgb[7] = INFINITY;
    const ViewPicture picture = decode_view_picture(encode_view_picture({{"picture", 3}}, width, height, rgb));
    CHECK(picture.width == width);
    CHECK(picture.height == height);
    CHECK(nlohmann::json::parse(picture.header).at("picture") == 3);
    REQUIRE(picture.rgb.size() == rgb.size());
    CHECK(picture.rgb[5] == 0.0f);
    CHECK(std::isnan(picture.rgb[6]));
    CHECK(std::isinf(picture.rgb[7]));
    float worst = 0;
    for (size_t i = 8; i < rgb.size(); ++i) worst = std::max(worst, std::abs(picture.rgb[i] / rgb[i] - 1));
    CHECK(worst <= 0x1p-11f);
    CHECK(worst > 0x1p-13f);
  }
}

TEST_CASE("a black picture stays black, and damaged ones are refused") {
  const std::string data = encode_view_picture(nlohmann::ordered_json::object(), 4, 2, std::vector<float>(24, 0.0f));
  for (const float value : decode_view_picture(data).rgb) CHECK(value == 0.0f);
  for (size_t length = 0; length < data.size(); ++length)
    CHECK_THROWS_AS(decode_view_picture(std::string_view(data).substr(0, length)), Error);
}
