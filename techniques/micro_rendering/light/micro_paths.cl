// SPDX-License-Identifier: Apache-2.0
// Paths from the lights: emission, and at every diffuse hit a vertex that is kept as a photon or as a virtual point
// light (Keller 1997; Jensen 1996). A path that hits something else than diffuse ends.
//
// Normals. The path tracer's irradiance has the cosine to the shading normal, but as many paths arrive at a surface as
// its geometric normal lets in, and leave it as they are spread about that normal. So what arrives is weighted by the
// ratio of the two cosines, and paths go on about the geometric normal (the adjoint BSDF of Veach 1996, "Non-symmetric
// scattering in light transport algorithms").
#include "lucarium/lights.clh"
#include "lucarium/shared/gbuffer.h"
#include "lucarium/sobol.clh"
#include "micro_rendering/gather/micro_surface.clh"
#include "micro_rendering/tree/micro_node.clh"

#define MICRO_PATH_STREAM 0x6d706174u

typedef struct Emission {
  float3 origin, direction;
  float3 power;  // flux / density [lm]; black: no path
} Emission;

// A point of the disc about the scene that faces `direction`, as far outside as the scene is large.
float3 outside_point(const Scene* scene, float3 direction, float2 u) {
  const float3 center = 0.5f * (scene->scene_info->bounds_min.xyz + scene->scene_info->bounds_max.xyz);
  const float radius = scene->scene_info->bounds_max.w;
  const Basis basis = make_basis(direction);
  const float2 p = radius * sample_disk(u);
  return center - radius * direction + p.x * basis.t + p.y * basis.b;
}

Emission emit_from_triangle(const Scene* scene, const global Light* light, float2 u, float2 v) {
  Emission e;
  const Triangle triangle = scene->scene_triangles[light->triangle];
  const global Material* material = scene->scene_materials + scene->scene_instances[triangle.instance].material;
  const float2 weights = sample_triangle(u);
  Hit hit;
  hit.distance = 0.0f;
  hit.triangle = light->triangle;
  hit.u = weights.x;
  hit.v = weights.y;
  const float3 normal =
      geometric_normal(scene->scene_vertices[triangle.v0].position.xyz, scene->scene_vertices[triangle.v1].position.xyz,
                       scene->scene_vertices[triangle.v2].position.xyz, (float3)(0.0f, 0.0f, 1.0f));
  // Both sides of a two-sided emitter, chosen by chance.
  const bool two_sided = material->flags & (LUCARIUM_MATERIAL_DOUBLE_SIDED | LUCARIUM_MATERIAL_TRANSMISSIVE);
  const bool back = two_sided && v.x < 0.5f;
  if (two_sided) v.x = v.x < 0.5f ? 2.0f * v.x : 2.0f * v.x - 1.0f;
  const Surface surface = make_surface(scene, hit, back ? normal : -normal, 0u);
  const Basis basis = make_basis(surface.n_g);
  e.direction = to_world(&basis, sample_cosine_hemisphere(v));
  e.origin = ray_origin(&surface, e.direction);
  e.power = emitted_radiance(scene, &surface) * (M_PI_F * light->position.w * (two_sided ? 2.0f : 1.0f));
  if (material->flags & (LUCARIUM_MATERIAL_MASK | LUCARIUM_MATERIAL_BLEND))
    e.power *= coverage_at(scene, light->triangle, weights.x, weights.y);
  return e;
}

