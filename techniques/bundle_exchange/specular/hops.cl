// SPDX-License-Identifier: Apache-2.0
// Chains of specular vertices: from slots towards a bundle's direction, and from what the camera sees. At every vertex
// the atlas gives the diffuse light, so a chain only follows specular lobes. Each target has one chain at a time.
#include "bundle_exchange/exchange/exchange_layout.clh"
#include "bundle_exchange/pixels/pixel_lobes.clh"
#include "bundle_exchange/specular/hop_chain.clh"
#include "lucarium/atlas_surface.clh"
#include "lucarium/gbuffer.clh"
#include "lucarium/scene.clh"
#include "lucarium/surface_atlas.clh"

// Adds light that has been scattered `scatterings` times before it arrives at the target.
void add_gain(global float4* gain, HopSettings settings, uint target, uint scatterings, float3 light) {
  size_t index = target;
  if (settings.gains == HOP_GAIN_CHANNELS) index = (size_t)target * BUNDLE_REFLECTED + scatterings - 1u;
  if (settings.gains == HOP_GAIN_LAYERS) index = 2u * (size_t)target + (scatterings > 1u);
  gain[index].xyz += light;
}

// Which entries of the list of specular slots get a chain: each with its own probability. Clears all gains.
__kernel void choose_slots(uint count, __global const float* restrict probabilities, HopSettings settings,
                           __global uint* restrict chosen, __global float4* restrict gain) {
  const uint i = get_global_id(0);
  if (i >= count) return;
  for (uint k = 0u; k < BUNDLE_REFLECTED; ++k) gain[(size_t)i * BUNDLE_REFLECTED + k] = (float4)(0.0f);
  chosen[i] = uint_to_unit(hash_uint3(settings.seed, i, 0x73686172u)) < probabilities[i];
}

// Work-item i: entry queue[i] of the list, seen from the one of the directions `omega` and -omega that is on its side.
__kernel void begin_slot_hops(LUCARIUM_SCENE_PARAMETERS AtlasInfo atlas_info,
                              __global const AtlasTexel* restrict atlas_texels, __global const uint* restrict list,
                              __global const float* restrict probabilities, float4 omega, HopSettings settings,
                              __global Hop* restrict hops, __global Ray* restrict rays,
                              __global const uint* restrict queue, __global const uint* restrict active,
                              __global Ray* restrict shadow_rays, __global float4* restrict shadow_light) {
  const uint i = get_global_id(0);
  if (i >= active[0]) return;
  LUCARIUM_SCENE_BIND(scene);
  const uint target = queue[i], slot = list[target];
  const AtlasTexel texel = atlas_texels[slot];
  Surface surface = atlas_surface(&scene, atlas_info, slot, texel.triangle, texel.b1, texel.b2);
  // The viewer stands where the slot's side can be seen from.
  surface.view = dot(surface.n_g, omega.xyz) > 0.0f ? omega.xyz : -omega.xyz;
  const Bsdf full = make_bsdf(&scene, &surface, 0u), bsdf = specular_part(full);
  Hop hop;
  hop.throughput = (float4)((float3)(1.0f / probabilities[target]), 0.0f);
  hop.target = target;
  hop.hops = 0u;
  hop.medium = medium_at(&scene, &surface, LUCARIUM_NONE);
  Ray ray = inactive_ray(), shadow_ray = ray;
  float3 light = (float3)(0.0f);
  if (!settings.lit || !sample_punctual(&scene, settings, &surface, &bsdf, &hop, &light, &shadow_ray))
    shadow_ray = inactive_ray();
  if (!sample_hop(&scene, settings, &surface, &bsdf, &hop, &ray)) ray = inactive_ray();
  hops[target] = hop;
  rays[i] = ray;
  shadow_rays[i] = shadow_ray;
  shadow_light[i] = (float4)(light, as_float(1u));
}

// Work-item i: pixel i. `whole`: the diffuse lobe is sampled too, instead of being looked up at the pixel. alpha_most:
// bundles gather for reflection lobes from this width on, so that no chain begins there.
__kernel void begin_pixel_hops(LUCARIUM_SCENE_PARAMETERS __global const GBufferPoint* restrict points, uint count,
                               uint whole, float alpha_most, HopSettings settings, __global float4* restrict gain,
                               __global Hop* restrict hops, __global Ray* restrict rays, __global uint* restrict queue,
                               __global uint* restrict active) {
  const uint i = get_global_id(0);
  if (i == 0u) active[0] = count;
  if (i >= count) return;
  LUCARIUM_SCENE_BIND(scene);
  gain[2u * i] = gain[2u * i + 1u] = (float4)(0.0f);
  queue[i] = i;
  Ray ray = inactive_ray();
  const GBufferPoint point = points[i];
  if (point.state == LUCARIUM_GBUFFER_SURFACE) {
    const Surface surface = gbuffer_surface(&scene, point);
    const Bsdf full = make_bsdf(&scene, &surface, 0u);
    Bsdf bsdf = full;
    if (!whole) bsdf = lobe_is_wide(&full, alpha_most) ? black_bsdf(&surface) : specular_part(full);
    Hop hop;
    hop.throughput = (float4)(point.throughput.xyz, 0.0f);
    hop.target = i;
    hop.hops = 0u;
    hop.medium = gbuffer_medium(point);
    // Ideal lobes belong to the G-buffer's path.
    const uint2 before =
        (uint2)(bsdf.flags & LUCARIUM_BSDF_DELTA_REFLECTION, bsdf.flags & LUCARIUM_BSDF_DELTA_TRANSMISSION);
    if (before.x) bsdf.f0 = (float3)(0.0f), bsdf.f90 = 0.0f;
    if (before.y) bsdf.transmission = (float3)(0.0f);
    if (before.x | before.y) choose_lobe_probabilities(&bsdf);
    if (!sample_hop(&scene, settings, &surface, &bsdf, &hop, &ray)) ray = inactive_ray();
    hops[i] = hop;
  }
  rays[i] = ray;
}

