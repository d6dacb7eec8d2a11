// SPDX-License-Identifier: Apache-2.0
// Which texel side each cell of a line shows: the one under the pixel that is nearest to the cell's centre.
#include "virtual_light_field/exchange/line_rows.clh"

typedef struct Survey {
  LINE_ROWS_MEMBERS
  const __global uint* side_facet;
  uint sides;
  __global float* distances;       // of the nearest pixel so far, of the line's cells: those from first_cell on, then
  uint first_coarse, coarse_base;  // those from first_coarse on, less coarse_base
  __global uint* cell_side;
} Survey;

#define BUNDLE_PAIRS Survey
#include "virtual_light_field/exchange/line_sides.clh"

void bundle_expect(Survey* survey, uint texel) { LUCARIUM_PREFETCH(survey->side_facet + texel); }

#include "lucarium/services/texel_sides/kept_rows.clh"

void survey_end(Survey* survey, uint side, uint2 pixel, uint backwards) {
  if (side == LUCARIUM_NONE) return;
  const uint cell = line_cell(survey, survey->side_facet[side], pixel, backwards);
  if (cell == LUCARIUM_NONE) return;
  const uint mask = (1u << survey->shift) - 1u;
  const float middle = 0.5f * (float)mask;
  const float dx = (float)(pixel.x & mask) - middle, dy = (float)(pixel.y & mask) - middle;
  const float distance = dx * dx + dy * dy + 1.0f;
  __global float* nearest =
      survey->distances + (cell - (cell < survey->first_coarse ? survey->first_cell : survey->coarse_base));
  if (*nearest > 0.0f && *nearest <= distance) return;
  *nearest = distance;
  survey->cell_side[cell] = side;
}

void survey_gap(Survey* survey, uint near_side, uint far_side, uint2 pixel) {
  survey_end(survey, near_side, pixel, 0u);
  survey_end(survey, far_side, pixel, 1u);
}

void layered_ray_begins(Survey* survey, uint2 pixel, uint payload, bool front) {
  survey_end(survey, fragment_side(survey, payload, front).side, pixel, 1u);
}
void layered_ray_crosses(Survey* survey, LayeredGap gap) {
  survey_gap(survey, fragment_side(survey, gap.near, gap.near_front).side,
             fragment_side(survey, gap.far, gap.far_front).side, gap.pixel);
}
void layered_ray_ends(Survey* survey, uint2 pixel, uint payload, bool front) {
  survey_end(survey, fragment_side(survey, payload, front).side, pixel, 0u);
}

// The side of a kept end.
uint kept_side(const Survey* survey, uint end) {
  const uint half_side = KEPT_HALF(end);
  return half_side < survey->sides ? half_side : half_side - survey->sides;
}
void kept_expect(Survey* survey, uint end) { bundle_expect(survey, kept_side(survey, end)); }
void kept_ray_begins(Survey* survey, uint2 pixel, uint end) { survey_end(survey, kept_side(survey, end), pixel, 1u); }
void kept_ray_crosses(Survey* survey, uint2 pixel, uint near, uint far) {
  survey_gap(survey, kept_side(survey, near), kept_side(survey, far), pixel);
}
void kept_ray_meets_back(Survey* survey, uint2 pixel, uint end, uint backwards, float share) {
  survey_end(survey, kept_side(survey, end), pixel, backwards);
}
void kept_ray_ends(Survey* survey, uint2 pixel, uint end) { survey_end(survey, kept_side(survey, end), pixel, 0u); }

#define SURVEY_SET(survey)                    \
  LINE_ROWS_SET(survey)                       \
  (survey)->side_facet = side_facet;          \
  (survey)->sides = atlas_info.texel_count;   \
  (survey)->distances = distances;            \
  (survey)->first_coarse = info.first_coarse; \
  (survey)->coarse_base = coarse_base;        \
  (survey)->cell_side = cell_side;

// distances: 0 at first. cell_side: LUCARIUM_NONE at first.
__kernel void survey_line(LAYERED_TILE_PARAMETERS LINE_ROWS_PARAMETERS, uint coarse_base,
                          __global const uint* side_facet, __global float* distances, __global uint* cell_side) {
  Survey survey;
  SURVEY_SET(&survey);
  survey.sheets = bundle_sheets(atlas_points, layered_views + layered_view);
  LAYERED_RUN_TILES(&survey);
}

// The same of a line whose fragments are kept.
__kernel void survey_kept_line(LAYERED_KEPT_PARAMETERS LINE_ROWS_PARAMETERS, uint coarse_base,
                               __global const uint* side_facet, __global float* distances, __global uint* cell_side) {
  Survey survey;
  SURVEY_SET(&survey);
  LAYERED_WALK_KEPT(&survey);
}
