// SPDX-License-Identifier: Apache-2.0
// One vertex of every active path: what it emits, one light sample, and the BSDF sample along which the path goes on.
// One step of the estimator of the rendering equation (Kajiya 1986, equation 1; path_tracing.cpp has the formula).
#include "lucarium/medium.clh"
#include "lucarium/prefetch.clh"
#include "lucarium/scene.clh"
#include "lucarium/services/direct_light/light_strategies.clh"
#include "lucarium/services/path_integrator/path_state.clh"

// A path while its vertex is shaded.
typedef struct Walk {
  uint path;
  PathState state;
  float3 throughput;               // of the path up to this vertex
  float pdf;                       // of the BSDF sample that led here [1/sr]
  uint side;                       // LitPoint::side at the last vertex, then at this one
  RayEnds shadow_ends, next_ends;  // of the rays that leave the vertex
} Walk;

// Adds light that reaches the path's last vertex to the layer it belongs to.
LUCARIUM_JOIN void add_light(PathBatch batch, Walk* walk, float3 light, __global float4* path_radiance) {
  const float3 contribution = walk->throughput * light;
  if (!is_contribution(contribution))
    walk->state.flags |= PATH_BAD;
  else
    path_radiance[path_radiance_index(batch, walk->path, walk->state.scatterings)] += (float4)(contribution, 0.0f);
}

// Whether a light sample at the last vertex could have found an emitter that the path has hit.
bool samples_compete(PathSettings settings, const Walk* walk) {
  return (settings.flags & LUCARIUM_PATH_SAMPLE_LIGHTS) && !(walk->state.flags & PATH_AFTER_DELTA);
}

// Weight of such an emitter: 0 when it is not wanted or left to light samples. `light_pdf`: density with which a light
// sample at the last vertex gives this direction; 0 where none competes.
float hit_weight(PathSettings settings, const Walk* walk, float light_pdf) {
  if (!path_layer_wanted(settings, walk->state.scatterings)) return 0.0f;
  if (walk->state.flags & PATH_AFTER_DELTA) return 1.0f;
  if (!(settings.flags & LUCARIUM_PATH_HIT_LIGHTS)) return 0.0f;
  return settings.flags & LUCARIUM_PATH_SAMPLE_LIGHTS ? mis_weight(walk->pdf, light_pdf) : 1.0f;
}

LUCARIUM_JOIN void add_environment(const Scene* scene, PathSettings settings, PathBatch batch, Walk* walk,
                                   float3 position, float3 direction, __global float4* path_radiance) {
  if (!(settings.flags & LUCARIUM_PATH_SEES_ENVIRONMENT)) return;
  const float light_pdf =
      samples_compete(settings, walk) ? pdf_light_environment(scene, lit_point(position, walk->side), direction) : 0.0f;
  const float weight = hit_weight(settings, walk, light_pdf);
  if (weight > 0.0f) add_light(batch, walk, weight * environment_radiance(scene, direction), path_radiance);
}

LUCARIUM_JOIN void add_emission(const Scene* scene, PathSettings settings, PathBatch batch, Walk* walk,
                                const Surface* surface, float distance, __global float4* path_radiance) {
  if (!(settings.flags & LUCARIUM_PATH_SEES_TRIANGLES)) return;
  const float3 emission = emitted_radiance(scene, surface);
  if (is_black(emission)) return;
  const float light_pdf =
      samples_compete(settings, walk) ? pdf_light_surface(scene, surface, distance, walk->side) : 0.0f;
  const float weight = hit_weight(settings, walk, light_pdf);
  if (weight > 0.0f) add_light(batch, walk, weight * emission, path_radiance);
}

// ---- the two samples

// Whether a path with so many scatterings can still contribute to a layer of the path set.
bool can_bring_light(PathSettings settings, uint scatterings, bool delta) {
  if (scatterings < settings.max_scatterings) return true;
  return (settings.flags & (LUCARIUM_PATH_SEES_TRIANGLES | LUCARIUM_PATH_SEES_ENVIRONMENT)) &&
         (delta || (settings.flags & LUCARIUM_PATH_HIT_LIGHTS)) && path_layer_wanted(settings, scatterings);
}

