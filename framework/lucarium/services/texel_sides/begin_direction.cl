// SPDX-License-Identifier: Apache-2.0
// A direction's bundle image and the ends of its rays.
#include "lucarium/environment.clh"
#include "lucarium/shared/layered_raster.h"

// Environment maps as light sources (Hermes et al. 2010, section 5.1): nothing but the ends of rays has to know them.
// ends: radiance that enters the scene along omega (out of -omega), and along -omega; all rays of a bundle have it.
// Black unless emitted light is exchanged.
__kernel void begin_direction(LUCARIUM_SCENE_PARAMETERS LayeredView view, float4 omega, uint emission,
                              __global LayeredView* restrict views, __global float4* restrict ends) {
  LUCARIUM_SCENE_BIND(scene);
  views[0] = view;
  ends[0] = emission ? (float4)(environment_radiance(&scene, -omega.xyz), 0.0f) : (float4)(0.0f);
  ends[1] = emission ? (float4)(environment_radiance(&scene, omega.xyz), 0.0f) : (float4)(0.0f);
}
