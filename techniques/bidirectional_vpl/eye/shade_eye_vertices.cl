// SPDX-License-Identifier: Apache-2.0
// One vertex of every active camera path: what it emits (strategy -1), a light sample (0), a connection to a virtual
// light (1 ... K-1), and the BSDF sample along which the path goes on.
#include "bidirectional_vpl/base/interleave.clh"
#include "bidirectional_vpl/bundles/bundle_set.clh"
#include "bidirectional_vpl/eye/connect.clh"
#include "bidirectional_vpl/eye/find_lights.clh"
#include "bidirectional_vpl/guide/guide.clh"
#include "lucarium/eight/vertex_numbers.clh"
#include "lucarium/lights.clh"
#include "lucarium/prefetch.clh"
#include "lucarium/scene.clh"
#include "lucarium/shared/path_settings.h"

#ifdef EYE_GUIDE
#define GUIDE_PARAMETERS                                                                        \
  __global const GuidePhoton *restrict guide_photons, __global const uint *restrict guide_keys, \
      __global const uint *restrict guide_count,
#define GUIDE_ARGUMENTS guide_photons, guide_keys, guide_count,
#else
#define GUIDE_PARAMETERS
#define GUIDE_ARGUMENTS
#endif

#define TURN_STREAM 0x7475726eu  // apart from the numbers of the path itself

// Whether bundles have their turn (directions=both): in one of two samples that follow each other, in random order.
bool takes_turn(uint seed, uint sample_index, uint path) {
  return (sample_index ^ hash_uint3(seed ^ TURN_STREAM, sample_index >> 1, path)) & 1u;
}

// Counts the event; false when there are no such paths in the path set.
bool count_scattering(BidirectionalSettings settings, EyeWalk* walk, bool delta) {
  const bool chain = walk->state.flags & EYE_PATH_CHAIN;
  walk->state.flags &= ~(EYE_PATH_AFTER_DELTA | EYE_PATH_PARALLEL);
  if (delta) walk->state.flags |= EYE_PATH_AFTER_DELTA;
  if (delta && chain) {
    if (walk->state.segment < LUCARIUM_PATH_EYE_DELTA_LIMIT) return true;
    walk->state.flags |= EYE_PATH_MIRRORS;
    return false;
  }
  walk->state.flags &= ~EYE_PATH_CHAIN;
  walk->state.scatterings += 1u;
  if (walk->state.scatterings >= LUCARIUM_PATH_SCATTERING_CAP) {
    walk->state.flags |= EYE_PATH_CAPPED;
    return false;
  }
  return walk->state.scatterings <= settings.max_scatterings;
}

// Ends paths at random behind camera_edges by the root of what they may still bring, as if no guide had made them more
// likely (Arvo and Kirk 1990). Of surfaces that reflect the share r, r of the paths go on at each one, in the end, and
// those carry r. Where fewer than r^2 went on, the variance of later bounces would grow with each one; where all do,
// paths between white surfaces would not end. False: the path ends here.
bool survives(const Scene* scene, BidirectionalSettings settings, EyeWalk* walk, bool delta, float u) {
  const bool chain = walk->state.flags & EYE_PATH_CHAIN;
  const float importance =
      max_component(walk->state.throughput.xyz) * walk->state.gain * medium_squared_ior(scene, walk->state.medium);
  float survival = 1.0f;
  if (!chain && walk->state.scatterings >= settings.camera_edges) {
    survival = fmin(delta ? 1.0f : 0.95f, sqrt(importance));
  } else if (chain && walk->state.segment >= LUCARIUM_PATH_EYE_ROULETTE_START) {
    survival = fmin(1.0f, importance);
  }
  if (u >= survival) return false;
  walk->state.throughput.xyz /= survival;
  return true;
}

