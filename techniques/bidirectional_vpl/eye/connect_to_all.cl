// SPDX-License-Identifier: Apache-2.0
// vpl_choice=all: every active camera path's vertex is connected to one of the virtual lights, the same for all; a
// launch for each. Comes before shade_eye_vertices, which moves the paths on.
#include "bidirectional_vpl/base/interleave.clh"
#include "bidirectional_vpl/eye/connect.clh"
#include "lucarium/prefetch.clh"
#include "lucarium/scene.clh"

// Work-item i: ray i of the queue and the virtual light vertex_list[number]. Writes connection_rays[i], inactive where
// there is no light, and connections[i], w: connection_path(), and connection_paths[i], the light path.
__kernel LUCARIUM_FLATTEN void connect_to_all(
    LUCARIUM_SCENE_PARAMETERS uint seed, const BidirectionalSettings settings, uint sample_index, uint number,
    __global const PathVertex* restrict vertices,
    GLOSS_PARAMETER(vertex_densities) __global const uint* restrict vertex_list, __global const Ray* restrict rays,
    __global const Hit* restrict hits, __global const uint* restrict queue, __global const uint* restrict active,
    __global EyePathState* restrict states, __global const float* restrict eye_mis,
    LUCARIUM_RAY_ENDS_PARAMETER(connection_ends) __global Ray* restrict connection_rays,
    __global float4* restrict connections, __global uint* restrict connection_paths, uint slice_base) {
  const uint i = slice_base + (uint)get_global_id(0);
  if (i >= active[0]) return;
  LUCARIUM_SCENE_BIND(scene);
  prefetch_surfaces(&scene, hits, i, active[0]);
  connection_rays[i] = inactive_ray();
  const Hit hit = hits[i];
  if (hit.triangle == LUCARIUM_NO_HIT) return;
#ifdef EYE_INTERLEAVED
  // One of n^2 virtual lights (section 6, split).
  const uint parts = settings.interleave * settings.interleave;
  if (interleaved_part(settings, seed, sample_index, queue[i]) != number % parts) return;
#endif
  EyeWalk walk;
  walk.path = queue[i];
  walk.state = states[walk.path];
  if (walk.state.scatterings + 1u >= path_settings(settings, walk.state.flags).max_scatterings) return;
  load_carried(eye_mis, settings.pixels, &walk);
#ifdef GLOSS
  walk.samples = gloss_samples(settings, sample_index);
#endif

  // The vertex, as shade_eye_vertices finds it.
  const Surface surface = make_surface(&scene, hit, rays[i].direction.xyz, 0u);
  const Bsdf bsdf = make_bsdf(&scene, &surface, 0u);
  if (bsdf_is_black(&bsdf) || !bsdf_has_smooth_lobe(&bsdf)) return;
  walk.state.medium = medium_at(&scene, &surface, walk.state.medium);
  walk.state.throughput.xyz *= medium_transmittance(&scene, walk.state.medium, hit.distance);
  const EyeMis mis = arrive_eye_mis(&walk, &surface, hit.distance);

  // The connection. Fluxes are shares of all light paths', so that there is nothing to multiply by.
  const uint vertex_index = vertex_list[number];
  const PathVertex vertex = vertices[vertex_index];
  float3 towards;
  float3 light = connected_light(&scene, settings, &walk, &surface, &bsdf, &mis, &vertex,
                                 GLOSS_LOAD(vertex_densities, vertex_index), &towards);
  light *= walk.state.throughput.xyz;
#ifdef EYE_INTERLEAVED
  light *= (float)parts;
#endif
  if (!is_contribution(light)) {
    states[walk.path].flags |= EYE_PATH_BAD;
    return;
  }
  if (is_black(light)) return;
  Ray ray;
  RayEnds ends;
  const Sampler sampler = make_pixel_sampler(seed, walk.path, sample_index);
  const uint ray_seed = make_ray_seed(
      hash_uint3(sampler.seed ^ CONNECTION_STREAM, sampler.index, hash_uint2(walk.state.segment, number)));
  light = aim_connection(&scene, &walk, &surface, &vertex, towards, ray_seed, light, &ray, &ends);
  connection_rays[i] = ray;
  LUCARIUM_STORE_RAY_ENDS(connection_ends, i, ends);
  connections[i] = (float4)(light, connection_path(&walk, &vertex));
  connection_paths[i] = vertex_index / max((uint)LIGHT_VERTICES, 1u);  // none: never launched
}
