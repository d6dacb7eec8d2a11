// SPDX-License-Identifier: Apache-2.0
// Radiance that enters the scene along omega (from where -omega points), and along -omega: all rays of a bundle have it.
#include "lucarium/environment.clh"

__kernel void make_ends(LUCARIUM_SCENE_PARAMETERS float4 omega, uint emission, __global float4* restrict ends) {
  LUCARIUM_SCENE_BIND(scene);
  ends[0] = emission ? (float4)(environment_radiance(&scene, -omega.xyz), 0.0f) : (float4)(0.0f);
  ends[1] = emission ? (float4)(environment_radiance(&scene, omega.xyz), 0.0f) : (float4)(0.0f);
}
