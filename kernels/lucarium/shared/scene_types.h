// SPDX-License-Identifier: Apache-2.0
// The scene as kernels see it. Filled by SceneBuffers; read through kernels/lucarium/scene.clh.
#ifndef LUCARIUM_SHARED_SCENE_TYPES_H
#define LUCARIUM_SHARED_SCENE_TYPES_H
#include "lucarium/shared/dialect.h"

#define LUCARIUM_NONE 0xffffffffu

// One vertex: object space in scene_mesh_vertices, world space in scene_vertices.
LUCARIUM_STRUCT_BEGIN(Vertex)
float4 position;  // xyz [m]; w: TEXCOORD_0.u
float4 normal;    // xyz unit shading normal; w: TEXCOORD_0.v
float4 tangent;   // xyz unit, w handedness ±1; all 0 where the mesh has no tangents and needs none
float u1, v1;     // TEXCOORD_1
uint color_rg;    // COLOR_0 as four halfs, linear
uint color_ba;
LUCARIUM_STRUCT_END(Vertex, 64)

// A world-space triangle: counter-clockwise seen from its front, also for mirrored instances.
LUCARIUM_STRUCT_BEGIN(Triangle)
uint v0, v1, v2;  // into scene_vertices
uint instance;    // into scene_instances
LUCARIUM_STRUCT_END(Triangle, 16)

#define LUCARIUM_INSTANCE_FLIPPED 1u   // negative determinant: winding is reversed when triangles are derived
#define LUCARIUM_INSTANCE_DEFORMED 2u  // skinned or morphed: its object-space vertices are already its own pose

// An instance: a mesh under an affine transform. Ids are stable over changes.
LUCARIUM_STRUCT_BEGIN(Instance)
float4 row0, row1, row2;             // world_from_object, 3×4 rows
float4 normal0, normal1, normal2;    // inverse transpose, 3×3 rows (w unused)
uint mesh_vertex, vertex_count;      // range in scene_mesh_vertices
uint mesh_triangle, triangle_count;  // range in scene_mesh_triangles
uint world_vertex;                   // first in scene_vertices
uint world_triangle;                 // first in scene_triangles
uint material;
uint flags;
LUCARIUM_STRUCT_END(Instance, 128)

// A texture reference of a material with its KHR_texture_transform: uv' = (u·(x,y) + z).
LUCARIUM_STRUCT_BEGIN(TextureSlot)
float4 row_u;  // xyz: u' = x·u + y·v + z; w unused
float4 row_v;  // xyz: v' likewise; w unused
uint texture;  // into scene_textures, LUCARIUM_NONE: no texture
uint uv_set;   // 0 or 1
float scale;   // normal map scale; unused elsewhere
uint pad;
LUCARIUM_STRUCT_END(TextureSlot, 48)

#define LUCARIUM_WRAP_REPEAT 0u
#define LUCARIUM_WRAP_CLAMP 1u
#define LUCARIUM_WRAP_MIRROR 2u
#define LUCARIUM_TEXTURE_WRAP_U(flags) ((flags)&3u)
#define LUCARIUM_TEXTURE_WRAP_V(flags) (((flags) >> 2) & 3u)
#define LUCARIUM_TEXTURE_NEAREST 16u
#define LUCARIUM_TEXTURE_SRGB 32u  // colour: decoded by scene_srgb_table, alpha stays linear

LUCARIUM_STRUCT_BEGIN(Texture)
uint first_texel;  // into scene_texels (RGBA8, R in the lowest byte, rows from the top)
uint width, height;
uint flags;
LUCARIUM_STRUCT_END(Texture, 16)

