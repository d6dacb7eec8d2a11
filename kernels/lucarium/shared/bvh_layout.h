// SPDX-License-Identifier: Apache-2.0
// Memory layout of the wide bounding-volume hierarchy (framework/lucarium/services/bvh/bvh.h), in 32-bit words, for a
// node width W and L triangles per leaf block. Everything is structure-of-arrays, so that a node or a block is a few
// vector loads.
#ifndef LUCARIUM_SHARED_BVH_LAYOUT_H
#define LUCARIUM_SHARED_BVH_LAYOUT_H

// The node buffer begins with a header of 16 words.
#define LUCARIUM_BVH_HEADER_WORDS 16u
#define LUCARIUM_BVH_HEADER_EXTENT 0u  // float: largest absolute coordinate of any triangle [m]
#define LUCARIUM_BVH_HEADER_SIZE 1u    // float: longest side of the box around all triangles [m]

// Node n starts at word HEADER + n · NODE_WORDS: W lower x, W lower y, W lower z, W upper x, W upper y, W upper z
// (floats [m]; empty slots hold an inverted box), then W references, then the order word and unused ones. Node 0 is the
// root; children follow parents.
#define LUCARIUM_BVH_NODE_WORDS(W) (8u * (W))
#define LUCARIUM_BVH_NODE_REFERENCES(W) (6u * (W))
#define LUCARIUM_BVH_NODE_ORDER(W) (7u * (W))
#define LUCARIUM_BVH_UPPER(W) (3u * (W))  // from a lower plane to the upper one of the same axis

// Slots are arranged so that (0, 1, …, W − 1) XOR m visits the children roughly from far to near, where m depends on
// the ray's octant (bit 0, 1, 2: the direction's x, y, z is negative) and stands in bits 4 · octant … of the order
// word.
#define LUCARIUM_BVH_ORDER_MASK(word, octant) (((word) >> (4u * (octant))) & 15u)

// A reference is the word where a node starts in the node buffer, or this flag and the word where a leaf block starts
// in the block buffer, so that traversal need not multiply.
#define LUCARIUM_BVH_LEAF 0x80000000u
#define LUCARIUM_BVH_ROOT LUCARIUM_BVH_HEADER_WORDS

// Block b starts at word b · BLOCK_WORDS: L x, L y, L z of the first vertices, the same of the second and third ones
// (floats [m]; empty slots repeat one point three times, which nothing hits), then L triangle indices.
#define LUCARIUM_BVH_BLOCK_WORDS(L) (10u * (L))
#define LUCARIUM_BVH_BLOCK_TRIANGLES(L) (9u * (L))

#endif
