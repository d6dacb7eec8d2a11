// SPDX-License-Identifier: Apache-2.0
// What the field shows at the points of a G-buffer.
#include "lucarium/services/layer_sums/layer_sums.clh"
#include "virtual_light_field/pixels/shown_field.clh"

// Adds a sample that counts `weight` of the mean: a field that has grown replaces what it was. traced: light of rays by
// specular lobes, direct and other (trace_lobes.cl). They count where `rays`.
__kernel LUCARIUM_FLATTEN void show_field(
    LUCARIUM_SCENE_PARAMETERS SHOWN_FIELD_PARAMETERS __global const GBufferPoint* restrict points, uint count,
    float weight, uint rays, __global const float4* restrict traced, __global float4* restrict direct_layer,
    __global float4* restrict indirect_layer) {
  const uint i = get_global_id(0);
  if (i >= count) return;
  LUCARIUM_SCENE_BIND(scene);
  const ShownField field = SHOWN_FIELD_BIND;
  const GBufferPoint point = points[i];
  float3 once = (float3)(0.0f), more = once;
  if (rays) {
    once = traced[2u * i].xyz;
    more = traced[2u * i + 1u].xyz;
  }
  if (point.state == LUCARIUM_GBUFFER_SURFACE) {
    const FieldPlace place = find_place(&field, &point);
    bool ideal = false;
    if (has_shown_lobe(&field, &place)) {
      const Surface surface = gbuffer_surface(&scene, point);
      const Bsdf bsdf = make_bsdf(&scene, &surface, LUCARIUM_BSDF_UNSAMPLED);
      ideal = bsdf.flags & LUCARIUM_BSDF_DELTA;
    }
    add_shown(&field, &place, &point, ideal, &once, &more);
  }
  direct_layer[i] = mix_sample(direct_layer[i], once, weight);
  indirect_layer[i] = mix_sample(indirect_layer[i], more, weight);
}
