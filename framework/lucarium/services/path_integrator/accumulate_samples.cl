// SPDX-License-Identifier: Apache-2.0
// Adds the paths of a batch to the sums of their pixels, each pixel's in sample order: the same bits for any number of
// threads. One work-item per pixel.
#include "lucarium/services/path_integrator/path_state.clh"

// Neumaier's compensated sum (Rundungsfehleranalyse einiger Verfahren zur Summation endlicher Summen, ZAMM 1974).
void add_compensated(float4* sum, float4* lost, float4 value) {
  const float4 total = *sum + value;
  const float4 large_sum = (*sum - total) + value, large_value = (value - total) + *sum;
  *lost += select(large_value, large_sum, fabs(*sum) >= fabs(value));
  *sum = total;
}

float4 clamp_indirect(PathSettings settings, float4 light) {
  return settings.indirect_clamp > 0.0f ? min(light, (float4)(settings.indirect_clamp)) : light;
}

// layer_sums: layer-major, two entries per pixel (sum, lost).
__kernel void accumulate_layers(PathSettings settings, PathBatch batch, uint pixels,
                                __global const PathState* restrict path_state,
                                __global const float4* restrict path_radiance, __global float4* restrict layer_sums,
                                __global uint* restrict pixel_shadow_rays, __global uint* restrict counts) {
  const uint p = get_global_id(0);
  if (p >= batch.pixel_count) return;
  const uint pixel = batch.first_pixel + p;
  const uint paths = batch.pixel_count * batch.sample_count;
  float4 sum[LUCARIUM_PATH_LAYERS], lost[LUCARIUM_PATH_LAYERS];
  for (uint layer = 0; layer < LUCARIUM_PATH_LAYERS; ++layer) {
    sum[layer] = layer_sums[2u * (layer * pixels + pixel)];
    lost[layer] = layer_sums[2u * (layer * pixels + pixel) + 1u];
  }
  uint bad = 0, capped = 0, eye_capped = 0, shadow_rays = 0;
  for (uint path = p; path < paths; path += batch.pixel_count) {
    for (uint layer = 0; layer < LUCARIUM_PATH_LAYERS; ++layer) {
      const float4 light = path_radiance[layer * paths + path];
      add_compensated(&sum[layer], &lost[layer], layer == 2u ? clamp_indirect(settings, light) : light);
    }
    const uint flags = path_state[path].flags;
    bad += (flags & PATH_BAD) != 0u;
    capped += (flags & PATH_CAPPED) != 0u;
    eye_capped += (flags & PATH_EYE_CAPPED) != 0u;
    shadow_rays += PATH_SHADOW_RAYS(flags);
  }
  for (uint layer = 0; layer < LUCARIUM_PATH_LAYERS; ++layer) {
    bad += !(all(isfinite(sum[layer])) && all(isfinite(lost[layer])));
    layer_sums[2u * (layer * pixels + pixel)] = sum[layer];
    layer_sums[2u * (layer * pixels + pixel) + 1u] = lost[layer];
  }
  pixel_shadow_rays[pixel] += shadow_rays;
  // Integers: their order does not matter.
  if (bad) atomic_add(&counts[LUCARIUM_PATH_COUNT_NONFINITE], bad);
  if (capped) atomic_add(&counts[LUCARIUM_PATH_COUNT_CAPPED], capped);
  if (eye_capped) atomic_add(&counts[LUCARIUM_PATH_COUNT_EYE_DELTA], eye_capped);
}

// The image (sum of layers) of those samples that belong to one replicate.
__kernel void accumulate_replicate(PathSettings settings, PathBatch batch, uint replicate,
                                   __global const float4* restrict path_radiance,
                                   __global float4* restrict replicate_sums) {
  const uint p = get_global_id(0);
  if (p >= batch.pixel_count) return;
  const uint pixel = batch.first_pixel + p;
  const uint paths = batch.pixel_count * batch.sample_count;
  const uint phase = batch.first_sample % settings.replicates;
  const uint first = (replicate + settings.replicates - phase) % settings.replicates;
  float4 sum = replicate_sums[2u * pixel], lost = replicate_sums[2u * pixel + 1u];
  for (uint sample = first; sample < batch.sample_count; sample += settings.replicates) {
    const uint path = sample * batch.pixel_count + p;
    const float4 light =
        path_radiance[path] + path_radiance[paths + path] + clamp_indirect(settings, path_radiance[2u * paths + path]);
    add_compensated(&sum, &lost, light);
  }
  replicate_sums[2u * pixel] = sum;
  replicate_sums[2u * pixel + 1u] = lost;
}
