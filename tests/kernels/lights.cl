// SPDX-License-Identifier: Apache-2.0
#include "lucarium/lights.clh"
#include "lucarium/sobol.clh"
// Densities that jump: no slivers missed, but no use in refining for ever.
#define GRID_MIN 48u
#define GRID_MAX 96u
#include "sphere_grid.clh"

// Samples of the mixture for a point: xyz direction, w pdf; xyz radiance, w: 1 punctual, 2 at infinity; end points.
kernel void sample_lights(LUCARIUM_SCENE_PARAMETERS const float4 position, const uint kinds, const uint seed,
                          const uint ray_seed, const uint count, global float4* directions, global float4* radiances,
                          global float4* ends) {
  LUCARIUM_SCENE_BIND(scene);
  const uint i = get_global_id(0);
  if (i >= count) return;
  const Sampler sampler = make_sampler(seed, i % 16u, 0u, i / 16u, LUCARIUM_SAMPLER_SOBOL);
  const LightChoiceSample u = sample_light_dimensions(&sampler, 0u);
  const LightSample sample =
      sample_light(&scene, lit_point(position.xyz, LUCARIUM_NONE), u.choice, u.point, kinds, ray_seed);
  directions[i] = (float4)(sample.direction, sample.pdf);
  radiances[i] = (float4)(sample.radiance, (float)(sample.punctual + 2u * sample.infinite));
  ends[i] = (float4)(sample.end, 0.0f);
}

// One sample per point: radiance (of a punctual light: illuminance) over pdf, and the direction's third component.
kernel void illuminate_points(LUCARIUM_SCENE_PARAMETERS const global float4* positions, const uint count,
                              global float4* values) {
  LUCARIUM_SCENE_BIND(scene);
  const uint i = get_global_id(0);
  if (i >= count) return;
  const LightSample sample =
      sample_light(&scene, lit_point(positions[i].xyz, LUCARIUM_NONE), 0.5f, (float2)(0.5f), LUCARIUM_ALL_LIGHTS, 1u);
  values[i] = sample.pdf > 0.0f ? (float4)(sample.radiance / sample.pdf, sample.direction.z) : (float4)(0.0f);
}

// What a ray from `position` meets: density of the light mixture, and the light from there. Nearest triangle by plain
// Moeller-Trumbore over the scene.
float met_density(const Scene* scene, float3 position, float3 direction, float3* radiance) {
  Hit nearest = {INFINITY, LUCARIUM_NO_HIT, 0.0f, 0.0f};
  for (uint i = 0; i < scene->scene_info->triangle_count; ++i) {
    const Triangle t = scene->scene_triangles[i];
    const float3 v0 = scene->scene_vertices[t.v0].position.xyz;
    const float3 e1 = scene->scene_vertices[t.v1].position.xyz - v0, e2 = scene->scene_vertices[t.v2].position.xyz - v0;
    const float3 p = cross(direction, e2), s = position - v0, q = cross(s, e1);
    const float inverse = 1.0f / dot(e1, p);
    const float u = dot(s, p) * inverse, v = dot(direction, q) * inverse, d = dot(e2, q) * inverse;
    if (u >= 0.0f && v >= 0.0f && u + v <= 1.0f && d > 0.0f && d < nearest.distance) {
      nearest.distance = d;
      nearest.triangle = i;
      nearest.u = u;
      nearest.v = v;
    }
  }
  if (nearest.triangle == LUCARIUM_NO_HIT) {
    *radiance = environment_radiance(scene, direction);
    return pdf_light_environment(scene, lit_point(position, LUCARIUM_NONE), direction);
  }
  const Surface surface = make_surface(scene, nearest, direction, 0u);
  *radiance = emitted_radiance(scene, &surface);
  return pdf_light_surface(scene, &surface, nearest.distance, LUCARIUM_NONE);
}

kernel void integrate_light_density(LUCARIUM_SCENE_PARAMETERS const float4 position, const uint columns,
                                    const uint rows, global float* masses) {
  LUCARIUM_SCENE_BIND(scene);
  const uint index = get_global_id(0);
  if (index >= columns * rows) return;
  const GridCell cell = grid_cell(index, columns, rows);
  float mass = 0.0f;
  float3 radiance;
#define DENSITY(direction) met_density(&scene, position.xyz, direction, &radiance)
  INTEGRATE_CELL(mass, cell, DENSITY)
  masses[index] = mass;
}

// Along given directions: xyz light met, w density.
kernel void meet_lights(LUCARIUM_SCENE_PARAMETERS const float4 position, const global float4* directions,
                        const uint count, global float4* values) {
  LUCARIUM_SCENE_BIND(scene);
  const uint i = get_global_id(0);
  if (i >= count) return;
  float3 radiance;
  const float pdf = met_density(&scene, position.xyz, directions[i].xyz, &radiance);
  values[i] = (float4)(radiance, pdf);
}

kernel void lookup_environment(LUCARIUM_SCENE_PARAMETERS const global float4* directions, const uint count,
                               global float4* values) {
  LUCARIUM_SCENE_BIND(scene);
  const uint i = get_global_id(0);
  if (i < count) values[i] = (float4)(environment_radiance(&scene, directions[i].xyz), 0.0f);
}

kernel void choose_lights(LUCARIUM_SCENE_PARAMETERS const uint count, global uint* lights, global float* pmfs) {
  LUCARIUM_SCENE_BIND(scene);
  const uint i = get_global_id(0);
  if (i >= count) return;
  float pmf;
  lights[i] = choose_light(&scene, ((float)i + 0.5f) / (float)count, hash_uint2(i, 7u), &pmf);
  pmfs[i] = pmf;
}

// The same with random u of 24 bits, as samplers give it.
kernel void choose_lights_at_random(LUCARIUM_SCENE_PARAMETERS const uint count, global uint* lights) {
  LUCARIUM_SCENE_BIND(scene);
  const uint i = get_global_id(0);
  if (i >= count) return;
  float pmf;
  lights[i] = choose_light(&scene, uint_to_unit(hash_uint2(i, 3u)), hash_uint2(i, 7u), &pmf);
}
