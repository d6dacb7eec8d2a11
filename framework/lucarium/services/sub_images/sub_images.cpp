// SPDX-License-Identifier: Apache-2.0
#include "lucarium/services/sub_images/sub_images.h"

#include <algorithm>
#include <bit>

namespace lucarium {
namespace {

uint32_t divide_up(uint32_t a, uint32_t b) { return (a + b - 1) / b; }

}  // namespace

SubImages::SubImages(uint32_t width, uint32_t height, uint32_t stride)
    : width_(width), height_(height), stride_(stride) {}

uint32_t SubImages::stride_for(uint32_t width, uint32_t height, uint32_t pixels) {
  uint32_t stride = 1;
  while (uint64_t{divide_up(width, stride)} * divide_up(height, stride) > pixels) stride *= 2;
  return stride;
}

uint32_t SubImages::stride_within(uint32_t width, uint32_t height, uint32_t wanted) {
  return std::max(1u, std::min({width, height, wanted}));
}

uint32_t SubImages::capacity() const { return divide_up(width_, stride_) * divide_up(height_, stride_); }

SubImage SubImages::from(uint32_t offset_x, uint32_t offset_y) const {
  SubImage sub{};
  sub.offset_x = offset_x;
  sub.offset_y = offset_y;
  sub.stride = stride_;
  sub.width = offset_x < width_ ? divide_up(width_ - offset_x, stride_) : 0;
  sub.height = offset_y < height_ ? divide_up(height_ - offset_y, stride_) : 0;
  sub.image_width = width_;
  return sub;
}

SubImage SubImages::at(uint32_t index) const {
  if (!std::has_single_bit(stride_)) return lattice(index);
  uint32_t x = 0, y = 0;
  for (uint32_t half = stride_ / 2; half > 0; half /= 2, index /= 4) {
    const uint32_t corner = index % 4;
    x += half * (corner == 1 || corner == 2);
    y += half * (corner == 1 || corner == 3);
  }
  return from(x, y);
}

SubImage SubImages::lattice(uint32_t frame) const {
  const uint32_t shift = frame * (2 * stride_ - 1) % count();  // without a common factor: a permutation
  return from(shift % stride_, shift / stride_);
}

SubImage SubImages::whole() const { return {0, 0, 1, width_, height_, width_, 0, 0}; }

}  // namespace lucarium
