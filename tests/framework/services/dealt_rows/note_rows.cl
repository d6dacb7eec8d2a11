// SPDX-License-Identifier: Apache-2.0
#include "lucarium/services/dealt_rows/dealt_rows.clh"

// The row that each work-item of a pass over `count` rows takes, dealt to `columns` columns.
__kernel void note_rows(__global uint* restrict rows, uint count, uint columns) {
  const uint item = get_global_id(0);
  rows[item] = dealt_row(item, count, columns);
}

// How often each row is taken of a pass of deal_rows().
__kernel void note_own_rows(__global uint* restrict times, DEALT_ROW_PARAMETER) { atomic_inc(times + DEALT_ROW); }

// The same of a pass with slices, whose last one may have more work-items than there are rows left.
__kernel void note_rows_of_slices(__global uint* restrict times, uint count, DEALT_ROW_PARAMETER, uint slice_base) {
  const uint row = DEALT_ROW + slice_base;
  if (row < count) atomic_inc(times + row);
}