// The light sample: fills shadow_ray and shadow_light where it may bring something.
LUCARIUM_JOIN void sample_lights(const Scene* scene, PathSettings settings, Walk* walk, const Surface* surface,
                                 const Bsdf* bsdf, const VertexNumbers* numbers, __global Ray* shadow_ray,
                                 __global float4* shadow_light) {
  const uint scatterings = walk->state.scatterings + 1u;
  if (!(settings.flags & (LUCARIUM_PATH_SAMPLE_LIGHTS | LUCARIUM_PATH_PUNCTUAL))) return;
  if (scatterings > settings.max_scatterings || !path_layer_wanted(settings, scatterings)) return;
  if (!bsdf_has_smooth_lobe(bsdf)) return;
  float3 light;
  Ray ray;
  RayEnds ends;
  const bool hits_compete = settings.flags & LUCARIUM_PATH_HIT_LIGHTS;
  if (!sample_light_at(scene, surface, bsdf, walk->side, numbers->light, walk->state.medium, hits_compete,
                       LUCARIUM_ALL_LIGHTS, numbers->shadow_seed, &light, &ray, &ends))
    return;
  light *= walk->throughput;
  if (!is_contribution(light)) {
    walk->state.flags |= PATH_BAD;
    return;
  }
  if (is_black(light)) return;
  *shadow_ray = ray;
  walk->shadow_ends = ends;
  *shadow_light = (float4)(light, as_float(scatterings));
  walk->state.flags += PATH_SHADOW_RAY_ONE;
}

// Counts the event; false when the path set has no paths that go on like this.
bool count_scattering(PathSettings settings, Walk* walk, bool delta) {
  const bool eye_side = walk->state.scatterings == 0u;
  walk->state.flags = delta ? walk->state.flags | PATH_AFTER_DELTA : walk->state.flags & ~PATH_AFTER_DELTA;
  if (delta && !eye_side && !(settings.flags & LUCARIUM_PATH_LIGHT_DELTA)) return false;
  if (delta && eye_side) {
    if (walk->state.segment == settings.eye_deltas) {  // every vertex so far was such an event
      if (settings.eye_deltas == LUCARIUM_PATH_EYE_DELTA_LIMIT) walk->state.flags |= PATH_EYE_CAPPED;
      return false;
    }
    return true;
  }
  walk->state.scatterings += 1u;
  if (walk->state.scatterings > settings.max_scatterings) return false;
  if (walk->state.scatterings == LUCARIUM_PATH_SCATTERING_CAP) {
    walk->state.flags |= PATH_CAPPED;
    return false;
  }
  return true;
}

// The BSDF sample. False when the path ends here.
LUCARIUM_JOIN bool sample_direction(const Scene* scene, PathSettings settings, Walk* walk, const Surface* surface,
                                    const Bsdf* bsdf, const VertexNumbers* numbers, Ray* ray) {
  const DirectionSample u = numbers->direction;
  const BsdfSample sample = sample_bsdf_by(bsdf, numbers->light.lobe, u.direction, &numbers->cosine);
  if (is_black(sample.weight)) return false;
  if (!count_scattering(settings, walk, sample.delta)) return false;
  if (!can_bring_light(settings, walk->state.scatterings, sample.delta)) return false;
  walk->throughput *= sample.weight;
  walk->pdf = sample.pdf;
  if (!is_contribution(walk->throughput)) {
    walk->state.flags |= PATH_BAD;
    return false;
  }
  if (sample.transmitted) walk->state.medium = medium_behind(scene, surface, walk->state.medium);
  const bool eye_side = walk->state.scatterings == 0u;
  // End the path by Russian roulette (Arvo and Kirk 1990), by the root of what it may still bring over what it could
  // before: dark pixels, whose first surface is, need their paths as much as bright ones (docs/measurements/
  // path_tracing.md, Roulette).
  const float importance = max_component(walk->throughput) * medium_squared_ior(scene, walk->state.medium);
  if (eye_side ? walk->state.segment >= settings.eye_roulette_start
               : walk->state.scatterings >= settings.roulette_start) {
    // Facets of glass keep light for thousands of events without loss: a bound below 1 would make its variance
    // infinite.
    const float kept = eye_side ? importance : importance / path_carried(walk->state.flags);
    const float survival = fmin(sample.delta ? 1.0f : 0.95f, sqrt(kept));
    if (u.roulette >= survival) return false;
    walk->throughput /= survival;
  } else if (walk->state.scatterings < settings.roulette_start) {
    walk->state.flags = path_with_carried(walk->state.flags, importance);
  }
  *ray = make_ray(surface, sample.direction, numbers->next_seed);
  walk->next_ends = ray_ends(surface, sample.direction);
  walk->state.segment += 1u;
  return true;
}

bool sees_emission(const Scene* scene, PathSettings settings, uint triangle) {
  return (settings.flags & LUCARIUM_PATH_SEES_TRIANGLES) && may_emit(scene, triangle);
}