Emission emit_light(const Scene* scene, float u_choice, float2 u, float2 v) {
  Emission e;
  e.origin = e.power = (float3)(0.0f);
  e.direction = (float3)(0.0f, 0.0f, 1.0f);
  if (scene->scene_info->light_count == 0u) return e;
  float pmf;
  const global Light* light =
      scene->scene_lights + choose_light(scene, u_choice, hash_uint2(as_uint(u.x), as_uint(v.x)), &pmf);
  const float disc = M_PI_F * sqr(scene->scene_info->bounds_max.w);
  if (light->kind == LUCARIUM_LIGHT_TRIANGLE) {
    e = emit_from_triangle(scene, light, u, v);
  } else if (light->kind == LUCARIUM_LIGHT_POINT) {
    e.origin = light->position.xyz;
    e.direction = sample_uniform_sphere(u);
    e.power = light->intensity.xyz * (4.0f * M_PI_F);
  } else if (light->kind == LUCARIUM_LIGHT_SPOT) {
    const Basis basis = make_basis(light->direction.xyz);
    const float cos_outer = clamp(light->spot_cos_outer, -1.0f, 1.0f - 1e-6f);
    e.origin = light->position.xyz;
    e.direction = to_world(&basis, sample_cone(u, cos_outer));
    e.power = light->intensity.xyz *
              (2.0f * M_PI_F * (1.0f - cos_outer) * spot_falloff(light, dot(e.direction, light->direction.xyz)));
  } else if (light->kind == LUCARIUM_LIGHT_DIRECTIONAL) {
    e.direction = light->direction.xyz;
    e.origin = outside_point(scene, e.direction, u);
    e.power = light->intensity.xyz * disc;
  } else {
    float pdf;
    e.direction = -sample_environment(scene, v, &pdf);
    e.origin = outside_point(scene, e.direction, u);
    if (pdf > 0.0f) e.power = environment_radiance(scene, -e.direction) * (disc / pdf);
  }
  e.power /= pmf;
  return e;
}

// powers: flux that path i carries, of `count` paths [lm].
__kernel void mr_emit(LUCARIUM_SCENE_PARAMETERS const uint count, const uint frame, const uint seed,
                      __global Ray* restrict rays, __global float4* restrict powers, const uint slice_base) {
  const uint i = slice_base + get_global_id(0);
  if (i >= count) return;
  LUCARIUM_SCENE_BIND(scene);
  const Sampler sampler = make_sampler(MICRO_PATH_STREAM, frame, seed, i, LUCARIUM_SAMPLER_SOBOL);
  const float4 a = sampler_block(&sampler, 0u), b = sampler_block(&sampler, 1u);
  const Emission e = emit_light(&scene, b.x, a.xy, a.zw);
  const bool black = is_black(e.power);
  Ray ray;
  ray.origin = (float4)(e.origin, as_float(make_ray_seed(hash_uint3(seed, frame, i))));
  ray.direction = (float4)(e.direction, black ? -1.0f : INFINITY);
  rays[i] = ray;
  powers[i] = (float4)(e.power / (float)count, 0.0f);
}

// Vertex `vertex` (from 0) of path i, and its next ray. keep: it becomes photons[slot * count + i]; `reflected`: with
// the flux that it reflects instead of the one that arrives.
__kernel void mr_path_vertex(LUCARIUM_SCENE_PARAMETERS const uint count, const uint frame, const uint seed,
                             const uint vertex, const uint keep, const uint slot, const uint reflected,
                             __global const Hit* restrict hits, __global Ray* restrict rays,
                             __global float4* restrict powers, __global MicroPhoton* restrict photons,
                             const uint slice_base) {
  const uint i = slice_base + get_global_id(0);
  if (i >= count) return;
  LUCARIUM_SCENE_BIND(scene);
  MicroPhoton photon;
  photon.position = (float4)(0.0f);
  photon.power = (float4)(0.0f);
  Ray ray = rays[i];
  const Hit hit = hits[i];
  const bool active = ray.direction.w >= 0.0f && hit.triangle != LUCARIUM_NO_HIT;
  ray.direction.w = -1.0f;
  if (active) {
    const Surface surface = make_surface(&scene, hit, ray.direction.xyz, 0u);
    const float3 albedo = leaf_diffuse(&scene, &surface);
    const float shaded = dot(surface.n_s, surface.view), met = dot(surface.n_g, surface.view);
    if (!is_black(albedo) && shaded > 0.0f && met > 0.0f) {
      const float3 power = powers[i].xyz * (shaded / fmax(met, 1e-4f));
      photon.position = (float4)(surface.position, as_float(pack_direction(surface.n_s)));
      photon.power = (float4)(reflected ? albedo * power : power, as_float(pack_direction(surface.n_g)));
      const Sampler sampler = make_sampler(MICRO_PATH_STREAM, frame, seed, i, LUCARIUM_SAMPLER_SOBOL);
      const Basis basis = make_basis(surface.n_g);
      const float3 direction = to_world(&basis, sample_cosine_hemisphere(sampler_block(&sampler, 2u + vertex).xy));
      if (dot(direction, surface.n_s) > 0.0f) {
        ray = make_ray(&surface, direction, make_ray_seed(hash_uint3(seed ^ vertex, frame, i)));
        powers[i] = (float4)(albedo * power, 0.0f);
      }
    }
  }
  rays[i] = ray;
  if (keep) photons[slot * count + i] = photon;
}

