// SPDX-License-Identifier: Apache-2.0
#include "virtual_light_field/directions/direction_grid.clh"
#include "virtual_light_field/tiles/subfield_cells.clh"

// directions: unit vectors; found: node directions and weights of each, three pairs.
__kernel void look_up_directions(uint count, FieldInfo info, __global const uint* restrict nodes,
                                 __global const float4* restrict directions, __global uint* restrict found,
                                 __global float* restrict weights) {
  const uint i = get_global_id(0);
  if (i >= count) return;
  const GridLookup lookup = look_up_direction(info, nodes, directions[i].xyz);
  for (uint q = 0u; q < 3u; ++q) {
    found[3u * i + q] = lookup.direction[q];
    weights[3u * i + q] = lookup.weight[q];
  }
}

// Fills a map of tiles with the subfield coordinates of its cells, in order.
__kernel void fill_cells(uint count, __global const uint* restrict coordinates, __global uint* restrict cells) {
  const uint i = get_global_id(0);
  if (i < count) cells[i] = pack_cell((float3)((float)coordinates[2u * i], (float)coordinates[2u * i + 1u], 1.0f));
}

__kernel void look_up_cells(uint count, __global const FieldMap* restrict maps,
                            __global const uint* restrict tile_cells, __global const uint* restrict cells,
                            __global const float2* restrict points, __global float4* restrict found) {
  const uint i = get_global_id(0);
  if (i < count) found[i] = subfield_radiance(maps[0], tile_cells, cells, points[i]);
}
