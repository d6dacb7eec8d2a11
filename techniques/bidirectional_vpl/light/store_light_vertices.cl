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
      const uint streamed, __global uint *restrict path_lights,
#define LIGHT_VERTEX_ARGUMENTS vertices, GLOSS_ARGUMENT(vertex_densities) vertices_per_path, streamed, path_lights,
#define LIGHT_EMISSION_PARAMETERS __global const float* restrict shares,
#define LIGHT_EMISSION_ARGUMENTS shares,
#ifdef LEARNED_LIGHTS
#define LIGHT_PATH_CHOOSE(scene, u, low_bits, choice) choose_path_light(scene, shares, u, low_bits, choice)
#endif
// Paths of eight at once, where nothing is asked for that plain surfaces do not have.
#if !defined(GLOSS) && !defined(EYE_BUNDLES) && !defined(LUCARIUM_RAY_ENDS)
#define LIGHT_PATHS_PLAIN
#endif
#include "lucarium/services/light_paths/light_paths.clh"

// path_lights[i]: the light of path i, where it has a vertex. Vertex k (from 1) of path i is vertices[i *
// vertices_per_path + k - 1]. streamed: 1 where all of them are too many for the caches.
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

#ifdef LIGHT_PATHS_PLAIN
// The same as take_light_vertex() and pack_path_vertex().
LUCARIUM_JOIN void take_plain_light_vertices(const Scene* scene,
                                             LIGHT_VERTEX_PARAMETERS const PlainLightVertices8* taken, uint first,
                                             uint lanes, bool together) {
  const PlainSurfaces8* s = &taken->surface;
  const uint row = vertices_per_path * (sizeof(PathVertex) / sizeof(float4));
  __global float4* rows = (__global float4*)(vertices + (size_t)first * vertices_per_path + taken->number);
  const float8 met = fmax(s->met, 1e-4f), none = (float8)(0.0f);
  uint8 flags = (uint8)((taken->number + 1u) << PATH_VERTEX_NUMBER_SHIFT);
  flags |= as_uint8(s->front) & PATH_VERTEX_FRONT;
  if (taken->number > 0u) flags |= as_uint8(taken->diffused == 0u) & PATH_VERTEX_CAUSTIC;
  if (together) {
    flags &= as_uint8(lanes_of_bits8(lanes));
    lanes = 255u;
  }
  const Fields8 fields[8] = {{s->ray_start.x, s->ray_start.y, s->ray_start.z, taken->mis_fixed},
                             {taken->flux.x / met, taken->flux.y / met, taken->flux.z / met, taken->mis_turning},
                             {s->n_g.x, s->n_g.y, s->n_g.z, s->alpha},
                             {s->n_s.x, s->n_s.y, s->n_s.z, (float8)(1.0f)},
                             {s->view.x, s->view.y, s->view.z, as_float8(flags)},
                             {s->diffuse.x, s->diffuse.y, s->diffuse.z, as_float8((uint8)(LUCARIUM_NONE))},
                             {none, none, none, as_float8(s->triangle)},
                             {none, none, none, as_float8(halves_above8(s->ray_offset) << 16)}};
  if (streamed && lanes == 255u) {
    stream_lines8(rows, row, fields[0], fields[1], fields[2], fields[3]);
    stream_lines8(rows + 4, row, fields[4], fields[5], fields[6], fields[7]);
  } else {
    // The slots of paths further on are not in a cache: ask for them before they are written.
    const __global PathVertex* next = vertices + (size_t)(first + 16u) * vertices_per_path + taken->number;
#pragma unroll
    for (uint k = 0u; k < 8u; ++k) {
      LUCARIUM_PREFETCH(next + k * vertices_per_path);
      LUCARIUM_PREFETCH((const __global float4*)(next + k * vertices_per_path) + 4);
    }
#pragma unroll
    for (uint k = 0u; k < 8u; ++k)
      store_fields8(rows + k, row, lanes, fields[k].x, fields[k].y, fields[k].z, fields[k].w);
  }
  __global uint* lights = path_lights + first;
  if (lanes == 255u) {
    vstore8(taken->light, 0, lights);
    return;
  }
  if (lanes & 1u) lights[0] = taken->light.s0;
  if (lanes & 2u) lights[1] = taken->light.s1;
  if (lanes & 4u) lights[2] = taken->light.s2;
  if (lanes & 8u) lights[3] = taken->light.s3;
  if (lanes & 16u) lights[4] = taken->light.s4;
  if (lanes & 32u) lights[5] = taken->light.s5;
  if (lanes & 64u) lights[6] = taken->light.s6;
  if (lanes & 128u) lights[7] = taken->light.s7;
}
#endif

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