// ---- instant radiosity

// The irradiance that one virtual light brings if nothing is between, and the shadow ray. most: bound of the geometry
// term cos cos / d² [1/m²].
float3 virtual_light_at(const Surface* surface, const global MicroPhoton* light, float most, uint ray_seed, Ray* ray) {
  ray->origin = (float4)(0.0f);
  ray->direction = (float4)(0.0f, 0.0f, 1.0f, -1.0f);
  const MicroPhoton photon = *light;
  if (is_black(photon.power.xyz)) return (float3)(0.0f);
  const float3 between = photon.position.xyz - surface->position;
  const float distance2 = dot(between, between);
  const float3 direction = between * rsqrt(fmax(distance2, 1e-30f));
  const float here = dot(surface->n_s, direction), there = -dot(unpack_direction(as_uint(photon.power.w)), direction);
  if (here <= 0.0f || there <= 0.0f || dot(surface->n_g, direction) <= 0.0f) return (float3)(0.0f);
  if (dot(unpack_direction(as_uint(photon.position.w)), direction) >= 0.0f) return (float3)(0.0f);
  LightSample sample = no_light_sample();
  sample.direction = direction;
  sample.end = photon.position.xyz - (surface->ray_offset + 1e-4f * sqrt(distance2)) * direction;
  *ray = make_shadow_ray(surface, &sample, ray_seed);
  if (ray->direction.w < 0.0f) return (float3)(0.0f);
  return photon.power.xyz * (M_1_PI_F * fmin(here * there / distance2, most));
}

// Shadow rays from all leaves to one virtual light. seed: another one for every frame.
__kernel void mr_virtual_light(LUCARIUM_SCENE_PARAMETERS __global const MicroLeaf* restrict leaves, const uint count,
                               __global const MicroPhoton* restrict photons, const uint light, const uint seed,
                               const float most, __global Ray* restrict shadow_rays,
                               __global float4* restrict shadow_light, const uint slice_base) {
  const uint i = slice_base + get_global_id(0);
  if (i >= count) return;
  LUCARIUM_SCENE_BIND(scene);
  const Surface surface = leaf_surface(&scene, leaves[i]);
  Ray ray;
  shadow_light[i] =
      (float4)(virtual_light_at(&surface, photons + light, most, make_ray_seed(hash_uint3(seed, light, i)), &ray),
               0.0f);
  shadow_rays[i] = ray;
}

// The same from the points of a G-buffer (final_gather=off).
__kernel void mr_virtual_light_at_pixels(LUCARIUM_SCENE_PARAMETERS __global const GBufferPoint* restrict points,
                                         const uint count, __global const MicroPhoton* restrict photons,
                                         const uint light, const uint seed, const float most,
                                         __global Ray* restrict shadow_rays, __global float4* restrict shadow_light,
                                         const uint slice_base) {
  const uint i = slice_base + get_global_id(0);
  if (i >= count) return;
  LUCARIUM_SCENE_BIND(scene);
  Ray ray;
  ray.origin = (float4)(0.0f);
  ray.direction = (float4)(0.0f, 0.0f, 1.0f, -1.0f);
  float3 irradiance = (float3)(0.0f);
  if (points[i].state == LUCARIUM_GBUFFER_SURFACE) {
    Hit hit;
    hit.distance = points[i].position.w;
    hit.triangle = points[i].triangle;
    hit.u = points[i].u;
    hit.v = points[i].v;
    const Surface surface = make_surface(&scene, hit, -points[i].view.xyz, 0u);
    irradiance = virtual_light_at(&surface, photons + light, most, make_ray_seed(hash_uint3(seed, light, i)), &ray);
  }
  shadow_light[i] = (float4)(irradiance, 0.0f);
  shadow_rays[i] = ray;
}

// ---- photon map

int3 photon_cell(float3 p, float cell) { return convert_int3_rtn(p / cell); }
uint photon_bucket(int3 c, uint mask) {
  return hash_uint((uint)c.x * 73856093u ^ (uint)c.y * 19349663u ^ (uint)c.z * 83492791u) & mask;
}

