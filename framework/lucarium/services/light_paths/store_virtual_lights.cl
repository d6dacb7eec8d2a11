// SPDX-License-Identifier: Apache-2.0
// Vertices of light paths as virtual lights (Keller 1997) or photons (Jensen 1996).
#include "lucarium/packing.clh"
#define LIGHT_VERTEX_PARAMETERS \
  __global VirtualLight *restrict lights, const uint first, const uint paths, const uint reflected,
#define LIGHT_VERTEX_ARGUMENTS lights, first, paths, reflected,
#include "lucarium/services/light_paths/light_paths.clh"

// Vertex `first` + k of path i becomes lights[k * paths + i]; `reflected`: with the flux that its diffuse lobe
// reflects, instead of the one that arrives.
void take_light_vertex(const Scene* scene, LIGHT_VERTEX_PARAMETERS const LightVertex* vertex) {
  if (vertex->number < first || is_black(vertex->bsdf.diffuse)) return;
  VirtualLight light;
  light.position = (float4)(vertex->surface.position, as_float(pack_direction(vertex->surface.n_s)));
  light.flux = (float4)(reflected ? vertex->bsdf.diffuse * vertex->received : vertex->received,
                        as_float(pack_direction(vertex->surface.n_g)));
  lights[(vertex->number - first) * paths + vertex->path] = light;
}
