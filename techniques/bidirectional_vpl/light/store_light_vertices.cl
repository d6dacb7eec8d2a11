// SPDX-License-Identifier: Apache-2.0
// Vertices of light paths, kept with their BSDFs: the virtual lights, VPLs (Tokuyoshi and Ogaki 2012, section 4.1).
#define LUCARIUM_JOINED
#include "bidirectional_vpl/base/eye_directions.clh"
#include "bidirectional_vpl/light/path_lights.clh"
#include "lucarium/path_vertex.clh"
// Light goes on behind these vertices, so that they are not the first of a camera path.
#define LIGHT_PATH_EYE_PDF(scene, bsdf, direction) eye_direction_pdf(scene, bsdf, direction, false)
#include "bidirectional_vpl/base/gloss.clh"
#define LIGHT_VERTEX_PARAMETERS                                                                           \
  __global PathVertex *restrict vertices, GLOSS_PARAMETER(vertex_densities) const uint vertices_per_path, \
      __global uint *restrict path_lights,
#define LIGHT_VERTEX_ARGUMENTS vertices, GLOSS_ARGUMENT(vertex_densities) vertices_per_path, path_lights,
#define LIGHT_EMISSION_PARAMETERS __global const float* restrict shares,
#ifdef LEARNED_LIGHTS
#define LIGHT_PATH_CHOOSE(scene, u, low_bits, choice) choose_path_light(scene, shares, u, low_bits, choice)
#endif
#include "lucarium/services/light_paths/light_paths.clh"

// path_lights[i]: the light of path i, where it has a vertex. Vertex k (from 1) of path i is vertices[i *
// vertices_per_path + k - 1].
void take_light_vertex(const Scene* scene, LIGHT_VERTEX_PARAMETERS const LightVertex* vertex) {
  const uint number = vertex->number + 1u;
  path_lights[vertex->path] = vertex->light;
  const uint slot = vertex->path * vertices_per_path + vertex->number;
#ifdef GLOSS
  // p_1 (Tokuyoshi and Ogaki 2012, equation 4) by the scene's table of lights, and d^2 / c towards the vertex before.
  const bool infinite = vertex->number == 0u && light_is_infinite(scene, vertex->light);
  const float choice = vertex->number == 0u ? scene->scene_light_table[vertex->light].pmf : 1.0f;
  const float cosine = fmax(fabs(dot(vertex->surface.n_g, vertex->surface.view)), 1e-6f);
  vertex_densities[slot] = (float2)(choice * vertex->found, infinite ? INFINITY : sqr(vertex->distance) / cosine);
#endif
  PathVertex kept =
      pack_path_vertex(&vertex->surface, &vertex->bsdf, vertex->flux, vertex->medium, number, vertex->mis);
  if (vertex->number > 0u && vertex->diffused == 0u) kept.view.w = as_float(as_uint(kept.view.w) | PATH_VERTEX_CAUSTIC);
  vertices[slot] = kept;
}

// Before a run: no path has a vertex.
__kernel void clear_light_vertices(__global PathVertex* restrict vertices, uint count, uint slice_base) {
  const uint i = slice_base + get_global_id(0);
  if (i < count) vertices[i].view.w = as_float(0u);
}

// Marks those that are there.
__kernel void mark_light_vertices(__global const PathVertex* restrict vertices, uint count,
                                  __global uint* restrict present, uint slice_base) {
  const uint i = slice_base + get_global_id(0);
  if (i >= count) return;
  const PathVertex vertex = vertices[i];
  present[i] = path_vertex_number(&vertex) != 0u;
}
