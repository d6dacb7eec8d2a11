// SPDX-License-Identifier: Apache-2.0
#include "lucarium/shared/camera.h"
#include "lucarium/shared/gbuffer.h"
#include "lucarium/shared/ray.h"
#include "lucarium/shared/scene_types.h"
#include "lucarium/shared/surface_point.h"
#include "test_kernels/struct_fields.clh"

#define SIZE(S) sizes[i++] = (uint)sizeof(S);
#define FIELD(S, f)                                  \
  fields[2 * k] = (uint)__builtin_offsetof(S, f);    \
  fields[2 * k++ + 1] = (uint)sizeof(((S*)0)->f);

kernel void report_layout(global uint* sizes, global uint* fields) {
  uint i = 0, k = 0;
  LUCARIUM_SHARED_STRUCTS(SIZE)
  LUCARIUM_SHARED_FIELDS(FIELD)
}
