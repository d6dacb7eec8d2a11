// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <string>
#include <vector>

#include "lucarium/services/surface_atlas/surface_atlas.h"
#include "lucarium/technique/technique.h"
#include "virtual_light_field/base/parameters.h"

namespace lucarium::vlf {

/// What parameters and scene ask for, known before anything is built.
struct Plan {
  SurfaceAtlasOptions atlas;
  bool field = true;           ///< light is propagated at all
  bool lobes = false;          ///< some surface has specular lobes
  bool fold = true;            ///< coats below tile_albedo reflect diffusely in propagation
  bool first_surface = false;  ///< pixels look up the tiles of mirrors and glass
  bool traced = true;          ///< pixels send rays by specular lobes
  uint32_t halves = 1;         ///< SideAccessibility::Options::halves
  bool sampled = true;         ///< the first sweep's irradiance is that of light samples
  uint32_t light_kinds = 0;    ///< of light samples at texel sides
  uint32_t eye_kinds = 0;      ///< of light samples at pixels; 0: the atlas shows direct light
  int max_bounces = -1;
};
Plan make_plan(const Parameters& parameters, const Scene& scene, const RenderSettings& settings);

constexpr uint32_t kMinSubfield = 16;  ///< cells along an edge, at least

/// Subfields: N cells of edge c along an edge, ss² pixels to a cell.
struct SubfieldPlan {
  uint32_t cells = 0;
  double cell = 0;     ///< [m]
  uint32_t shift = 0;  ///< log2 of ss
  double pixel() const { return cell / (1u << shift); }
};
/// `area`: of all reflecting sides [m²]; `texel_edge` [m]; `min_pixel`: below it work-items meet at a texel [m].
SubfieldPlan plan_subfield(const Parameters& parameters, const Bounds& bounds, double area, double texel_edge,
                           double min_pixel);

}  // namespace lucarium::vlf
