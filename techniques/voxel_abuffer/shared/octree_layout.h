// SPDX-License-Identifier: Apache-2.0
// The sparse octree to compare with (compared/sparse_octree.h), which host and kernels share.
#ifndef VOXEL_ABUFFER_SHARED_OCTREE_LAYOUT_H
#define VOXEL_ABUFFER_SHARED_OCTREE_LAYOUT_H

// Levels of nodes with eight children above the bricks, which hold the two lowest levels of the octree.
#define OCTREE_MAX_LEVELS 10u

#endif
