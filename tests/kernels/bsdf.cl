// SPDX-License-Identifier: Apache-2.0
#include "lucarium/bsdf.clh"
#include "lucarium/medium.clh"
#include "lucarium/sobol.clh"
#include "sphere_grid.clh"

// The BSDF of a triangle's middle seen from `view`.
Bsdf bsdf_from(const Scene* scene, uint triangle, float3 view, uint options) {
  const Hit hit = {1.0f, triangle, 0.3f, 0.3f};
  const Surface surface = make_surface(scene, hit, -view, 0u);
  return make_bsdf(scene, &surface, options);
}

// Samples: xyz direction, w pdf; xyz weight, w: 0 smooth, 1 ideal reflection, 2 smooth and 3 ideal transmission.
kernel void sample_directions(LUCARIUM_SCENE_PARAMETERS const uint triangle, const float4 view, const uint options,
                              const uint seed, const uint replicates, const uint count, global float4* directions,
                              global float4* weights) {
  LUCARIUM_SCENE_BIND(scene);
  const uint i = get_global_id(0);
  if (i >= count) return;
  const Bsdf bsdf = bsdf_from(&scene, triangle, view.xyz, options);
  const Sampler sampler = make_sampler(seed, i % replicates, 0u, i / replicates,
                                       replicates == 1u ? LUCARIUM_SAMPLER_RANDOM : LUCARIUM_SAMPLER_SOBOL);
  const BsdfSample sample = sample_bsdf(&bsdf, sample_light_dimensions(&sampler, 0u).lobe,
                                        sample_direction_dimensions(&sampler, 0u).direction);
  directions[i] = (float4)(sample.direction, sample.pdf);
  weights[i] = (float4)(sample.weight, (float)(sample.delta + 2u * sample.transmitted));
}

kernel void integrate_density(LUCARIUM_SCENE_PARAMETERS const uint triangle, const float4 view, const uint columns,
                              const uint rows, global float* masses) {
  LUCARIUM_SCENE_BIND(scene);
  const uint index = get_global_id(0);
  if (index >= columns * rows) return;
  const Bsdf bsdf = bsdf_from(&scene, triangle, view.xyz, 0u);
  const GridCell cell = grid_cell(index, columns, rows);
  float mass = 0.0f;
#define DENSITY(direction) pdf_bsdf(&bsdf, direction)
  INTEGRATE_CELL(mass, cell, DENSITY)
  masses[index] = mass;
}

// Weights of samples for cosine-distributed views; radiance of transmitted ones counted per squared index.
// `back`: views of the back instead.
kernel void sample_cosine_views(LUCARIUM_SCENE_PARAMETERS const uint triangle, const uint back, const uint seed,
                                const uint replicates, const uint count, global float4* weights) {
  LUCARIUM_SCENE_BIND(scene);
  const uint i = get_global_id(0);
  if (i >= count) return;
  const Sampler sampler = make_sampler(seed, i % replicates, 0u, i / replicates, LUCARIUM_SAMPLER_SOBOL);
  float3 view = sample_cosine_hemisphere(sample_camera_dimensions(&sampler).film);
  if (back) view.z = -view.z;
  const Bsdf bsdf = bsdf_from(&scene, triangle, view, 0u);
  const BsdfSample sample = sample_bsdf(&bsdf, sample_light_dimensions(&sampler, 0u).lobe,
                                        sample_direction_dimensions(&sampler, 0u).direction);
  const float scale = sample.transmitted ? 1.0f / (bsdf.eta * bsdf.eta) : 1.0f;
  weights[i] = (float4)(sample.weight * scale, 0.0f);
}

// For random pairs of directions: f(v, l) / eta_v^2 and f(l, v) / eta_l^2, green; eta of the side of each.
kernel void evaluate_both_ways(LUCARIUM_SCENE_PARAMETERS const uint triangle, const uint seed, const uint count,
                               global float2* values) {
  LUCARIUM_SCENE_BIND(scene);
  const uint i = get_global_id(0);
  if (i >= count) return;
  const float4 u = random_float4(seed, i, 0u);
  const float3 v = sample_uniform_sphere(u.xy), l = sample_uniform_sphere(u.zw);
  const Bsdf from_v = bsdf_from(&scene, triangle, v, 0u), from_l = bsdf_from(&scene, triangle, l, 0u);
  const uint instance = scene.scene_triangles[triangle].instance;
  const global Material* material = scene.scene_materials + scene.scene_instances[instance].material;
  const bool volume = (material->flags & LUCARIUM_MATERIAL_TRANSMISSIVE) && !(material->flags & LUCARIUM_MATERIAL_THIN);
  const float eta_v = volume && v.z < 0.0f ? material->ior : 1.0f, eta_l = volume && l.z < 0.0f ? material->ior : 1.0f;
  const float cos_l = fabs(dot(from_v.n_s, l)), cos_v = fabs(dot(from_l.n_s, v));
  values[i] =
      (float2)(eval_bsdf(&from_v, l).y / (cos_l * eta_v * eta_v), eval_bsdf(&from_l, v).y / (cos_v * eta_l * eta_l));
}

// The value of one pair, and the density: xyz f |n_s.l|, w pdf.
kernel void evaluate_pair(LUCARIUM_SCENE_PARAMETERS const uint triangle, const float4 view, const float4 light,
                          const uint options, global float4* value) {
  LUCARIUM_SCENE_BIND(scene);
  const Bsdf bsdf = bsdf_from(&scene, triangle, view.xyz, options);
  float pdf;
  const float3 f = eval_bsdf_pdf(&bsdf, light.xyz, &pdf);
  value[0] = (float4)(f, pdf);
}

// A ray of `metres` through `medium` meets the triangle: transmittance xyz; in w 0 for air behind it, else 1 +
// material.
kernel void cross_medium(LUCARIUM_SCENE_PARAMETERS const uint triangle, const float4 view, const uint medium,
                         const float metres, global float4* value) {
  LUCARIUM_SCENE_BIND(scene);
  const Hit hit = {metres, triangle, 0.3f, 0.3f};
  const Surface surface = make_surface(&scene, hit, -view.xyz, 0u);
  const uint here = medium_at(&scene, &surface, medium), behind = medium_behind(&scene, &surface, here);
  value[0] =
      (float4)(medium_transmittance(&scene, here, metres), behind == LUCARIUM_NONE ? 0.0f : 1.0f + (float)behind);
}

// The albedo table: x, y directional (E1, B), z, w their averages.
kernel void read_albedo_table(const global float* scene_albedo_table, const uint count, const float mu,
                              global float4* values) {
  const uint i = get_global_id(0);
  if (i >= count) return;
  const float roughness = (float)i / (float)(count - 1u);
  values[i] = (float4)(specular_albedo_directional(scene_albedo_table, mu, roughness),
                       specular_albedo_average(scene_albedo_table, roughness));
}
