// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <vector>

#include "lucarium/scene/device/scene_buffers.h"
#include "lucarium/services/surface_atlas/surface_atlas.h"
#include "virtual_light_field/shared/field.h"
#include "virtual_light_field/tiles/patch_growth.h"

namespace lucarium::vlf {

/// The surfaces that keep radiance by direction, in patches: connected triangles whose normals lie in a cone, so that a
/// ray meets a patch once, except near silhouettes. A texel belongs to the patch of its largest piece. Either
/// reflecting side of a patch is a facet.
struct Patches {
  std::vector<FieldFacet> facets;
  std::vector<uint32_t> triangles;   ///< world triangles of facets
  std::vector<uint32_t> side_facet;  ///< per texel side; LUCARIUM_NONE: it keeps irradiance only
  std::vector<float4> side_albedo;   ///< per texel side: xyz cosine-averaged albedo of its specular lobes; w unused
  bool empty() const { return facets.empty(); }
};

struct PatchOptions {
  double tile_albedo = 0.1;  ///< least luminance of specular albedo and transmission [1]
  double cone = 30;          ///< between the normals of a patch and that of its largest triangle [degrees]
  uint32_t tile = 8;         ///< m; 0: chosen for each patch
  bool rows = false;         ///< no tiles: FieldFacet::tile is 0
  double cell = 0;           ///< c [m]
  uint32_t dir_n = 16;
  uint32_t levels = 0;  ///< dir_levels
};
Patches make_patches(const SurfaceAtlas& atlas, const SceneBuffers& buffers, const PatchOptions& options);

/// Whether surfaces of a material are likely to have tiles; textures are taken for white.
bool is_tiled(const SceneMaterial& material, double tile_albedo);

/// FieldFacet::tile of a patch of these triangles.
uint32_t tile_of(const PatchMesh& mesh, const std::vector<uint32_t>& triangles, const PatchOptions& options);

/// FieldFacet::level of surfaces whose GGX widths are at least `alpha`: the greatest of at most `options.levels` whose
/// directions are no farther apart.
uint32_t level_of(double alpha, const PatchOptions& options);

/// Expected cells of a patch of area A and perimeter P₃ on the subfield of a random direction, in tiles of m × m, both
/// sides together (derivation: patches.cpp).
double expected_cells(double area, double perimeter, double cell, uint32_t tile);

/// The m that takes the least memory for such a patch.
uint32_t best_tile(double area, double perimeter, double cell);

}  // namespace lucarium::vlf
