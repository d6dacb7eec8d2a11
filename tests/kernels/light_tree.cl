// SPDX-License-Identifier: Apache-2.0
#include "lucarium/light_tree.clh"
#include "lucarium/sobol.clh"

// Work-item i: a light for a point, with the 24 bits of u that samplers give; its probability; and that again from the
// light alone.
kernel void choose_lights_for(LUCARIUM_SCENE_PARAMETERS const float4 position, const uint seed, const uint count,
                              global uint* lights, global float2* choices) {
  LUCARIUM_SCENE_BIND(scene);
  const uint i = get_global_id(0);
  if (i >= count) return;
  float pmf;
  const float u = uint_to_unit(hash_uint2(i, seed));
  lights[i] = choose_light_at(&scene, position.xyz, u, hash_uint2(seed, i), &pmf);
  const bool any = lights[i] != LUCARIUM_NONE;
  choices[i] = (float2)(any ? pmf : 0.0f, any ? light_choice_at(&scene, position.xyz, lights[i]) : 0.0f);
}

// Work-item i: the probabilities of all lights for point i.
kernel void light_choices(LUCARIUM_SCENE_PARAMETERS const global float4* positions, const uint count,
                          const uint light_count, global float* choices) {
  LUCARIUM_SCENE_BIND(scene);
  const uint i = get_global_id(0);
  if (i >= count) return;
  for (uint light = 0u; light < light_count; ++light)
    choices[i * light_count + light] = light_choice_at(&scene, positions[i].xyz, light);
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
