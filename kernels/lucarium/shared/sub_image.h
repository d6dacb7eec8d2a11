// SPDX-License-Identifier: Apache-2.0
#ifndef LUCARIUM_SHARED_SUB_IMAGE_H
#define LUCARIUM_SHARED_SUB_IMAGE_H
#include "lucarium/shared/dialect.h"

// Every stride-th pixel of every stride-th row of an image.
LUCARIUM_STRUCT_BEGIN(SubImage)
uint offset_x, offset_y;  // its first pixel
uint stride;
uint width, height;  // pixels of the sub-image
uint image_width;    // pixels per row of the image
uint pad0, pad1;
LUCARIUM_STRUCT_END(SubImage, 32)

#endif
