// SPDX-License-Identifier: Apache-2.0
#include "lucarium/services/texel_sides/bundle_sheets.clh"

// Whether texel 0 and each texel may be of sheets in one place.
__kernel void fit_sheets(__global const SurfacePoint* restrict points, __global uint* restrict fits) {
  const uint i = (uint)get_global_id(0);
  const BundleSheets sheets = {points, (float3)(0.0f, 0.0f, 1.0f), 1.0f};
  fits[i] = bundle_sheets_fit(&sheets, 0u, i);
}