// Shades the surface that ray i of the queue has hit. True when the path goes on along `next_ray`.
LUCARIUM_JOIN bool shade_hit(const Scene* scene, PathSettings settings, PathBatch batch, Walk* walk, Hit hit,
                             float3 direction, __global const float* numbers, uint i, __global float4* path_radiance,
                             __global Ray* shadow_ray, __global float4* shadow_light, Ray* next_ray) {
  // Where only more counted scatterings than wanted could follow, the ray was for emitters alone.
  const bool eye_side = walk->state.scatterings == 0u;
  const bool ends = path_ends_here(settings, walk->state);
  if (ends && !sees_emission(scene, settings, hit.triangle)) return false;
  const uint options = settings.flags & LUCARIUM_PATH_GEOMETRIC_NORMALS ? LUCARIUM_SURFACE_GEOMETRIC_NORMALS : 0u;
  const Surface surface = make_surface(scene, hit, direction, options);

  // Attenuate by the volume that the segment ran through.
  walk->state.medium = medium_at(scene, &surface, walk->state.medium);
  walk->throughput *= medium_transmittance(scene, walk->state.medium, hit.distance);

  // Add what the surface emits.
  add_emission(scene, settings, batch, walk, &surface, hit.distance, path_radiance);

  // Scatter.
  if (ends) return false;
  const bool lambert_only = (settings.flags & LUCARIUM_PATH_SECONDARY_LAMBERT) && !eye_side;
  const Bsdf bsdf = make_bsdf(scene, &surface, lambert_only ? LUCARIUM_BSDF_LAMBERT_ONLY : 0u);
  if (bsdf_is_black(&bsdf)) return false;
  const VertexNumbers of_vertex = vertex_numbers(numbers, i);
  walk->side = lit_side(scene, &surface, &bsdf);
  sample_lights(scene, settings, walk, &surface, &bsdf, &of_vertex, shadow_ray, shadow_light);
  return sample_direction(scene, settings, walk, &surface, &bsdf, &of_vertex, next_ray);
}

// Work-item i: ray i of the queue. Writes alive[i], and where it is 1 next_rays[i], next_ends[i] and next_queue[i];
// shadow_rays[i] is inactive where there is no light sample.
__kernel LUCARIUM_FLATTEN void shade_surface(
    LUCARIUM_SCENE_PARAMETERS PathSettings settings, PathBatch batch, __global const Ray* restrict rays,
    __global const Hit* restrict hits, __global const uint* restrict queue, __global const uint* restrict active,
    __global const float* restrict numbers, __global float4* restrict path_throughput,
    __global PathState* restrict path_state, __global uint* restrict path_side, __global float4* restrict path_radiance,
    LUCARIUM_RAY_ENDS_PARAMETER(next_ends) LUCARIUM_RAY_ENDS_PARAMETER(shadow_ends) __global Ray* restrict next_rays,
    __global uint* restrict next_queue, __global uint* restrict alive, __global Ray* restrict shadow_rays,
    __global float4* restrict shadow_light) {
  const uint i = get_global_id(0);
  if (i >= active[0]) return;
  LUCARIUM_SCENE_BIND(scene);
  prefetch_surfaces(&scene, hits, i, active[0]);
  // Load the path's state.
  const Hit hit = hits[i];
  const float3 direction = rays[i].direction.xyz;
  Walk walk;
  walk.path = queue[i];
  walk.state = path_state[walk.path];
  const float4 carried = path_throughput[walk.path];
  walk.throughput = carried.xyz;
  walk.pdf = carried.w;
  const bool by_place = light_tree_in_use(&scene);
  walk.side = by_place ? path_side[walk.path] : LUCARIUM_NONE;
  walk.shadow_ends = walk.next_ends = no_ray_ends();

  // Shade what its ray met: a surface, or the environment, at which every path ends.
  shadow_rays[i] = inactive_ray();
  bool goes_on = false;
  Ray next_ray = inactive_ray();
  if (hit.triangle == LUCARIUM_NO_HIT)
    add_environment(&scene, settings, batch, &walk, rays[i].origin.xyz, direction, path_radiance);
  else
    goes_on = shade_hit(&scene, settings, batch, &walk, hit, direction, numbers, i, path_radiance, &shadow_rays[i],
                        &shadow_light[i], &next_ray);

  // Store the state; dead paths are compacted away by alive.
  alive[i] = goes_on;
  next_rays[i] = next_ray;
  LUCARIUM_STORE_RAY_ENDS(next_ends, i, walk.next_ends);
  LUCARIUM_STORE_RAY_ENDS(shadow_ends, i, walk.shadow_ends);
  next_queue[i] = walk.path;
  path_state[walk.path] = walk.state;
  if (by_place) path_side[walk.path] = walk.side;
  path_throughput[walk.path] = (float4)(walk.throughput, walk.pdf);
}
