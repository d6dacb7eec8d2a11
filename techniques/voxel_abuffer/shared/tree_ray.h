// SPDX-License-Identifier: Apache-2.0
// What EyeTrees (voxel_abuffer/modes/eye_trees.h) and its kernels share.
#ifndef VOXEL_ABUFFER_TREE_RAY_H
#define VOXEL_ABUFFER_TREE_RAY_H
#include "lucarium/shared/dialect.h"

// Where a ray of a tree stands.
LUCARIUM_STRUCT_BEGIN(TreeRay)
float4 throughput;  // xyz: share of its light that arrives at the pixel; w: length of the way before it, where it goes
                    // straight on through surfaces [m]
uint pixel;
uint medium;  // material that it runs through (medium.clh); LUCARIUM_NONE: air
uint pad0, pad1;
LUCARIUM_STRUCT_END(TreeRay, 32)

LUCARIUM_STRUCT_BEGIN(TreeRules)
uint straight;      // 1: rays go on behind every surface by its alpha; 0: they branch at ideal lobes
uint level;         // of the rays: surfaces before them
uint last_level;    // rays of this level do not go on
uint sample_index;  // of the camera sample
uint first;         // pixel of the first camera ray, or the place of the first ray in its level's queue
uint count;         // of rays
uint target;        // place of the next level's queue
uint pad0;
LUCARIUM_STRUCT_END(TreeRules, 32)

#endif
