// SPDX-License-Identifier: Apache-2.0
// Which triangles belong together: internal to the surface atlas.
#pragma once
#include <functional>
#include <vector>

#include "lucarium/services/surface_atlas/layout/mesh.h"

namespace lucarium {

/// Sets of triangles, one after the other; every triangle that is not left out is in one set.
struct ChartSets {
  std::vector<uint32_t> triangles;
  std::vector<uint32_t> first;     ///< of each set in `triangles`, and the end
  std::vector<uint8_t> one_texel;  ///< per set: small enough to be a single texel
  size_t count() const { return one_texel.size(); }
};

/// Per triangle its chart, or LUCARIUM_NONE where it is left out.
struct GrownCharts {
  std::vector<uint32_t> chart_of;
  uint32_t count = 0;
};

/// Connected sets whose normals lie in a cone about that of the set's largest triangle, creases aside. Where
/// `texcoord_scale` (per instance, may be empty) is not 0, sets are islands of TEXCOORD_1 instead. `tick(fraction)` is
/// called now and then and may throw.
GrownCharts grow_charts(const AtlasMesh& mesh, const std::vector<double>& texcoord_scale,
                        const std::function<void(double)>& tick);

/// Adjacent small charts joined to single texels: at most edge² in area, 2 · edge across, normals within 75 degrees.
ChartSets join_small_charts(const AtlasMesh& mesh, const GrownCharts& grown, double edge);

}  // namespace lucarium