// Work-item i: ray i of the queue has found hits[i]. Adds emitted and diffuse light, and goes on if a specular lobe
// does. diffuse: what slots send by their diffuse lobe, BUNDLE_REFLECTED channels each.
__kernel void advance_hops(LUCARIUM_SCENE_PARAMETERS AtlasInfo atlas_info,
                           __global const AtlasTriangle* restrict atlas_triangles,
                           __global const uint* restrict atlas_table, __global const float4* restrict diffuse,
                           HopSettings settings, __global const Ray* restrict rays, __global const Hit* restrict hits,
                           __global const uint* restrict queue, __global const uint* restrict active,
                           __global Hop* restrict hops, __global float4* restrict gain,
                           __global Ray* restrict next_rays, __global uint* restrict next_queue,
                           __global uint* restrict alive, __global Ray* restrict shadow_rays,
                           __global float4* restrict shadow_light) {
  const uint i = get_global_id(0);
  if (i >= active[0]) return;
  LUCARIUM_SCENE_BIND(scene);
  const Ray ray = rays[i];
  const uint target = queue[i];
  const Hit hit = hits[i];
  Ray next = inactive_ray(), shadow_ray = next;
  float3 light = (float3)(0.0f);
  uint light_scatterings = 0u;
  bool goes_on = false;
  if (ray_is_active(ray)) {
    Hop hop = hops[target];
    const float3 direction = ray.direction.xyz;
    const bool counts = settings.lit && hop.hops >= settings.first_light;
    if (hit.triangle == LUCARIUM_NO_HIT) {
      if (counts)
        add_gain(gain, settings, target, hop.hops, hop.throughput.xyz * environment_radiance(&scene, direction));
    } else {
      const Surface surface = make_surface(&scene, hit, direction, 0u);
      hop.medium = medium_at(&scene, &surface, hop.medium);
      hop.throughput.xyz *= medium_transmittance(&scene, hop.medium, hit.distance);
      if (counts) add_gain(gain, settings, target, hop.hops, hop.throughput.xyz * emitted_radiance(&scene, &surface));
      const uint slot = atlas_side(atlas_info, atlas_texel(atlas_triangles, atlas_table, hit.triangle, hit.u, hit.v),
                                   surface.flags & LUCARIUM_SURFACE_FRONT);
      if (slot != LUCARIUM_NONE) {
        for (uint k = 0u;
             k < BUNDLE_REFLECTED && (settings.limit == LUCARIUM_NONE || k + 1u + hop.hops <= settings.limit); ++k)
          add_gain(gain, settings, target, k + 1u + hop.hops,
                   hop.throughput.xyz * diffuse[(size_t)slot * BUNDLE_REFLECTED + k].xyz);
        const Bsdf full = make_bsdf(&scene, &surface, 0u), bsdf = specular_part(full);
        light_scatterings = hop.hops + 1u;
        const bool lit = settings.lit && light_scatterings <= min(settings.limit, settings.most_hops) &&
                         sample_punctual(&scene, settings, &surface, &bsdf, &hop, &light, &shadow_ray);
        if (!lit) shadow_ray = inactive_ray();
        goes_on = sample_hop(&scene, settings, &surface, &bsdf, &hop, &next);
        hops[target] = hop;
      }
    }
  }
  alive[i] = goes_on;
  next_rays[i] = next;
  next_queue[i] = target;
  shadow_rays[i] = shadow_ray;
  shadow_light[i] = (float4)(light, as_float(light_scatterings));
}

// What shadow rays have let through.
__kernel void add_punctual(HopSettings settings, __global const uint* restrict queue,
                           __global const uint* restrict active, __global const Ray* restrict shadow_rays,
                           __global const float4* restrict shadow_light, __global const uint* restrict occluded,
                           __global float4* restrict gain) {
  const uint i = get_global_id(0);
  if (i >= active[0] || occluded[i] || !ray_is_active(shadow_rays[i])) return;
  add_gain(gain, settings, queue[i], as_uint(shadow_light[i].w), shadow_light[i].xyz);
}

// The survivors become the queue. counts: chains that took part in the segment, and that go on.
__kernel void advance_queue(__global const uint* restrict survivors, __global const uint* restrict next_active,
                            __global const Ray* restrict next_rays, __global const uint* restrict next_queue,
                            __global Ray* restrict rays, __global uint* restrict queue, __global uint* restrict active,
                            __global uint* restrict counts) {
  const uint i = get_global_id(0);
  const uint count = next_active[0];
  if (i == 0u) {
    counts[0] = active[0];
    counts[1] = count;
    active[0] = count;
  }
  if (i >= count) return;
  rays[i] = next_rays[survivors[i]];
  queue[i] = next_queue[survivors[i]];
}

// What listed slots send towards this direction: diffuse and found by their chains.
__kernel void apply_slot_gains(uint count, __global const uint* restrict list, __global const float4* restrict diffuse,
                               __global const float4* restrict gain, __global float4* restrict records) {
  const uint i = get_global_id(0);
  if (i >= count) return;
  const uint slot = list[i];
  for (uint k = 0u; k < BUNDLE_REFLECTED; ++k) {
    global float4* send = records + (size_t)slot * BUNDLE_RECORD + 2u * (BUNDLE_FIRST + k);
    (*send).xyz = diffuse[(size_t)slot * BUNDLE_REFLECTED + k].xyz + gain[(size_t)i * BUNDLE_REFLECTED + k].xyz;
  }
}
