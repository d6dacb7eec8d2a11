// SPDX-License-Identifier: Apache-2.0
// Packs and unpacks nodes that the host gives as floats.
#include "micro_rendering/tree/micro_node.clh"

// in: per node 3 float4: centre and radius, normal and cone, flags. out: the same after packing.
__kernel void round_trip_nodes(__global const float4* restrict in, uint count, __global float4* restrict out) {
  const uint i = get_global_id(0);
  if (i >= count) return;
  MicroNode node;
  node.center = in[3 * i].xyz;
  node.radius = in[3 * i].w;
  node.normal = in[3 * i + 1].xyz;
  node.cone = in[3 * i + 1].w;
  node.flags = (uint)in[3 * i + 2].x;
  node.side = i % 256u;
  node.line = (float4)(0.0f);
  const MicroNode back = unpack_node(pack_node(node));
  out[3 * i] = (float4)(back.center, back.radius);
  out[3 * i + 1] = (float4)(back.normal, back.cone);
  out[3 * i + 2] = (float4)((float)back.flags + 16.0f * (float)(back.side != i % 256u), 0.0f, 0.0f, 0.0f);
}
