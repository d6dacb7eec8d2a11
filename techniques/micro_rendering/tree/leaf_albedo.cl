// SPDX-License-Identifier: Apache-2.0
// Albedo of the leaves.
#include "micro_rendering/tree/micro_surface.clh"

// Albedo of the diffuse lobe per leaf, as 4 halfs; needs materials and texture coordinates only.
__kernel void store_leaf_albedo(LUCARIUM_SCENE_PARAMETERS __global const MicroLeaf* restrict leaves, uint count,
                                __global half* restrict leaf_albedo) {
  const uint i = get_global_id(0);
  if (i >= count) return;
  LUCARIUM_SCENE_BIND(scene);
  const Surface surface = leaf_surface(&scene, leaves[i]);
  vstore_half4((float4)(leaf_diffuse(&scene, &surface), 0.0f), i, leaf_albedo);
}
