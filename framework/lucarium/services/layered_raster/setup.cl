// SPDX-License-Identifier: Apache-2.0
// From world-space triangles to LayeredRecords of a view: gather, project, snap, orient, bound. LAYERED_PERSPECTIVE,
// LAYERED_CONSERVATIVE and LAYERED_CLASSES as LayeredRaster::defines() says.
#include "lucarium/services/layered_raster/cull.clh"

#ifdef LAYERED_CLASSES
#define LAYERED_CLASS_PARAMETERS __global const uchar *layered_classes,
// Lanes (−1) of a block of 16 triangles whose classes the view leaves out.
#define LAYERED_LEFT_OUT(block, view) \
  ((convert_int16(vload16(block, layered_classes)) & (int16)((int)(view).classes)) == 0)
#else
#define LAYERED_CLASS_PARAMETERS
#define LAYERED_LEFT_OUT(block, view) ((int16)(0))
#endif

// Whether |a b - c d| may be 0, were it not for rounding: the factors are differences of floats, `size` bounds them.
// A term's relative error is below 4 * 2^-24, and what is flushed to zero is below 2^-126.
bool layered_may_vanish(float a, float b, float c, float d, float size) {
  const float p = a * b, q = c * d;
  return !(fabs(p - q) > 1e-6f * (fabs(p) + fabs(q)) + 1e-37f * (1.0f + size));
}

// Whether a triangle may have no area: is_degenerate() (degenerate_triangle.h) decides it in double precision.
bool layered_unsure_area(const float4* p) {
  const float3 u = p[1].xyz - p[0].xyz, v = p[2].xyz - p[0].xyz;
  const float size = max_component(fabs(u)) + max_component(fabs(v));
  return layered_may_vanish(u.y, v.z, u.z, v.y, size) && layered_may_vanish(u.z, v.x, u.x, v.z, size) &&
         layered_may_vanish(u.x, v.y, u.y, v.x, size);
}

// De-indexed positions in blocks of 16 triangles, component by component, so that set-up is all vector loads.
// layered_boxes: per block, what its triangles lie in.
// layered_unsure: per block, the triangles (bits) that may have no area. Those that have none would get one where
// corners are snapped, and have fragments though no ray hits them: the host takes them out.
__kernel void layered_gather_triangles(__global const SceneInfo* scene_info, __global const Vertex* scene_vertices,
                                       __global const Triangle* scene_triangles,
                                       __global const Instance* scene_instances,
                                       __global const Material* scene_materials, __global uint* layered_unsure,
                                       __global LayeredBox* layered_boxes, __global float* layered_geometry) {
  const uint block = get_global_id(0);
  __global float* out = layered_geometry + block * LAYERED_BLOCK_WORDS;
  uint unsure = 0u;
  float3 low = (float3)(INFINITY), high = (float3)(-INFINITY);
  for (uint lane = 0u; lane < 16u; ++lane) {
    const uint index = block * 16u + lane;
    float4 p[3] = {(float4)(NAN), (float4)(NAN), (float4)(NAN)};
    uint flags = 0u;
    // Fetch corners and flags. Places behind the last triangle hold NaN, which set-up drops.
    if (index < scene_info->triangle_count) {
      const Triangle triangle = scene_triangles[index];
      p[0] = scene_vertices[triangle.v0].position;
      p[1] = scene_vertices[triangle.v1].position;
      p[2] = scene_vertices[triangle.v2].position;
      const uint material = scene_materials[scene_instances[triangle.instance].material].flags;
      flags = material & (LUCARIUM_MATERIAL_MASK | LUCARIUM_MATERIAL_BLEND) ? LAYERED_RECORD_ALPHA : 0u;
      if (layered_unsure_area(p)) unsure |= 1u << lane;
      low = fmin(low, fmin(p[0].xyz, fmin(p[1].xyz, p[2].xyz)));
      high = fmax(high, fmax(p[0].xyz, fmax(p[1].xyz, p[2].xyz)));
    }
    // Store component by component.
    for (uint corner = 0u; corner < 3u; ++corner) {
      out[(3u * corner + 0u) * 16u + lane] = p[corner].x;
      out[(3u * corner + 1u) * 16u + lane] = p[corner].y;
      out[(3u * corner + 2u) * 16u + lane] = p[corner].z;
    }
    out[9u * 16u + lane] = as_float(flags);
  }
  layered_unsure[block] = unsure;
  layered_boxes[block] = layered_box(low, high);
}