// The next direction of the path (equation 1; behind a widened lobe, equation 14). False when the path ends here.
bool sample_direction(const Scene* scene, BidirectionalSettings settings, EyeWalk* walk, const Surface* surface,
                      const Bsdf* bsdf, const EyeMis* mis, const Sampler* sampler, uint seed,
                      const VertexNumbers* numbers, GLOSS_FIRST_PARAMETER(first_vertices) GUIDE_PARAMETERS Ray* ray,
                      RayEnds* ends) {
  const uint number = bundle_number(settings, seed, sampler->index, walk->path, walk->state.segment);
  const Sampler bundle = bundle_set(settings, seed, sampler->index, walk->state.segment, number);
  // Choose a direction.
  const bool first = walk->state.scatterings == 0u;
  bool along_bundle;
  BsdfSample sample = sample_eye_direction(scene, bsdf, numbers, &bundle, first,
                                           takes_turn(seed, sampler->index, walk->path), &along_bundle);
  float gain = 1.0f;
#ifdef EYE_GUIDE
  // Behind ideal surfaces other than the camera's own rays: what other strategies find needs no guide.
  if ((walk->state.flags & EYE_PATH_AFTER_DELTA) && walk->state.segment > 0u && bsdf_has_smooth_lobe(bsdf)) {
    const Guide guide = find_guide(scene, guide_photons, guide_keys, guide_count[0], surface->position, bsdf);
    if (guides(&guide)) {
      const float4 v = random_float4(sampler->seed ^ GUIDE_STREAM, sampler->index, walk->state.segment);
      sample = guided_direction(&guide, bsdf, sample, v, &gain);
    }
  }
#endif
  if (is_black(sample.weight)) return false;
#ifdef GLOSS_SUPPRESSES
  if (!sample.delta)
    sample.weight = suppressed_bsdf(scene, settings, bsdf, sample.direction, walk->samples * sample.pdf) / sample.pdf;
  if (first) {
    const PathMis none = {0.0f, 0.0f};
    first_vertices[walk->path] = pack_path_vertex(surface, bsdf, (float3)(0.0f), LUCARIUM_NONE, 1u, none);
  }
#endif
  if (!count_scattering(settings, walk, sample.delta)) return false;
  // Carry weights and throughput on.
  const Bsdf turned = turn_bsdf(bsdf, sample.direction);
  if (sample.delta)
    leave_eye_mis_ideal(walk, mis, ideal_lobe_back(bsdf, &turned, sample.transmitted));
  else
    leave_eye_mis(walk, mis, settings.connection_samples, pdf_bsdf(&turned, surface->view));
  walk->state.throughput = (float4)(walk->state.throughput.xyz * sample.weight, sample.pdf);
  walk->state.gain *= gain;
  walk->state.cosine = fabs(dot(surface->n_g, sample.direction));
  if (!is_contribution(walk->state.throughput.xyz)) {
    walk->state.flags |= EYE_PATH_BAD;
    return false;
  }
  if (sample.transmitted) walk->state.medium = medium_behind(scene, surface, walk->state.medium);
  if (!survives(scene, settings, walk, sample.delta, numbers->direction.roulette)) return false;
  *ray = make_ray(surface, sample.direction, numbers->next_seed);
  *ends = ray_ends(surface, sample.direction);
  walk->state.bundle = LUCARIUM_NONE;
#ifdef EYE_BUNDLES_STORED
  if (along_bundle) {
    // Looked up (look_up_bundle.cl), not traced.
    ray->direction.w = -1.0f;
    walk->state.bundle = number;
    walk->state.left = surface->triangle;
  }
#endif
  walk->state.segment += 1u;
  return true;
}

#if LIGHT_VERTICES > 0
// One of all virtual lights, by resampling. Returns its slot in `vertices`, which it asks for: the caller has other
// work first. `scale`: what its light is multiplied by, 0 where it has none.
LUCARIUM_JOIN uint choose_vertex(BidirectionalSettings settings, const EyeWalk* walk, const Surface* surface,
                                 const Bsdf* bsdf, const EyeMis* mis, __global const PathVertex* restrict vertices,
                                 __global const uint* restrict list, uint count, __global const float* restrict table,
                                 float4 v, uint seed, uint sample_index, float* scale) {
  const float camera_side =
      mis->fixed + path_mis_power(fabs(dot(bsdf->n_s, bsdf->view)) * M_1_PI_F) * mis->turning[LIGHT_VERTICES - 1u];
  CandidateTarget target = make_candidate_target(surface, bsdf, camera_side, settings.connection_samples);
#ifdef TWO_BOUNCE
  if (has_shares(walk->state.scatterings + 2u)) {
    target.samples = INFINITY;  // shares in place of weights
    target.limit = settings.g_max;
  }
#endif
  uint place = hash_uint(as_uint(v.x) ^ as_uint(v.z));
#ifdef EYE_INTERLEAVED
  place = interleaved_place(settings, interleaved_part(settings, seed, sample_index, walk->path), place);
#endif
  const uint chosen = list[choose_candidate(settings, table, count, &target, place, v.y, scale)];
  LUCARIUM_PREFETCH(vertices + chosen);
  LUCARIUM_PREFETCH((__global const uchar*)(vertices + chosen) + 64);
  return chosen;
}
#endif

