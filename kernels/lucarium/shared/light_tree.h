// SPDX-License-Identifier: Apache-2.0
// Memory layout of the light trees (framework/lucarium/scene/device/light_tree.h), in 32-bit words: one tree per kind
// of light (LUCARIUM_LIGHT_*), of nodes with up to 8 children. A node is structure-of-arrays, so that it is a few
// vector loads.
#ifndef LUCARIUM_SHARED_LIGHT_TREE_H
#define LUCARIUM_SHARED_LIGHT_TREE_H

#define LUCARIUM_LIGHT_KINDS 5u

// The buffer begins with a header of 24 words.
#define LUCARIUM_LIGHT_TREE_HEADER 24u
#define LUCARIUM_LIGHT_TREE_ROOTS 0u   // per kind: the word where its root begins, 0: it has no tree
#define LUCARIUM_LIGHT_TREE_KINDS 5u   // bits of the kinds that there are; 0: light samples choose from the table
#define LUCARIUM_LIGHT_TREE_POWERS 8u  // 8: per kind, of lights at infinity what they send a plane that faces them [lx]
#define LUCARIUM_LIGHT_TREE_SUN_X 16u  // axis of a cone that holds the ways of all directional lights, unit
#define LUCARIUM_LIGHT_TREE_SUN_Y 17u
#define LUCARIUM_LIGHT_TREE_SUN_Z 18u
#define LUCARIUM_LIGHT_TREE_SUN_COS 19u  // of its half angle

// A node: rows of 8 floats, one per child. What a child's lights send is bounded: they lie in a sphere, their axes (a
// triangle's front normal, a spot's direction) in a cone.
#define LUCARIUM_LIGHT_NODE_WORDS 104u
#define LUCARIUM_LIGHT_NODE_CENTER 0u   // x, y, z: three rows [m]
#define LUCARIUM_LIGHT_NODE_AXIS 24u    // of the cone, unit; x, y, z: three rows
#define LUCARIUM_LIGHT_NODE_RADIUS 48u  // of the sphere [m]
#define LUCARIUM_LIGHT_NODE_POWER \
  56u                                      // most that all of its lights send in one direction [cd]; of directional
                                           // ones their sum [lx]; 0: there is no such child
#define LUCARIUM_LIGHT_NODE_COS_CONE 64u   // of the cone's half angle; -1: any direction
#define LUCARIUM_LIGHT_NODE_SIN_CONE 72u   //
#define LUCARIUM_LIGHT_NODE_COS_REACH 80u  // of how far off its axis a light sends anything
#define LUCARIUM_LIGHT_NODE_CHILD 88u      // the word where a node begins, or the flag below and a light
#define LUCARIUM_LIGHT_NODE_PLACE 96u      // one: where its parent has this node; 0: a root
#define LUCARIUM_LIGHT_LEAF 0x80000000u

// A place is the word where a node begins, and the child in the lowest three bits.

#endif