// Records and tile bounds of those triangles of a block that are seen, one behind the other. Returns their number.
// Triangles that must be clipped get none here, but are counted.
static uint layered_set_up_block(const LayeredView* view, __global const float* in, int16 left_out, uint first,
                                 __global LayeredRecord* records, __global uint* bounds, __global uint* clip_count) {
  LayeredCorner16 corners[3];
  for (uint k = 0u; k < 3u; ++k)
    corners[k] = layered_project16(view, vload16(3u * k, in), vload16(3u * k + 1u, in), vload16(3u * k + 2u, in));
  int16 unseen;
  const int16 clip = layered_needs_clip16(view, corners, &unseen) & ~left_out, skip = clip | left_out | unseen;
  *clip_count = popcount(layered_signs16(clip));
  if (layered_signs16(skip) == 0xffffu) return 0u;
  LayeredSetUp16 set = layered_set_up16(view, corners, skip);
  const uint16 flags = as_uint16(vload16(9, in)) | set.flags;
  return layered_store_records(records, bounds, &set, first, flags, 0xffffu);
}

// LAYERED_BLOCKS_EACH blocks to a work-item. What is seen of them comes first in their places, so that what follows
// goes over it without gaps.
__kernel void layered_set_up(LAYERED_CLASS_PARAMETERS __global const LayeredView* layered_views, uint layered_view,
                             __global const float* layered_geometry, __global const LayeredBox* layered_boxes,
                             uint triangles, __global LayeredRecord* layered_records, __global uint* layered_bounds,
                             __global uint* layered_clip_counts) {
  const uint first = (uint)get_global_id(0) * LAYERED_BLOCKS_EACH, blocks = (triangles + 15u) / 16u;
  const uint last = min(first + LAYERED_BLOCKS_EACH, blocks);
  const LayeredView view = layered_views[layered_view];
  const LayeredSight sight = layered_sight(&view);
  uint place = 16u * first;
  for (uint block = first; block < last; ++block) {
    const LayeredBox box = layered_boxes[block];
    if (layered_out_of_sight(&sight, &box)) {
      layered_clip_counts[block] = 0u;
      continue;
    }
    place +=
        layered_set_up_block(&view, layered_geometry + block * LAYERED_BLOCK_WORDS, LAYERED_LEFT_OUT(block, view),
                             block * 16u, layered_records + place, layered_bounds + place, layered_clip_counts + block);
  }
  for (; place < 16u * last; ++place) layered_bounds[place] = LAYERED_NO_BOUNDS;
}

// What clipping adds: parts of the clipped triangles of a block, LAYERED_CLIP_PARTS places each, from `place` on.
static void layered_clip_block(const LayeredView* view, __global const float* in, int16 left_out, uint block,
                               uint place, __global LayeredRecord* extra, __global LayeredClip* clips,
                               __global uint* extra_bounds) {
  for (uint lane = 0u; lane < 16u; ++lane) {
    if (((const int*)&left_out)[lane]) continue;
    LayeredCorner corners[3];
    for (uint k = 0u; k < 3u; ++k)
      corners[k] = layered_project(view, in[3u * k * 16u + lane], in[(3u * k + 1u) * 16u + lane],
                                   in[(3u * k + 2u) * 16u + lane]);
    if (!layered_needs_clip(view, corners)) continue;
    layered_clip(view, corners, block * 16u + lane, as_uint(in[9u * 16u + lane]), extra, clips, extra_bounds, place);
    place += LAYERED_CLIP_PARTS;
  }
}

// `layered_clip_counts` scanned; LAYERED_BLOCKS_EACH blocks to a work-item.
__kernel void layered_clip_triangles(LAYERED_CLASS_PARAMETERS __global const LayeredView* layered_views,
                                     uint layered_view, __global const float* layered_geometry, uint triangles,
                                     __global const uint* layered_clip_counts, __global const uint* layered_clipped,
                                     __global LayeredRecord* layered_extra, __global LayeredClip* layered_clips,
                                     __global uint* layered_extra_bounds) {
  const uint first = (uint)get_global_id(0) * LAYERED_BLOCKS_EACH, blocks = (triangles + 15u) / 16u;
  for (uint block = first; block < min(first + LAYERED_BLOCKS_EACH, blocks); ++block) {
    const uint place = layered_clip_counts[block];
    if (place == (block + 1u < blocks ? layered_clip_counts[block + 1u] : layered_clipped[0])) continue;
    const LayeredView view = layered_views[layered_view];
    layered_clip_block(&view, layered_geometry + block * LAYERED_BLOCK_WORDS, LAYERED_LEFT_OUT(block, view), block,
                       place * LAYERED_CLIP_PARTS, layered_extra, layered_clips, layered_extra_bounds);
  }
}
