// SPDX-License-Identifier: Apache-2.0
#include "lucarium/light_tree.clh"
#include "lucarium/sobol.clh"

// A point whose normal counts where it has w = 1.
LitPoint point_to_light(float4 position, float4 normal) {
  return lit_point(position.xyz, normal.w > 0.0f ? pack_lit_side(normal.xyz) : LUCARIUM_NONE);
}

// Work-item i: a light for a point, with the 24 bits of u that samplers give; its probability; and that again from the
// light alone.
kernel void choose_lights_for(LUCARIUM_SCENE_PARAMETERS const float4 position, const float4 normal, const uint seed,
                              const uint count, global uint* lights, global float2* choices) {
  LUCARIUM_SCENE_BIND(scene);
  const uint i = get_global_id(0);
  if (i >= count) return;
  const LitPoint lit = point_to_light(position, normal);
  float pmf;
  const float u = uint_to_unit(hash_uint2(i, seed));
  lights[i] = choose_light_at(&scene, lit, u, hash_uint2(seed, i), &pmf);
  const bool any = lights[i] != LUCARIUM_NONE;
  choices[i] = (float2)(any ? pmf : 0.0f, any ? light_choice_at(&scene, lit, lights[i]) : 0.0f);
}

// Work-item i: the probabilities of all lights for point i.
kernel void light_choices(LUCARIUM_SCENE_PARAMETERS const global float4* positions, const global float4* normals,
                          const uint count, const uint light_count, global float* choices) {
  LUCARIUM_SCENE_BIND(scene);
  const uint i = get_global_id(0);
  if (i >= count) return;
  const LitPoint lit = point_to_light(positions[i], normals[i]);
  for (uint light = 0u; light < light_count; ++light)
    choices[i * light_count + light] = light_choice_at(&scene, lit, light);
}

// What the first child of a node may send.
kernel void value_of_node(const global uint* node, const uint kind, const float4 position, const float4 normal,
                          global float* value) {
  value[0] = light_node_values(node, kind, point_to_light(position, normal)).s0;
}

// One of eight that send so much.
kernel void choose_one(const global float* values, const float u, global float2* chosen) {
  ChoiceNumber number = {u, 0u};
  float pmf = 1.0f;
  const uint lane = choose_of_eight(vload8(0, values), 0.0f, &number, &pmf);
  chosen[0] = (float2)((float)lane, pmf);
}

// Work-item i chooses a part of 2^-20 by one of the 16 numbers that lie in it: what is left for the next choice, and
// the part's probability.
kernel void numbers_left(const uint count, global float2* left) {
  const uint i = get_global_id(0);
  if (i >= count) return;
  ChoiceNumber number = {(float)(i % 16u) * 0x1p-24f, hash_uint(i)};
  const float8 values = (float8)(0.0f, 0x1p-20f, 1.0f - 0x1p-20f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f);
  float pmf = 1.0f;
  const uint chosen = choose_of_eight(values, 0.0f, &number, &pmf);
  left[i] = (float2)(chosen == 1u ? number.u : -1.0f, pmf);
}
