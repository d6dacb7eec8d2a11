// SPDX-License-Identifier: Apache-2.0
// Weights of all strategies of given paths, each by the functions that the technique uses for it.
#include "bidirectional_vpl/eye/find_lights.clh"

#define MAX_K 6u

// A path v_0 ... v_K; entries by vertex.
typedef struct TestPath {
  float forward[MAX_K + 1u];   // density with which light paths leave v_j towards v_{j+1} [1/sr]
  float backward[MAX_K + 1u];  // and camera paths towards v_{j-1}
  float towards_light[MAX_K + 1u], towards_eye[MAX_K + 1u];  // cosines at v_j of its two segments
  float distance[MAX_K + 1u];                                // from v_{j-1} to v_j
  uint ideal[MAX_K + 1u];
  uint k;
  float light, emission, eye;  // densities of v_0 by light samples and emission, and of v_K by the camera [1/m^2]
  float samples[4];            // n of hits, light samples, connections, splats
} TestPath;

__global const float* read_path(__global const float* from, uint k, TestPath* path) {
  path->k = k;
  for (uint j = 0u; j <= MAX_K; ++j) {
    path->forward[j] = from[j];
    path->backward[j] = from[7u + j];
    path->towards_light[j] = from[14u + j];
    path->towards_eye[j] = from[21u + j];
    path->distance[j] = from[28u + j];
    path->ideal[j] = from[35u + j] > 0.5f;
  }
  path->light = from[42];
  path->emission = from[43];
  path->eye = from[44];
  for (uint s = 0u; s < 4u; ++s) path->samples[s] = from[45u + s];
  return from;
}

// At v_s, as light paths get there.
PathMis light_side(const TestPath* path, uint s) {
  float2 carried = (float2)(path_mis_power(path->samples[1] * path->light / path->emission),
                            path_mis_ratio(path->samples[0], path->emission));
  PathMis mis = {0.0f, 0.0f};
  for (uint j = 1u; j <= s; ++j) {
    const float d2 = path->distance[j] * path->distance[j];
    mis = path_mis_arrive(carried, path->forward[j - 1u] * path->towards_light[j] / d2, path->towards_eye[j - 1u] / d2);
    carried = path->ideal[j] ? path_mis_leave_ideal(mis, path->backward[j])
                             : path_mis_leave(mis, path->samples[2], path->backward[j]);
  }
  return mis;
}

// At v_s, as camera paths get there; the walk is the one that arrives.
EyeMis eye_side(const TestPath* path, uint s, EyeWalk* walk) {
  walk->state.flags = EYE_PATH_PARALLEL;  // the camera's density is given over area
  walk->state.throughput = (float4)(1.0f, 1.0f, 1.0f, path->eye / path->towards_eye[path->k]);
  walk->state.carried = path_mis_power(path->samples[3]);
  walk->state.cosine = 1.0f;
  for (uint m = 0u; m <= LIGHT_VERTICES; ++m) walk->carried[m] = 0.0f;
  EyeMis mis;
  for (uint j = path->k;; --j) {
    Surface surface;
    const float c = path->towards_eye[j];
    surface.n_g = (float3)(0.0f, 0.0f, 1.0f);
    surface.view = (float3)(safe_sqrt(1.0f - c * c), 0.0f, c);
    mis = arrive_eye_mis(walk, &surface, j == path->k ? 1.0f : path->distance[j + 1u]);
    if (j == s) return mis;
    walk->state.flags = 0u;
    if (path->ideal[j]) {
      walk->state.flags = EYE_PATH_AFTER_DELTA;
      leave_eye_mis_ideal(walk, &mis, path->forward[j]);
    } else {
      leave_eye_mis(walk, &mis, path->samples[2], path->forward[j]);
    }
    walk->state.throughput.w = path->backward[j];
    walk->state.cosine = path->towards_light[j];
  }
}

// weights[8 i + 1 + s]: of strategy s = -1 ... K of path i; 0 where it cannot be run.
__kernel void weigh_paths(uint count, __global const float* restrict paths, __global const uint* restrict lengths,
                          __global float* restrict weights) {
  const uint i = (uint)get_global_id(0);
  if (i >= count) return;
  TestPath path;
  read_path(paths + 49u * i, lengths[i], &path);
  const uint k = path.k;
  __global float* out = weights + 8u * i;
  for (uint s = 0u; s < 8u; ++s) out[s] = 0.0f;
  BidirectionalSettings settings;
  settings.hit_samples = path.samples[0];
  settings.light_samples = path.samples[1];
  EyeWalk walk;
  walk.path = 0u;

  // Hits: the walk leaves v_1, and finds v_0.
  EyeMis mis = eye_side(&path, 1u, &walk);
  walk.state.flags = path.ideal[1] ? EYE_PATH_AFTER_DELTA : 0u;
  if (path.ideal[1])
    leave_eye_mis_ideal(&walk, &mis, path.forward[1]);
  else
    leave_eye_mis(&walk, &mis, path.samples[2], path.forward[1]);
  walk.state.throughput.w = path.backward[1];
  walk.state.scatterings = k;
  const float d2 = path.distance[1] * path.distance[1];
  const float hit_pdf = path.backward[1] * path.towards_eye[0] / d2;
  out[0] = hit_weight(settings, &walk, path.light / path.towards_eye[0] * d2,
                      path.emission * path.forward[0] * path.towards_light[1] / d2 / hit_pdf, true);

  // Light samples at v_1.
  if (!path.ideal[1]) {
    mis = eye_side(&path, 1u, &walk);
    float others = path_mis_power(path.samples[0] * hit_pdf / (path.samples[1] * path.light));
    if (k > 1u)
      others +=
          eye_mis_sum(&mis, LIGHT_VERTICES,
                      path.emission / (path.samples[1] * path.light) * path.forward[0] * path.towards_light[1] / d2,
                      path.forward[1]);
    out[1] = 1.0f / (1.0f + others);
  }

  // Connections of v_s and v_{s+1}.
  for (uint s = 1u; s < k && s <= LIGHT_VERTICES; ++s) {
    if (path.ideal[s] || path.ideal[s + 1u]) continue;
    const PathMis light = light_side(&path, s);
    mis = eye_side(&path, s + 1u, &walk);
    const float e2 = path.distance[s + 1u] * path.distance[s + 1u], n = path.samples[2];
    const float others = path_mis_sum(light, path.backward[s + 1u] * path.towards_eye[s] / (e2 * n), path.backward[s]) +
                         eye_mis_sum(&mis, LIGHT_VERTICES - s, path.forward[s] * path.towards_light[s + 1u] / (e2 * n),
                                     path.forward[s + 1u]);
    out[1u + s] = 1.0f / (1.0f + others);
  }

  // v_K and the camera.
  if (k >= 2u && k <= LIGHT_VERTICES)
    out[1u + k] = 1.0f / (1.0f + path_mis_sum(light_side(&path, k), path.eye / path.samples[3], path.backward[k]));
}
