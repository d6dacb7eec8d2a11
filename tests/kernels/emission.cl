// SPDX-License-Identifier: Apache-2.0
#include "lucarium/emission.clh"
#include "lucarium/sobol.clh"

// Samples of all lights of some kinds: origins and directions with their densities in w, flux with that of the choice.
kernel void sample_emissions(LUCARIUM_SCENE_PARAMETERS const uint kinds, const uint seed, const uint count,
                             global float4* origins, global float4* directions, global float4* fluxes,
                             global uint* lights) {
  LUCARIUM_SCENE_BIND(scene);
  const uint i = get_global_id(0);
  if (i >= count) return;
  const Sampler sampler = make_sampler(seed, i % 16u, 0u, i / 16u, LUCARIUM_SAMPLER_SOBOL);
  const float4 a = sampler_block(&sampler, 0u), b = sampler_block(&sampler, 1u);
  const Emission e = sample_emission(&scene, b.x, a.xy, a.zw, kinds, 1u);
  origins[i] = (float4)(e.origin, e.pdf.position);
  directions[i] = (float4)(e.direction, e.pdf.direction);
  fluxes[i] = (float4)(e.flux, e.pdf.choice);
  lights[i] = e.light;
}

// The densities again, found from where the rays begin and go to; w: barycentric weights of a triangle's point.
kernel void find_emission_pdfs(LUCARIUM_SCENE_PARAMETERS const uint count, const global float4* origins,
                               const global float4* directions, const global uint* lights, global float4* pdfs,
                               global float2* weights) {
  LUCARIUM_SCENE_BIND(scene);
  const uint i = get_global_id(0);
  if (i >= count) return;
  const uint kind = scene.scene_lights[lights[i]].kind;
  const float3 direction = directions[i].xyz;
  EmissionPdf pdf;
  weights[i] = (float2)(0.0f);
  if (kind == LUCARIUM_LIGHT_TRIANGLE) {
    const uint index = scene.scene_lights[lights[i]].triangle;
    const Triangle t = scene.scene_triangles[index];
    const float3 v0 = scene.scene_vertices[t.v0].position.xyz;
    const float3 e1 = scene.scene_vertices[t.v1].position.xyz - v0, e2 = scene.scene_vertices[t.v2].position.xyz - v0;
    const float3 p = cross(direction, e2), s = origins[i].xyz - v0, q = cross(s, e1);
    Hit hit;
    hit.distance = 0.0f;
    hit.triangle = index;
    hit.u = dot(s, p) / dot(e1, p);
    hit.v = dot(direction, q) / dot(e1, p);
    weights[i] = (float2)(hit.u, hit.v);
    const Surface surface = make_surface(&scene, hit, -direction, 0u);
    pdf = pdf_emission_surface(&scene, &surface);
  } else if (kind == LUCARIUM_LIGHT_ENVIRONMENT) {
    pdf = pdf_emission_environment(&scene, direction);
  } else {
    pdf = pdf_emission_punctual(&scene, lights[i], direction);
  }
  pdfs[i] = (float4)(pdf.choice, pdf.position, pdf.direction, 0.0f);
}

// Points of the unit square, their directions from the first light, a spot (w: density), and the inverses of those.
kernel void sample_spots(LUCARIUM_SCENE_PARAMETERS const uint count, global float2* squares, global float4* directions,
                         global float2* inverses) {
  LUCARIUM_SCENE_BIND(scene);
  const uint i = get_global_id(0);
  if (i >= count) return;
  squares[i] = random_float4(5u, i, 0u).xy;
  const float3 direction = sample_spot(scene.scene_lights, squares[i]);
  directions[i] = (float4)(direction, pdf_spot(scene.scene_lights, direction));
  inverses[i] = invert_spot(scene.scene_lights, direction);
}

// Illuminance [lx] by light samples at the middles of cells x cells squares of the square [-1, 1]^2 at z = -1 that
// faces up.
kernel void light_receiver(LUCARIUM_SCENE_PARAMETERS const uint cells, const uint samples, global float* values) {
  LUCARIUM_SCENE_BIND(scene);
  const uint i = get_global_id(0);
  if (i >= cells * cells) return;
  const float2 place = (convert_float2((uint2)(i % cells, i / cells)) + 0.5f) * (2.0f / (float)cells) - 1.0f;
  float sum = 0.0f;
  for (uint k = 0; k < samples; ++k) {
    const Sampler sampler = make_sampler(7u, i, 0u, k, LUCARIUM_SAMPLER_SOBOL);
    const LightChoiceSample u = sample_light_dimensions(&sampler, 0u);
    const LightSample sample = sample_light(&scene, lit_point((float3)(place, -1.0f), LUCARIUM_NONE), u.choice, u.point,
                                            LUCARIUM_ALL_LIGHTS, 1u);
    if (sample.pdf > 0.0f) sum += sample.radiance.y * fmax(sample.direction.z, 0.0f) / sample.pdf;
  }
  values[i] = sum / (float)samples;
}