// keys: bucket of photon i, mask + 1 for one that is none.
__kernel void mr_photon_keys(__global const MicroPhoton* restrict photons, const uint count, const float cell,
                             const uint mask, __global uint* restrict keys, __global uint* restrict values) {
  const uint i = get_global_id(0);
  if (i >= count) return;
  values[i] = i;
  keys[i] =
      !is_black(photons[i].power.xyz) ? photon_bucket(photon_cell(photons[i].position.xyz, cell), mask) : mask + 1u;
}

// starts[b]: first of the sorted photons whose bucket is b or higher, for b <= mask + 1.
__kernel void mr_bucket_starts(__global const uint* restrict keys, const uint count, const uint mask,
                               __global uint* restrict starts) {
  const uint i = get_global_id(0);
  if (i > count) return;
  const uint from = i == 0u ? 0u : keys[i - 1u] + 1u, to = i == count ? mask + 1u : keys[i];
  for (uint b = from; b <= to; ++b) starts[b] = i;
}

typedef struct NearestPhotons {
  float distance2[MICRO_MOST_PHOTONS];
  uint photon[MICRO_MOST_PHOTONS];
  uint count;
} NearestPhotons;

// Keeps the `most` nearest in a heap whose first is the farthest.
void keep_photon(NearestPhotons* heap, uint most, float distance2, uint photon) {
  uint i;
  if (heap->count < most) {
    for (i = heap->count++; i > 0u; i = (i - 1u) / 2u) {
      const uint parent = (i - 1u) / 2u;
      if (heap->distance2[parent] >= distance2) break;
      heap->distance2[i] = heap->distance2[parent];
      heap->photon[i] = heap->photon[parent];
    }
  } else {
    if (distance2 >= heap->distance2[0]) return;
    i = 0u;
    for (uint child = 1u; child < most; child = 2u * i + 1u) {
      if (child + 1u < most && heap->distance2[child + 1u] > heap->distance2[child]) ++child;
      if (heap->distance2[child] <= distance2) break;
      heap->distance2[i] = heap->distance2[child];
      heap->photon[i] = heap->photon[child];
      i = child;
    }
  }
  heap->distance2[i] = distance2;
  heap->photon[i] = photon;
}

// Adds the irradiance of the photons about leaf i: those within the distance of the `most`-th nearest one, without that
// one (which makes the estimate unbiased for photons that lie at random), or all within `cell` where there are fewer.
__kernel void mr_photon_density(LUCARIUM_SCENE_PARAMETERS __global const MicroLeaf* restrict leaves, const uint count,
                                __global const MicroPhoton* restrict photons, __global const uint* restrict values,
                                __global const uint* restrict starts, const float cell, const uint mask,
                                const uint most, __global float4* restrict irradiance, const uint slice_base) {
  const uint i = slice_base + get_global_id(0);
  if (i >= count) return;
  LUCARIUM_SCENE_BIND(scene);
  const Surface surface = leaf_surface(&scene, leaves[i]);
  const int3 center = photon_cell(surface.position, cell);
  NearestPhotons heap;
  heap.count = 0u;
  for (int z = -1; z <= 1; ++z) {
    for (int y = -1; y <= 1; ++y) {
      for (int x = -1; x <= 1; ++x) {
        const int3 c = center + (int3)(x, y, z);
        const uint bucket = photon_bucket(c, mask);
        for (uint k = starts[bucket]; k < starts[bucket + 1u]; ++k) {
          const float4 p = photons[values[k]].position;
          const float3 d = p.xyz - surface.position;
          const float distance2 = dot(d, d);
          if (distance2 > cell * cell || any(photon_cell(p.xyz, cell) != c)) continue;
          if (dot(unpack_direction(as_uint(p.w)), surface.n_s) > 0.5f) keep_photon(&heap, most, distance2, values[k]);
        }
      }
    }
  }
  const bool full = heap.count == most;
  const float radius2 = full ? heap.distance2[0] : cell * cell;
  if (radius2 <= 0.0f) return;
  float3 sum = (float3)(0.0f);
  for (uint k = full ? 1u : 0u; k < heap.count; ++k) sum += photons[heap.photon[k]].power.xyz;
  irradiance[i] += (float4)(sum / (M_PI_F * radius2), 0.0f);
}
