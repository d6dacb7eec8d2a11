// SPDX-License-Identifier: Apache-2.0
// Packs hierarchies and gathers that the host made.
#include "micro_rendering/tree/micro_node.clh"

// in: per node 3 float4: centre [grid steps] and radius, normal and cone, radiance and flags.
__kernel void pack_forest(__global const float4* restrict in, uint count, __global uint4* restrict nodes,
                          __global half* restrict radiance) {
  const uint i = get_global_id(0);
  if (i >= count) return;
  MicroNode node;
  node.center = in[3 * i].xyz;
  node.radius = in[3 * i].w;
  node.normal = in[3 * i + 1].xyz;
  node.cone = in[3 * i + 1].w;
  node.flags = (uint)in[3 * i + 2].w;
  node.side = 255u;
  node.line = (float4)(0.0f);
  nodes[i] = pack_node(node);
  vstore_half4((float4)(in[3 * i + 2].xyz, 0.0f), i, radiance);
}

// in: per gather 4 float4: position, normal, geometric normal and GGX alpha, view and edges (B_d + 256 B_s). Results in
// order.
__kernel void pack_gathers(__global const float4* restrict in, uint count, __global MicroGather* restrict gathers) {
  const uint i = get_global_id(0);
  if (i >= count) return;
  ushort alpha;
  vstore_half(in[4 * i + 2].w, 0, (half*)&alpha);
  MicroGather gather;
  gather.position = (float4)(in[4 * i].xyz, as_float(i));
  gather.normal = pack_direction(in[4 * i + 1].xyz);
  gather.geometric = pack_direction(in[4 * i + 2].xyz);
  gather.view = pack_direction(in[4 * i + 3].xyz);
  gather.lobes = (uint)in[4 * i + 3].w | ((uint)alpha << 16);
  gather.eta = 0.0f;
  gather.hidden = 0u;
  gathers[i] = gather;
}
