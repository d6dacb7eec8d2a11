// SPDX-License-Identifier: Apache-2.0
// Memory layout of the light trees (framework/lucarium/scene/device/light_tree.h), in 32-bit words: one tree per kind
// of light (LUCARIUM_LIGHT_*), of nodes with up to 8 children. A node is structure-of-arrays, so that it is a few
// vector loads.
#ifndef LUCARIUM_SHARED_LIGHT_TREE_H
#define LUCARIUM_SHARED_LIGHT_TREE_H

#define LUCARIUM_LIGHT_KINDS 5u

// scene_light_trees: where they begin, per kind. POWERS: the sum over its lights [cd], suns [lx]; of the environment
// what it sends a plane in the mean over all planes [lx]; 0: there are none.
#define LUCARIUM_LIGHT_TREES_WORDS 16u
#define LUCARIUM_LIGHT_TREES_ROOTS 0u  // the word of scene_light_nodes where its root begins
#define LUCARIUM_LIGHT_TREES_KINDS 5u  // one: bits of the kinds that there are; 0: light samples choose from the table
#define LUCARIUM_LIGHT_TREES_POWERS 8u

// scene_light_nodes: rows of 8 floats, one per child. What a child's lights send is bounded: they lie in a sphere,
// their axes (a triangle's front normal, the way of a spot's or a sun's light) in a cone.
#define LUCARIUM_LIGHT_NODE_WORDS 104u
#define LUCARIUM_LIGHT_NODE_CENTER 0u   // x, y, z: three rows [m]
#define LUCARIUM_LIGHT_NODE_AXIS 24u    // of the cone, unit; x, y, z: three rows
#define LUCARIUM_LIGHT_NODE_RADIUS 48u  // of the sphere [m]
#define LUCARIUM_LIGHT_NODE_POWER \
  56u  // most that all of its lights send in one direction [cd], suns to a plane that
       // faces them [lx]; 0: there is no such child
#define LUCARIUM_LIGHT_NODE_COS_CONE 64u   // of the cone's half angle; -1: any direction
#define LUCARIUM_LIGHT_NODE_SIN_CONE 72u   // its sine
#define LUCARIUM_LIGHT_NODE_COS_REACH 80u  // of how far off its axis a light sends anything
#define LUCARIUM_LIGHT_NODE_CHILD 88u      // the word where a node begins, or LUCARIUM_LIGHT_LEAF and a light
#define LUCARIUM_LIGHT_NODE_PLACE 96u      // one: where its parent has this node; LUCARIUM_NONE: a root
#define LUCARIUM_LIGHT_LEAF 0x80000000u

// A place is the word where a node begins, and the child in the lowest three bits.

#endif
