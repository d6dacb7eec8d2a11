// SPDX-License-Identifier: Apache-2.0
// The camera and the frame's settings, as kernels see them.
#ifndef LUCARIUM_SHARED_CAMERA_H
#define LUCARIUM_SHARED_CAMERA_H
#include "lucarium/shared/dialect.h"

// Perspective and orthographic in one form: with film coordinates sx, sy in [-1, 1] (x right, y up)
//   origin(sx, sy)    = origin + sx · origin_dx + sy · origin_dy
//   direction(sx, sy) = normalize(direction + sx · direction_dx + sy · direction_dy)      (w unused, 0)
LUCARIUM_STRUCT_BEGIN(Camera)
float4 origin;
float4 origin_dx;
float4 origin_dy;
float4 direction;
float4 direction_dx;
float4 direction_dy;
LUCARIUM_STRUCT_END(Camera, 96)

// How a pixel is sampled: 0 box jitter over the pixel, 1 its centre, n ≥ 2 a regular n×n grid of centres.
#define LUCARIUM_PIXEL_JITTER 0u
#define LUCARIUM_PIXEL_CENTRE 1u

LUCARIUM_STRUCT_BEGIN(Frame)
Camera camera;
uint width;           // pixels
uint height;          // pixels
uint pixel_sampling;  // see above
uint seed;
int max_bounces;  // -1: unlimited
uint pad0;
uint pad1;
uint pad2;
LUCARIUM_STRUCT_END(Frame, 128)

// How many rays a work-item of generate_camera_rays makes.
#define LUCARIUM_CAMERA_RAYS_EACH 8u

#endif
