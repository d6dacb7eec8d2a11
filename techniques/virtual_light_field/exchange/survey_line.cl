// SPDX-License-Identifier: Apache-2.0
// Which texel side each cell of a line shows: the one under the pixel that is nearest to the cell's centre.
#include "virtual_light_field/exchange/line_rows.clh"

typedef struct Survey {
  LINE_ROWS_MEMBERS
  const __global uint* side_facet;
  __global float* distances;       // of the nearest pixel so far, of the line's cells: those from first_cell on, then
  uint first_coarse, coarse_base;  // those from first_coarse on, less coarse_base
  __global uint* cell_side;
} Survey;

#define BUNDLE_PAIRS Survey
#include "virtual_light_field/exchange/line_sides.clh"

void bundle_expect(Survey* survey, uint texel) { LUCARIUM_PREFETCH(survey->side_facet + texel); }

#include "lucarium/services/layered_raster/kept_rows.clh"

void layered_expect(Survey* survey, uint payload) { bundle_expect(survey, payload & BUNDLE_TEXEL); }

void survey_end(Survey* survey, FragmentSide end, uint2 pixel, uint backwards) {
  if (end.side == LUCARIUM_NONE) return;
  const uint cell = line_cell(survey, survey->side_facet[end.side], pixel, backwards);
  if (cell == LUCARIUM_NONE) return;
  const uint mask = (1u << survey->shift) - 1u;
  const float middle = 0.5f * (float)mask;
  const float dx = (float)(pixel.x & mask) - middle, dy = (float)(pixel.y & mask) - middle;
  const float distance = dx * dx + dy * dy + 1.0f;
  __global float* nearest =
      survey->distances + (cell - (cell < survey->first_coarse ? survey->first_cell : survey->coarse_base));
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

#define SURVEY_SET(survey)                    \
  LINE_ROWS_SET(survey)                       \
  (survey)->side_facet = side_facet;          \
  (survey)->distances = distances;            \
  (survey)->first_coarse = info.first_coarse; \
  (survey)->coarse_base = coarse_base;        \
  (survey)->cell_side = cell_side;

// distances: 0 at first. cell_side: LUCARIUM_NONE at first.
__kernel void survey_line(LAYERED_TILE_PARAMETERS LINE_ROWS_PARAMETERS, uint coarse_base,
                          __global const uint* side_facet, __global float* distances, __global uint* cell_side) {
  Survey survey;
  SURVEY_SET(&survey);
  LAYERED_RUN_TILES(&survey);
}

// The same of a line whose fragments are kept.
__kernel void survey_kept_line(LAYERED_KEPT_PARAMETERS LINE_ROWS_PARAMETERS, uint coarse_base,
                               __global const uint* side_facet, __global float* distances, __global uint* cell_side) {
  Survey survey;
  SURVEY_SET(&survey);
  LAYERED_WALK_KEPT(&survey);
}