#define LUCARIUM_MATERIAL_DOUBLE_SIDED 1u
#define LUCARIUM_MATERIAL_UNLIT 2u
#define LUCARIUM_MATERIAL_MASK 4u
#define LUCARIUM_MATERIAL_BLEND 8u
#define LUCARIUM_MATERIAL_THIN 16u          // transmits as a thin wall that does not bend (no KHR_materials_volume)
#define LUCARIUM_MATERIAL_TRANSMISSIVE 32u  // transmission factor > 0: always two-sided
#define LUCARIUM_MATERIAL_EMISSIVE 64u      // may emit (factor × strength > 0, or unlit)
#define LUCARIUM_MATERIAL_VERTEX_COLOR 128u

#define LUCARIUM_MIRROR_ROUGHNESS 0.03f  // below it reflection and refraction are ideal

LUCARIUM_STRUCT_BEGIN(Material)
float4 base_color;  // linear RGBA factor
float4 emission;    // xyz: factor × strength [cd/m²]; w: alpha cutoff (MASK)
float metallic, roughness, transmission, ior;
float4 attenuation;  // xyz: Beer extinction coefficient per channel [1/m]; w: thickness factor
uint flags;
uint pad0, pad1, pad2;
TextureSlot base_color_texture;          // sRGB, alpha
TextureSlot metallic_roughness_texture;  // G roughness, B metallic
TextureSlot normal_texture;
TextureSlot emissive_texture;      // sRGB
TextureSlot transmission_texture;  // R
LUCARIUM_STRUCT_END(Material, 320)

#define LUCARIUM_LIGHT_POINT 0u
#define LUCARIUM_LIGHT_SPOT 1u
#define LUCARIUM_LIGHT_DIRECTIONAL 2u
#define LUCARIUM_LIGHT_TRIANGLE 3u
#define LUCARIUM_LIGHT_ENVIRONMENT 4u

// One entry of the light mixture: a punctual light, an emissive triangle, or the environment. Double-sided emitters
// have one entry whose sampling covers both sides.
LUCARIUM_STRUCT_BEGIN(Light)
float4 intensity;  // xyz: point, spot [cd], directional [lx]; triangle, environment: mean radiance [cd/m²] (for its
                   // weight only); w: power used for the mixture [lm], mean of channels
float4 position;   // xyz [m] (point, spot); w: triangle area [m²]
float4 direction;  // xyz unit, the way light travels (spot, directional); w: spot angular scale (KHR_lights_punctual)
uint kind;
uint triangle;      // world triangle (LUCARIUM_LIGHT_TRIANGLE)
float spot_offset;  // KHR_lights_punctual lightAngleOffset
float spot_cos_outer;
LUCARIUM_STRUCT_END(Light, 64)

// Walker/Vose alias table over all lights; one column per light.
LUCARIUM_STRUCT_BEGIN(AliasEntry)
float probability;  // of keeping this column
uint alias;         // otherwise take this one
float pmf;          // probability of this light [1]
float pad;
LUCARIUM_STRUCT_END(AliasEntry, 16)

// Whole-scene facts.
LUCARIUM_STRUCT_BEGIN(SceneInfo)
float4 bounds_min;          // world space; w unused
float4 bounds_max;          // w: radius of the bounding sphere about the centre [m]
float4 environment_factor;  // xyz: radiance multiplier (the constant radiance when width is 0); w unused
float4 environment_row0;    // world → environment rotation rows
float4 environment_row1;
float4 environment_row2;
uint triangle_count, instance_count, light_count, material_count;
uint environment_light;                      // index in scene_lights, LUCARIUM_NONE: no environment
uint environment_width, environment_height;  // 0: constant
uint flags;                                  // LUCARIUM_SCENE_*
float lamp_reach;                            // [m], 0: there are no lamps (LightList::reach)
float pad0, pad1, pad2;
LUCARIUM_STRUCT_END(SceneInfo, 144)

#define LUCARIUM_SCENE_HAS_ALPHA 1u  // some material is MASK or BLEND: traversal must test alpha
#define LUCARIUM_SCENE_TRANSMITS 2u  // some material transmits light

#endif
