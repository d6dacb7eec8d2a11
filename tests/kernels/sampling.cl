// SPDX-License-Identifier: Apache-2.0
#include "lucarium/random.clh"
#include "lucarium/sobol.clh"
#include "lucarium/warp.clh"

// Points 0 .. count of one block.
kernel void sampler_points(const uint seed, const uint block, const uint mode, const uint first, const uint count,
                           global float4* points) {
  const uint i = get_global_id(0);
  if (i >= count) return;
  const Sampler sampler = {seed, first + i, mode};
  points[i] = sampler_block(&sampler, block);
}

// The same sample of the same block of `count` pixels.
kernel void pixel_points(const uint block, const uint index, const uint replicate, const uint count,
                         global float4* points) {
  const uint i = get_global_id(0);
  if (i >= count) return;
  const Sampler sampler = make_sampler(i, replicate, 1u, index, LUCARIUM_SAMPLER_SOBOL);
  points[i] = sampler_block(&sampler, block);
}

// The same film positions of eight pixels at once, and of each alone.
kernel void film_points(const uint index, const uint first, global float2* together, global float2* alone) {
  float8 x, y;
  sample_films(sampler_seeds(first, 0u, 9u), index, &x, &y);
  float xs[8], ys[8];
  vstore8(x, 0, xs);
  vstore8(y, 0, ys);
  for (uint k = 0u; k < 8u; ++k) {
    const Sampler sampler = make_sampler(first + k, 0u, 9u, index, LUCARIUM_SAMPLER_SOBOL);
    together[k] = (float2)(xs[k], ys[k]);
    alone[k] = sample_camera_dimensions(&sampler).film;
  }
}

// The same block of eight samplers at once, and of each alone, a float4 per sampler; and directions by its first two
// numbers, w unused.
kernel void blocks_of_eight(const uint seed, const uint index, const uint block, const uint mode,
                            global float4* together, global float4* alone, global float4* directions_together,
                            global float4* directions_alone) {
  const uint8 lanes = (uint8)(0u, 1u, 2u, 3u, 4u, 5u, 6u, 7u);
  float8 c[4], x, y, z;
  sampler_blocks(seed + lanes * 77777u, index + lanes * 8191u, mode, block, c);
  sample_cosine_hemispheres(c[0], c[1], &x, &y, &z);
  float numbers[4][8], xs[8], ys[8], zs[8];
  for (uint k = 0u; k < 4u; ++k) vstore8(c[k], 0, numbers[k]);
  vstore8(x, 0, xs);
  vstore8(y, 0, ys);
  vstore8(z, 0, zs);
  for (uint k = 0u; k < 8u; ++k) {
    const Sampler sampler = {seed + k * 77777u, index + k * 8191u, mode};
    const float4 expected = sampler_block(&sampler, block);
    together[k] = (float4)(numbers[0][k], numbers[1][k], numbers[2][k], numbers[3][k]);
    alone[k] = expected;
    directions_together[k] = (float4)(xs[k], ys[k], zs[k], 0.0f);
    directions_alone[k] = (float4)(sample_cosine_hemisphere(expected.xy), 0.0f);
  }
}

// The same block of eight sample numbers of one sampler at once, from a multiple of 8 on, and of each alone.
kernel void blocks_of_run(const uint seed, const uint index, const uint block, global float4* together,
                          global float4* alone) {
  float8 c[4];
  sampler_blocks_of_run(seed, index, block, c);
  float numbers[4][8];
  for (uint k = 0u; k < 4u; ++k) vstore8(c[k], 0, numbers[k]);
  for (uint k = 0u; k < 8u; ++k) {
    const Sampler sampler = {seed, index + k, LUCARIUM_SAMPLER_SOBOL};
    together[k] = (float4)(numbers[0][k], numbers[1][k], numbers[2][k], numbers[3][k]);
    alone[k] = sampler_block(&sampler, block);
  }
}

// How a path's decisions are cut out of the blocks, and how a sampler gets its seed.
kernel void path_dimensions(const uint vertex, global float4* points, global uint* seeds) {
  const Sampler sampler = make_sampler(3u, 1u, 7u, 11u, LUCARIUM_SAMPLER_SOBOL);
  const CameraSample camera = sample_camera_dimensions(&sampler);
  const LightChoiceSample light = sample_light_dimensions(&sampler, vertex);
  const DirectionSample direction = sample_direction_dimensions(&sampler, vertex);
  points[0] = (float4)(camera.film, camera.spare);
  points[1] = (float4)(light.point, light.choice, light.lobe);
  points[2] = (float4)(direction.direction, direction.roulette, direction.spare);
  seeds[0] = sampler.seed;
}

kernel void halton_points(const uint dimension, const uint seed, const uint count, global float2* points) {
  const uint i = get_global_id(0);
  if (i < count) points[i] = (float2)(halton(i, dimension), scrambled_halton(i, dimension, seed));
}

// Per warp: xyz the warped point, w its density; and the inverse of it.
kernel void warp_points(const uint warp, const float parameter, const uint seed, const uint count,
                        global float4* points, global float2* inverses, global float2* squares) {
  const uint i = get_global_id(0);
  if (i >= count) return;
  const Sampler sampler = {seed, i, LUCARIUM_SAMPLER_RANDOM};
  const float2 u = sampler_block(&sampler, 0u).xy;
  float3 w = (float3)(0.0f);
  float2 inverse = (float2)(0.0f);
  float pdf = 0.0f;
  if (warp == 0u) {
    w.xy = sample_disk(u);
    pdf = pdf_disk(w.xy);
    inverse = invert_disk(w.xy);
  } else if (warp == 1u) {
    w = sample_cosine_hemisphere(u);
    pdf = pdf_cosine_hemisphere(w);
    inverse = invert_cosine_hemisphere(w);
  } else if (warp == 2u) {
    w = sample_uniform_sphere(u);
    pdf = pdf_uniform_sphere();
    inverse = invert_uniform_sphere(w);
  } else if (warp == 3u) {
    w = sample_uniform_hemisphere(u);
    pdf = pdf_uniform_hemisphere(w);
    inverse = invert_uniform_hemisphere(w);
  } else if (warp == 4u) {
    w = sample_cone(u, parameter);
    pdf = pdf_cone(w, parameter);
    inverse = invert_cone(w, parameter);
  } else if (warp == 5u) {
    w.xy = sample_triangle(u);
    pdf = pdf_triangle(w.xy);
    inverse = invert_triangle(w.xy);
  } else if (warp == 6u) {
    w = sample_power_cosine(u, parameter);
    pdf = pdf_power_cosine(w, parameter);
    inverse = invert_power_cosine(w, parameter);
  }
  points[i] = (float4)(w, pdf);
  inverses[i] = inverse;
  squares[i] = u;
}

// x: turns; y, z: sine and cosine; w unused.
kernel void sine_table(const uint count, const float scale, global float4* values) {
  const uint i = get_global_id(0);
  if (i >= count) return;
  const float x = ((float)i / (float)count * 2.0f - 1.0f) * scale;
  float cosine;
  const float sine = sincos_turns(x, &cosine);
  values[i] = (float4)(x, sine, cosine, 0.0f);
}

// A point (x, y) of a circle and z, its atan2_turns.
kernel void angle_table(const uint count, global float4* values) {
  const uint i = get_global_id(0);
  if (i >= count) return;
  float x;
  const float y = sincos_turns(((float)i + 0.5f) / (float)count, &x);
  const float radius = exp2((float)(i % 41u) - 20.0f);
  values[i] = (float4)(radius * x, radius * y, atan2_turns(radius * y, radius * x), 0.0f);
}
