// SPDX-License-Identifier: Apache-2.0
// A sample of pixels that show nothing but the field, from camera rays and their hits.
#include "lucarium/prefetch.clh"
#include "lucarium/services/gbuffer/eye_vertex.clh"
#include "lucarium/services/layer_sums/layer_sums.clh"
#include "virtual_light_field/pixels/walk_eight.clh"

// Consecutive pixels that a work-item takes. On CPU devices it takes several blocks of eight, all of them through one
// step after the other.
#ifdef LUCARIUM_HAS_PREFETCH
#define WALK_PIXELS 64u
#else
#define WALK_PIXELS 1u
#endif

// What the pixel before has shown.
typedef struct SharedSide {
  uint triangle;  // LUCARIUM_NONE: none
  float3 normal;  // unit, on its front
  uint front;     // LUCARIUM_SURFACE_FRONT or 0
  uint same;      // all points of the side have the same material
  float3 diffuse;
  uint ideal;  // its specular lobe is
} SharedSide;

bool varies(const Scene* scene, uint material) {
  const __global Material* m = scene->scene_materials + material;
  const uint textures =
      m->base_color_texture.texture & m->metallic_roughness_texture.texture & m->transmission_texture.texture;
  return textures != LUCARIUM_NONE || (m->flags & LUCARIUM_MATERIAL_VERTEX_COLOR);
}

// Diffuse albedo of the surface, and whether its specular lobe is ideal, as make_bsdf() has them.
LUCARIUM_FLATTEN void find_lobes(const Scene* scene, const Surface* surface, SharedSide* shared) {
  const uint front = surface->flags & LUCARIUM_SURFACE_FRONT;
  const bool faces = dot(surface->n_s, surface->view) > 0.0f;
  if (faces && shared->same && shared->front == front && shared->triangle == surface->triangle) return;
  const Bsdf bsdf = make_bsdf(scene, surface, LUCARIUM_BSDF_UNSAMPLED);
  shared->diffuse = bsdf.diffuse;
  shared->ideal = (bsdf.flags & LUCARIUM_BSDF_DELTA) != 0u;
  shared->front = front;
  shared->same = faces && !varies(scene, surface->material);
  shared->triangle = surface->triangle;
  shared->normal = front ? surface->n_g : -surface->n_g;
}

// What add_shown() asks of a point with these lobes.
void show_surface(const Surface* surface, const SharedSide* shared, Hit hit, GBufferPoint* point) {
  point->position.xyz = surface->position;
  point->normal.w = surface->flags & LUCARIUM_SURFACE_FRONT ? 0.0f : 1.0f;
  point->view = (float4)(surface->view, shared->diffuse.x);
  point->emission.w = shared->diffuse.y;
  point->albedo.w = shared->diffuse.z;
  point->u = hit.u;
  point->v = hit.v;
  point->triangle = hit.triangle;
}

#ifdef LUCARIUM_HAS_PREFETCH
// What a later pixel's look-up needs of the atlas: the record of its triangle, and of one nearer by its cell.
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
// Nothing is asked for where pixels ahead show the same triangle.
void prefetch_pixel(const Scene* scene, const ShownField* shown, __global const Hit* hits, uint i, uint count) {
  const uint here = hits[i].triangle, far = i + 16u;
  if (far < count && hits[i + 4u].triangle == here && hits[i + 8u].triangle == here && hits[far].triangle == here)
    return;
  prefetch_surfaces(scene, hits, i, count);
  prefetch_places(shown, hits, i, count);
}
#else
void prefetch_pixel(const Scene* scene, const ShownField* shown, __global const Hit* hits, uint i, uint count) {}
#endif

// The layers of pixels. begins: what they hold is of another picture. weight: see show_field.cl.
typedef struct WalkLayers {
  __global float4* emission;
  __global float4* direct;
  __global float4* indirect;
  uint shows, begins;
  float weight;
} WalkLayers;

void add_pixel(const WalkLayers* layers, uint i, float3 emitted, float3 once, float3 more) {
  const float4 none = (float4)(0.0f);
  const bool begins = layers->begins, shows = layers->shows;
  layers->emission[i] = add_sample(begins ? none : layers->emission[i], emitted);
  if (!shows && !begins) return;
  const float4 direct_before = begins ? none : layers->direct[i], more_before = begins ? none : layers->indirect[i];
  layers->direct[i] = shows ? mix_sample(direct_before, once, layers->weight) : none;
  layers->indirect[i] = shows ? mix_sample(more_before, more, layers->weight) : none;
}

