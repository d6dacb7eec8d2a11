// SPDX-License-Identifier: Apache-2.0
// The one list of scene buffers. It generates their allocation (SceneBuffers), the kernel parameters
// (LUCARIUM_SCENE_PARAMETERS), the struct that carries them inside a kernel (Scene, kernels/lucarium/scene.clh) and
// their binding by name (SceneBuffers::bind).
#ifndef LUCARIUM_SHARED_SCENE_BUFFERS_H
#define LUCARIUM_SHARED_SCENE_BUFFERS_H

// X(element type, name, meaning)
#define LUCARIUM_SCENE_BUFFERS(X)                                                                                   \
  X(SceneInfo, scene_info, "one element: bounds, counts, environment")                                              \
  X(Vertex, scene_vertices, "world-space vertices")                                                                 \
  X(Triangle, scene_triangles, "world-space triangles")                                                             \
  X(uint, scene_alpha, "a bit per triangle, 32 in each: whether its material is MASK or BLEND")                     \
  X(Instance, scene_instances, "transforms, ranges, material")                                                      \
  X(Material, scene_materials, "")                                                                                  \
  X(Texture, scene_textures, "")                                                                                    \
  X(uint, scene_texels, "RGBA8 of all textures")                                                                    \
  X(float, scene_srgb_table, "256 entries: sRGB byte → linear")                                                     \
  X(float, scene_albedo_table, "directional albedo of the specular lobe, see kernels/lucarium/specular_albedo.clh") \
  X(Light, scene_lights, "the light mixture")                                                                       \
  X(AliasEntry, scene_light_table, "alias table over scene_lights")                                                 \
  X(uint, scene_light_trees, "where the light trees begin, see kernels/lucarium/shared/light_tree.h")               \
  X(uint, scene_light_nodes, "the light trees' nodes")                                                              \
  X(uint, scene_light_places, "per light: where the light tree has it")                                             \
  X(uint, scene_triangle_lights, "per triangle: its entry in scene_lights or LUCARIUM_NONE")                        \
  X(float4, scene_environment, "equirectangular radiance, rows from the top; w: sampling density, below")           \
  X(float, scene_environment_cdf, "height+1 marginal values, then height rows of width+1 conditional values")

// Sampling the environment (width > 0): row j with marginal[j] <= x < marginal[j+1], texel i of that row likewise; the
// point is uniform in the texel's (u, v) rectangle. Its density over solid angle is w / (2 pi^2 sin(theta)), where w
// is the texel's scene_environment[...].w = (marginal[j+1] - marginal[j]) (row[i+1] - row[i]) * width * height.
// A texel has w > 0 wherever the bilinear lookup (wrap in u, clamp in v) is not black inside it.

#endif
