// SPDX-License-Identifier: Apache-2.0
// Which texel side each cell of a line shows: the one under the pixel that is nearest to the cell's centre.
#include "lucarium/shared/surface_atlas.h"
#include "virtual_light_field/shared/field.h"

typedef struct Survey {
  const __global AtlasTriangle* atlas_triangles;
  const __global uint* atlas_table;
  uint double_sided;
  const __global FieldMap* maps;
  const __global uint* tile_cells;
  uint facets, shift;
  const __global uint* side_facet;
  __global float* distances;  // of the nearest pixel so far, of the line's cells from first_cell on
  uint first_cell;
  __global uint* cell_side;
} Survey;

#define BUNDLE_PAIRS Survey
#include "virtual_light_field/exchange/line_sides.clh"

void bundle_expect(Survey* survey, uint texel) { LUCARIUM_PREFETCH(survey->side_facet + texel); }

void survey_end(Survey* survey, FragmentSide end, uint2 pixel, uint backwards) {
  if (end.side == LUCARIUM_NONE) return;
  const uint cell = line_cell(survey, survey->side_facet[end.side], pixel, backwards);
  if (cell == LUCARIUM_NONE) return;
  const uint mask = (1u << survey->shift) - 1u;
  const float middle = 0.5f * (float)mask;
  const float dx = (float)(pixel.x & mask) - middle, dy = (float)(pixel.y & mask) - middle;
  const float distance = dx * dx + dy * dy + 1.0f;
  __global float* nearest = survey->distances + (cell - survey->first_cell);
  if (*nearest > 0.0f && *nearest <= distance) return;
  *nearest = distance;
  survey->cell_side[cell] = end.side;
}

void layered_ray_begins(Survey* survey, uint2 pixel, uint payload, bool front) {
  survey_end(survey, fragment_side(survey, payload, front), pixel, 1u);
}
void layered_ray_crosses(Survey* survey, LayeredGap gap) {
  survey_end(survey, fragment_side(survey, gap.near, gap.near_front), gap.pixel, 0u);
  survey_end(survey, fragment_side(survey, gap.far, gap.far_front), gap.pixel, 1u);
}
void layered_ray_ends(Survey* survey, uint2 pixel, uint payload, bool front) {
  survey_end(survey, fragment_side(survey, payload, front), pixel, 0u);
}

// distances: 0 at first. cell_side: LUCARIUM_NONE at first.
__kernel void survey_line(LAYERED_TILE_PARAMETERS AtlasInfo atlas_info, __global const AtlasTriangle* atlas_triangles,
                          __global const uint* atlas_table, FieldInfo info, uint line, uint first_cell, uint shift,
                          __global const FieldMap* maps, __global const uint* tile_cells,
                          __global const uint* side_facet, __global float* distances, __global uint* cell_side) {
  Survey survey;
  survey.atlas_triangles = atlas_triangles;
  survey.atlas_table = atlas_table;
  survey.double_sided = atlas_info.double_sided_count;
  survey.maps = maps + (size_t)(2u * line) * info.facets;
  survey.tile_cells = tile_cells;
  survey.facets = info.facets;
  survey.shift = shift;
  survey.side_facet = side_facet;
  survey.distances = distances;
  survey.first_cell = first_cell;
  survey.cell_side = cell_side;
  LAYERED_RUN_TILES(&survey);
}
