// SPDX-License-Identifier: Apache-2.0
#include "lucarium/services/sub_images/sub_images.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <vector>

using namespace lucarium;

namespace {

std::vector<uint32_t> pixels_of(const SubImage& sub) {
  std::vector<uint32_t> pixels;
  for (uint32_t y = 0; y < sub.height; ++y)
    for (uint32_t x = 0; x < sub.width; ++x)
      pixels.push_back((sub.offset_y + y * sub.stride) * sub.image_width + sub.offset_x + x * sub.stride);
  return pixels;
}

}  // namespace

TEST_CASE("sub-images hold every pixel once, in either order") {
  for (const uint32_t stride : {1u, 2u, 3u, 4u, 8u}) {
    const SubImages images(13, 7, stride);
    for (const bool refining : {true, false}) {
      std::vector<uint32_t> count(13 * 7);
      for (uint32_t i = 0; i < images.count(); ++i) {
        const SubImage sub = refining ? images.at(i) : images.lattice(i + 5);
        CHECK(sub.width * sub.height <= images.capacity());
        for (const uint32_t p : pixels_of(sub)) ++count.at(p);
      }
      CHECK(std::count(count.begin(), count.end(), 1) == 13 * 7);
    }
  }
}

TEST_CASE("the order refines: after 4^k sub-images of a square grid the reached pixels are a grid of half the step") {
  const SubImages images(16, 16, 8);
  std::vector<bool> reached(256);
  for (uint32_t i = 0; i < images.count(); ++i) {
    for (const uint32_t p : pixels_of(images.at(i))) reached[p] = true;
    if (i + 1 != 4 && i + 1 != 16 && i + 1 != 64) continue;
    const uint32_t step = i + 1 == 4 ? 4 : i + 1 == 16 ? 2 : 1;
    for (uint32_t y = 0; y < 16; ++y)
      for (uint32_t x = 0; x < 16; ++x) CHECK(reached[16 * y + x] == (x % step == 0 && y % step == 0));
  }
}

TEST_CASE("a pixel that is not reached shows the corner of the smallest square around it that was") {
  const SubImages images(8, 8, 4);
  const auto first_two = [](size_t p) { return p % 8 % 4 == 0 && p / 8 % 4 == 0; };  // of at(0) alone
  CHECK(images.nearest_reached(5, 6, first_two) == 4 * 8 + 4);
  CHECK(images.nearest_reached(4, 4, first_two) == 4 * 8 + 4);
  CHECK(images.nearest_reached(5, 7, [](size_t p) { return p == 6 * 8 + 4; }) == 6 * 8 + 4);
  CHECK(images.nearest_reached(5, 7, [](size_t) { return false; }) == 4 * 8 + 4);
}

TEST_CASE("the stride is the least power of two that makes sub-images small enough") {
  CHECK(SubImages::stride_for(100, 10, 1000) == 1);
  CHECK(SubImages::stride_for(100, 10, 999) == 2);
  CHECK(SubImages::stride_for(100, 10, 249) == 4);
}

TEST_CASE("a step larger than the image leaves no sub-image empty: pixels have neighbours within the image") {
  struct Size {
    uint32_t width, height;
  };
  for (const auto& [width, height] : {Size{5, 7}, Size{64, 3}, Size{1, 1}, Size{24, 24}}) {
    CAPTURE(width);
    const SubImages images(width, height, SubImages::stride_within(width, height, 8));
    CHECK(images.stride() == std::min({width, height, 8u}));
    for (uint32_t frame = 0; frame < images.count(); ++frame) {
      const SubImage sub = images.lattice(frame);
      CHECK((sub.width > 0 && sub.height > 0));
      CHECK((sub.offset_x < width && sub.offset_y < height));
    }
  }
}
