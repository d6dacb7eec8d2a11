// SPDX-License-Identifier: Apache-2.0
// Which runs of 16 rays the traversal of wide hierarchies traces as packets.
#define BVH_WIDTH 16
#define BVH_LEAF 8
#define BVH_STACK 128
#include "lucarium/services/bvh/interleaved.clh"
#include "lucarium/services/bvh/packet.clh"
#include "lucarium/services/bvh/traverse.clh"

// One work-item per run; `size` and `extent` as in the header of a hierarchy.
__kernel void find_packets(__global const Ray* rays, uint row, uint count, float size, float extent,
                           __global uint* packets) {
  const uint run = (uint)get_global_id(0);
  const BvhOrder order = bvh_order(row, count);
  const float spread = BVH_PACKET_SPREAD * size;
  BvhPacket packet;
  packets[run] = bvh_run_coherent(rays, bvh_run(order, run), run * BVH_PACKET, count, spread) &&
                 bvh_prepare_packet(rays, bvh_run(order, run), extent, spread, &packet);
}

// Where the rays lie that are traced one after the other.
__kernel void order_rays(uint row, uint count, __global uint* rays) {
  const uint i = (uint)get_global_id(0);
  rays[i] = bvh_ray_at(bvh_order(row, count), i);
}