// Work-item i: ray i of the queue. Writes alive[i], and where it is 1 next_rays[i], next_ends[i] and next_queue[i].
// Light that still waits for its shadow ray: light_samples[i], w: bits of the scatterings of the whole path, and
// connections[i], w: connection_path(); the rays are inactive where there is none. connections[i].w is NONE where no
// virtual light was to be chosen. connection_paths[i]: the light path of the connection, light_numbers[i]: the light of
// the sample.
__kernel LUCARIUM_FLATTEN void shade_eye_vertices(
    LUCARIUM_SCENE_PARAMETERS uint seed, const BidirectionalSettings settings, uint sample_index,
    __global const PathVertex* restrict vertices,
    GLOSS_PARAMETER(vertex_densities) GLOSS_FIRST_PARAMETER(first_vertices)
        GUIDE_PARAMETERS __global const uint* restrict vertex_list,
    __global const uint* restrict vertex_count, __global const float* restrict candidate_table,
    __global const float* restrict shares, __global const Ray* restrict rays, __global const Hit* restrict hits,
    __global const uint* restrict queue, __global const uint* restrict active, __global const float* restrict numbers,
    __global EyePathState* restrict states, __global float* restrict eye_mis, __global float4* restrict sample,
    LUCARIUM_RAY_ENDS_PARAMETER(next_ends) LUCARIUM_RAY_ENDS_PARAMETER(light_ends)
        LUCARIUM_RAY_ENDS_PARAMETER(connection_ends) __global Ray* restrict next_rays,
    __global uint* restrict next_queue, __global uint* restrict alive, __global Ray* restrict light_rays,
    __global float4* restrict light_samples,
#ifdef EYE_LIGHT_MAPS
    __global uint* restrict light_numbers,
#endif
    __global Ray* restrict connection_rays, __global float4* restrict connections,
    __global uint* restrict connection_paths, uint slice_base) {
  const uint i = slice_base + (uint)get_global_id(0);
  if (i >= active[0]) return;
  LUCARIUM_SCENE_BIND(scene);
  prefetch_surfaces(&scene, hits, i, active[0]);
  const Hit hit = hits[i];
  const float3 direction = rays[i].direction.xyz;
  EyeWalk walk;
  walk.path = queue[i];
  walk.state = states[walk.path];
  const BidirectionalSettings rules = path_settings(settings, walk.state.flags);
  load_carried(eye_mis, settings.pixels, &walk);
#ifdef GLOSS
  walk.samples = gloss_samples(rules, sample_index);
#endif
  light_rays[i] = inactive_ray();
  connection_rays[i] = inactive_ray();
  connections[i].w = as_float(LUCARIUM_NONE);  // no choice
  alive[i] = 0u;
  next_queue[i] = walk.path;

  // The environment ends the path.
  if (hit.triangle == LUCARIUM_NO_HIT) {
    add_environment(&scene, rules, shares, &walk, direction, sample);
    states[walk.path].flags = walk.state.flags;
    return;
  }

  // Where nothing may be scattered, only what emits counts.
  const bool chain = walk.state.flags & EYE_PATH_CHAIN;
  bool goes_on = walk.state.scatterings < rules.max_scatterings || chain;
  if (!goes_on && !may_emit(&scene, hit.triangle)) return;

  // Find the surface, and what the volume on the way has left; add what it emits.
  const Surface surface = make_surface(&scene, hit, direction, 0u);
  walk.state.medium = medium_at(&scene, &surface, walk.state.medium);
  walk.state.throughput.xyz *= medium_transmittance(&scene, walk.state.medium, hit.distance);
  add_emission(&scene, rules, shares, &walk, &surface, hit.distance, sample);
  const Bsdf bsdf = make_bsdf(&scene, &surface, 0u);
  goes_on = goes_on && !bsdf_is_black(&bsdf);
  if (!goes_on) {
    states[walk.path].flags = walk.state.flags;
    return;
  }

  // Prepare weights and random numbers.
  const EyeMis mis = arrive_eye_mis(&walk, &surface, hit.distance);
  walk.state.rest = arrive_rest(rules, &walk, &surface, hit.distance);
#ifdef GLOSS_SUPPRESSES
  arrive_gloss(&walk, &surface, hit.distance);
#endif
  const Sampler sampler = make_pixel_sampler(seed, walk.path, sample_index);
  const VertexNumbers of_vertex = vertex_numbers(numbers, i);
  const uint scatterings = walk.state.scatterings + 1u;
  const bool smooth = bsdf_has_smooth_lobe(&bsdf) && scatterings <= rules.max_scatterings;

#if LIGHT_VERTICES > 0
  // Choose a virtual light.
  const bool connecting = smooth && rules.connection_samples > 0.0f && scatterings < rules.max_scatterings &&
                          vertex_count[0] > 0u &&
                          !(rules.flags & BIDIRECTIONAL_ALL_VERTICES);  // else connect_to_all.cl has connected it
  const bool of_one_path = rules.flags & (BIDIRECTIONAL_OWN_VERTICES | BIDIRECTIONAL_PAIRED_VERTICES);
  const float4 v = random_float4(sampler.seed ^ CONNECTION_STREAM, sampler.index, walk.state.segment);
  float scale = 0.0f;
  uint vertex_index = 0u;
  if (connecting && !of_one_path)
    vertex_index = choose_vertex(rules, &walk, &surface, &bsdf, &mis, vertices, vertex_list, vertex_count[0],
                                 candidate_table, v, seed, sample_index, &scale);
#endif

  // Sample a light.
  if (smooth && rules.light_samples > 0.0f) {
    float3 light;
    uint number;
    Ray ray;
    RayEnds ends;
    if (connect_light_sample(&scene, rules, shares, &walk, &surface, &bsdf, &mis,
                             GLOSS_ARGUMENT(first_vertices) of_vertex.light, of_vertex.shadow_seed, &light, &number,
                             &ray, &ends)) {
      if (!is_contribution(light)) {
        walk.state.flags |= EYE_PATH_BAD;
      } else {
        light_rays[i] = ray;
        LUCARIUM_STORE_RAY_ENDS(light_ends, i, ends);
        light_samples[i] = (float4)(light, as_float(scatterings));
#ifdef EYE_LIGHT_MAPS
        light_numbers[i] = number;
#endif
      }
    }
  }

#if LIGHT_VERTICES > 0
  // Connect to a virtual light.
  if (connecting) {
    connections[i].w = as_float(0u);
    float3 light = (float3)(0.0f), towards = surface.n_s;
    PathVertex vertex;
    uint light_path = 0u;
    if (of_one_path) {
      // One of a light path: of the same number, or of the bundle's.
      light_path = walk.path;
      if (rules.flags & BIDIRECTIONAL_PAIRED_VERTICES)
        light_path = bundle_choice(rules, seed, sample_index, walk.path, 0u) % rules.light_paths;
      light = choose_of_path(&scene, rules, &walk, &surface, &bsdf, &mis, vertices,
                             GLOSS_ARGUMENT(vertex_densities) light_path, v.x, &vertex, &towards);
    } else {
      vertex = vertices[vertex_index];
      light_path = vertex_index / LIGHT_VERTICES;
      if (scale > 0.0f)
        light = scale * connected_light(&scene, rules, &walk, &surface, &bsdf, &mis, &vertex,
                                        GLOSS_LOAD(vertex_densities, vertex_index), &towards);
    }
    // Aim a shadow ray at it.
    light *= walk.state.throughput.xyz;
    if (!is_contribution(light)) {
      walk.state.flags |= EYE_PATH_BAD;
    } else if (!is_black(light)) {
      Ray ray;
      RayEnds ends;
      light = aim_connection(&scene, &walk, &surface, &vertex, towards, of_vertex.shadow_seed, light, &ray, &ends);
      connection_rays[i] = ray;
      LUCARIUM_STORE_RAY_ENDS(connection_ends, i, ends);
      connections[i] = (float4)(light, connection_path(&walk, &vertex));
      connection_paths[i] = light_path;
    }
  }
#endif

  // Go on.
  Ray next = inactive_ray();
  RayEnds ends = no_ray_ends();
  goes_on = sample_direction(&scene, rules, &walk, &surface, &bsdf, &mis, &sampler, seed, &of_vertex,
                             GLOSS_ARGUMENT(first_vertices) GUIDE_ARGUMENTS & next, &ends);
  alive[i] = goes_on;
  next_rays[i] = next;
  LUCARIUM_STORE_RAY_ENDS(next_ends, i, ends);
  states[walk.path] = walk.state;
  store_carried(eye_mis, rules.pixels, &walk);
}
