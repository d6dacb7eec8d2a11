// SPDX-License-Identifier: Apache-2.0
#include "virtual_light_field/directions/direction_grid.clh"
#include "virtual_light_field/tiles/lookup_of_eight.clh"
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

// The same of eight at once: work-item i takes 8 i to 8 i + 7.
__kernel void look_up_directions_by_eight(uint count, FieldInfo info, __global const uint* restrict nodes,
                                          __global const float4* restrict directions, __global uint* restrict found,
                                          __global float* restrict weights) {
  const uint first = 8u * get_global_id(0);
  if (first + 8u > count) return;
  Vectors8 all;
  all.x = MEMBER_OF_EIGHT(float8, directions, first, x);
  all.y = MEMBER_OF_EIGHT(float8, directions, first, y);
  all.z = MEMBER_OF_EIGHT(float8, directions, first, z);
  const GridLookups lookups = look_up_direction_of_eight(info, nodes, &all, 0u);
  for (uint q = 0u; q < 3u; ++q) {
    uint direction[8];
    float weight[8];
    vstore8(lookups.direction[q], 0, direction);
    vstore8(lookups.weight[q], 0, weight);
    for (uint k = 0u; k < 8u; ++k) {
      found[3u * (first + k) + q] = direction[k];
      weights[3u * (first + k) + q] = weight[k];
    }
  }
}

__kernel void look_up_cells_by_eight(uint count, __global const FieldMap* restrict maps,
                                     __global const uint* restrict tile_cells, __global const uint* restrict cells,
                                     __global const float2* restrict points, __global float4* restrict found) {
  const uint first = 8u * get_global_id(0);
  if (first + 8u > count) return;
  FieldLine line;
  line.omega = line.row_w = (float4)(0.0f);
  line.row_x = (float4)(1.0f, 0.0f, 0.0f, 0.0f);
  line.row_y = (float4)(0.0f, 1.0f, 0.0f, 0.0f);
  Vectors8 position;
  position.x = MEMBER_OF_EIGHT(float8, points, first, x);
  position.y = MEMBER_OF_EIGHT(float8, points, first, y);
  position.z = (float8)(0.0f);
  const CellQuads quads = subfield_quads(maps[0], tile_cells, &position, line, (int8)(-1));
  RadianceSums sums = {(float8)(0.0f), (float8)(0.0f), (float8)(0.0f), (float8)(0.0f)};
  for (int q = 0; q < 4; ++q) add_cells(cells, quads.cells[q], quads.weights[q], &sums);
  float r[8], g[8], b[8], weight[8];
  vstore8(sums.r, 0, r);
  vstore8(sums.g, 0, g);
  vstore8(sums.b, 0, b);
  vstore8(sums.weight, 0, weight);
  for (uint k = 0u; k < 8u; ++k)
    found[first + k] = weight[k] > 0.0f ? (float4)((float3)(r[k], g[k], b[k]) / weight[k], weight[k]) : (float4)(0.0f);
}
