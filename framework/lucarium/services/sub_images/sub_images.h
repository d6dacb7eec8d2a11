// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <cstdint>

#include "lucarium/shared/sub_image.h"

namespace lucarium {

/// stride × stride interleaved sub-images of an image, each every stride-th pixel of every stride-th row; together they
/// hold each pixel once (interleaved sampling: Keller and Heidrich 2001). For techniques whose iterations compute a
/// part of the picture, or that compute some pixels and interpolate the others. Kernels find the pixels with
/// sub_image.clh.
class SubImages {
 public:
  SubImages() = default;
  SubImages(uint32_t width, uint32_t height, uint32_t stride);
  /// The least power of two at which no sub-image has more than `pixels`.
  static uint32_t stride_for(uint32_t width, uint32_t height, uint32_t pixels);
  /// A wanted stride, no larger than either side: none of the sub-images is empty. For pixels that are interpolated
  /// from one of them, which have no neighbour in an empty one.
  static uint32_t stride_within(uint32_t width, uint32_t height, uint32_t wanted);

  uint32_t stride() const { return stride_; }
  uint32_t count() const { return stride_ * stride_; }
  /// Pixels of the largest one.
  uint32_t capacity() const;

  /// The sub-images in an order that refines evenly, where the stride is a power of two: the corners of squares, then
  /// their middles, and so on. Else as lattice(). Some are empty in images smaller than the stride.
  SubImage at(uint32_t index) const;
  /// The sub-images in an order in which successive ones lie apart, over and over: for means over frames in which the
  /// others are interpolated, which then show no lattice.
  SubImage lattice(uint32_t frame) const;
  /// The image as one.
  SubImage whole() const;

  /// While sub-images come in the order of at(): pixel x, y itself where reached(pixel), else the corner of the
  /// smallest square around it that was reached, or that of the largest.
  template <class Reached>
  size_t nearest_reached(uint32_t x, uint32_t y, const Reached& reached) const {
    size_t source = size_t{y} * width_ + x;
    for (uint32_t s = 2; s <= stride_ && !reached(source); s *= 2) source = size_t{y / s * s} * width_ + x / s * s;
    return source;
  }

 private:
  SubImage from(uint32_t offset_x, uint32_t offset_y) const;
  uint32_t width_ = 0, height_ = 0, stride_ = 1;
};

}  // namespace lucarium
