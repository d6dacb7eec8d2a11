// SPDX-License-Identifier: Apache-2.0
// Which triangles belong together: internal to the surface atlas.
#pragma once
#include <functional>
#include <vector>

#include "lucarium/services/surface_atlas_mesh.h"

namespace lucarium {

/// Sets of triangles, one after the other; every triangle is in one set.
struct ChartSets {
  std::vector<uint32_t> triangles;
  std::vector<uint32_t> first;      ///< of each set in `triangles`, and the end
  std::vector<uint8_t> one_texel;   ///< per set: small enough to be a single texel
  size_t count() const { return one_texel.size(); }
};

/// Connected sets whose normals lie in a cone about that of the set's largest triangle, creases aside; then adjacent small sets
/// joined to texels (at most edge² in area, 2 · edge across, normals within 75 degrees). `by_texcoord` (per instance, may be
/// empty): sets are islands of TEXCOORD_1 instead. `tick(fraction)` is called now and then and may throw.
ChartSets grow_charts(const AtlasMesh& mesh, double edge, const std::vector<uint8_t>& by_texcoord,
                      const std::function<void(double)>& tick);

}  // namespace lucarium
