// SPDX-License-Identifier: Apache-2.0
// A sample of pixels that show nothing but the field, from camera rays and their hits.
#include "lucarium/prefetch.clh"
#include "lucarium/services/gbuffer/eye_vertex.clh"
#include "lucarium/services/layer_sums/layer_sums.clh"
#include "virtual_light_field/pixels/shown_field.clh"

#ifdef LUCARIUM_HAS_PREFETCH
// What a later work-item's look-up needs of the atlas: the record of its triangle, and of one nearer by its cell.
void prefetch_places(const ShownField* shown, __global const Hit* hits, uint i, uint count) {
  const uint far = i + 16u, near = i + 8u;
  if (far < count && hits[far].triangle != LUCARIUM_NO_HIT)
    LUCARIUM_PREFETCH(shown->atlas_triangles + hits[far].triangle);
  if (near >= count || hits[near].triangle == LUCARIUM_NO_HIT) return;
  const AtlasTriangle record = shown->atlas_triangles[hits[near].triangle];
  const uint cell = atlas_cell(record, atlas_uv(record, hits[near].u, hits[near].v));
  LUCARIUM_PREFETCH(shown->atlas_table + cell);
  LUCARIUM_PREFETCH(shown->atlas_links + cell);
}
#else
void prefetch_places(const ShownField* shown, __global const Hit* hits, uint i, uint count) {}
#endif

// Adds to `emission` a sample, and to the other layers one that counts `weight` of the mean (show_field.cl), if
// `shows`.
__kernel LUCARIUM_FLATTEN void walk_field(
    LUCARIUM_SCENE_PARAMETERS SHOWN_FIELD_PARAMETERS __global const Ray* restrict rays,
    __global const Hit* restrict hits, uint count, uint shows, float weight, __global float4* restrict emission,
    __global float4* restrict direct_layer, __global float4* restrict indirect_layer) {
  const uint i = get_global_id(0);
  if (i >= count) return;
  LUCARIUM_SCENE_BIND(scene);
  const ShownField field = SHOWN_FIELD_BIND;
  prefetch_surfaces(&scene, hits, i, count);
  prefetch_places(&field, hits, i, count);
  const Hit hit = hits[i];
  const float3 direction = rays[i].direction.xyz;
  GBufferPoint point = begin_eye_path();
  float3 once = (float3)(0.0f), more = once;
  if (hit.triangle == LUCARIUM_NO_HIT) {
    leave_scene(&scene, direction, &point);
  } else {
    const Surface surface = make_surface(&scene, hit, direction, 0u);
    const uint medium = arrive_at_surface(&scene, &surface, hit, &point);
    const Bsdf bsdf = make_bsdf(&scene, &surface, LUCARIUM_BSDF_UNSAMPLED);
    keep_surface(&scene, &surface, &bsdf, hit, medium, 1.0f, &point);
    if (shows) {
      const FieldPlace place = find_place(&field, &point);
      add_shown(&field, &place, &point, bsdf.flags & LUCARIUM_BSDF_DELTA_REFLECTION, &once, &more);
    }
  }
  emission[i] = add_sample(emission[i], point.emission.xyz);
  if (!shows) return;
  direct_layer[i] = mix_sample(direct_layer[i], once, weight);
  indirect_layer[i] = mix_sample(indirect_layer[i], more, weight);
}