// Pixels first to `end`, which is at most `count`, one by one.
void walk_one_by_one(const Scene* scene, const ShownField* field, const WalkLayers* layers, __global const Ray* rays,
                     __global const Hit* hits, uint first, uint end, uint count) {
  SharedSide shared;
  shared.triangle = LUCARIUM_NONE;
  shared.same = 0u;
  for (uint i = first; i < end; ++i) {
    prefetch_pixel(scene, field, hits, i, count);
    const Hit hit = hits[i];
    const float3 direction = rays[i].direction.xyz;
    GBufferPoint point = begin_eye_path();
    float3 once = (float3)(0.0f), more = once;
    if (hit.triangle == LUCARIUM_NO_HIT) {
      leave_scene(scene, direction, &point);
    } else {
      const float3* normal = shared.triangle == hit.triangle ? &shared.normal : 0;
      const Surface surface = make_surface_of(scene, hit, direction, 0u, normal);
      arrive_at_surface(scene, &surface, hit, &point);
      if (layers->shows) {
        find_lobes(scene, &surface, &shared);
        show_surface(&surface, &shared, hit, &point);
        const FieldPlace place = find_place(field, &point);
        add_shown(field, &place, &point, shared.ideal, &once, &more);
      }
    }
    add_pixel(layers, i, point.emission.xyz, once, more);
  }
}

#ifdef LUCARIUM_HAS_PREFETCH
// Pixels first to first + WALK_PIXELS - 1, or to count - 1.
void walk_by_blocks(const Scene* scene, const ShownField* field, const WalkTables* tables, const WalkLayers* layers,
                    uint first, uint count) {
  const uint end = min(first + WALK_PIXELS, count), blocks = (end - first) / 8u;
  WalkBlock all[WALK_PIXELS / 8u];
  for (uint b = 0u; b < blocks; ++b) ask_for_triangles(tables, first + 8u * b, all + b);
  for (uint b = 0u; b < blocks; ++b) find_cells_of_block(field, tables, first + 8u * b, all + b);
  for (uint b = 0u; b < blocks; ++b)
    if (all[b].shown) find_light_of_block(field, tables, first + 8u * b, all + b);
  for (uint b = 0u; b < blocks; ++b) {
    const uint begin = first + 8u * b;
    if (!all[b].shown) {
      walk_one_by_one(scene, field, layers, tables->rays, tables->hits, begin, begin + 8u, count);
      continue;
    }
    WalkPixels pixels;
    show_block(field, tables, begin, all + b, &pixels);
    for (uint k = 0u; k < 8u; ++k)
      add_pixel(layers, begin + k, tables->sides[all[b].side[k]].emitted.xyz, pixels.once[k].xyz, pixels.more[k].xyz);
  }
  walk_one_by_one(scene, field, layers, tables->rays, tables->hits, first + 8u * blocks, end, count);
}
#endif

// Adds to `emission` a sample, and to the other layers one that counts `weight` of the mean (show_field.cl), if
// `shows`. begins: what the layers hold is of another picture.
__kernel LUCARIUM_FLATTEN void walk_field(
    LUCARIUM_SCENE_PARAMETERS SHOWN_FIELD_PARAMETERS __global const WalkTriangle* restrict walk_triangles,
    __global const WalkSide* restrict walk_sides, __global const WalkLight* restrict walk_light,
    __global const Ray* restrict rays, __global const Hit* restrict hits, uint count, uint shows, uint begins,
    float weight, __global float4* restrict emission, __global float4* restrict direct_layer,
    __global float4* restrict indirect_layer) {
  const uint first = get_global_id(0);
  if (first % WALK_PIXELS != 0u || first >= count) return;
  LUCARIUM_SCENE_BIND(scene);
  const ShownField field = SHOWN_FIELD_BIND;
  const WalkLayers layers = {emission, direct_layer, indirect_layer, shows, begins, weight};
#ifdef LUCARIUM_HAS_PREFETCH
  const WalkTables tables = {walk_triangles, walk_sides, walk_light, rays, hits};
  if (shows) {
    walk_by_blocks(&scene, &field, &tables, &layers, first, count);
    return;
  }
#endif
  walk_one_by_one(&scene, &field, &layers, rays, hits, first, min(first + WALK_PIXELS, count), count);
}
