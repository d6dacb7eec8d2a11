// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <functional>
#include <string>

#include "lucarium/services/interior_surfaces/texel_interior.h"
#include "lucarium/services/layered_raster/layered_raster.h"
#include "lucarium/services/surface_atlas/surface_atlas.h"
#include "lucarium/services/texel_sides/side_accessibility.h"
#include "lucarium/services/texel_sides/side_light.h"
#include "virtual_light_field/base/plan.h"
#include "virtual_light_field/tiles/patches.h"

namespace lucarium::vlf {

/// What parameters decide of patches.
PatchOptions patch_options(const Parameters& parameters, const SubfieldPlan& subfield);

/// What a field needs of a scene and does not depend on the seed, in the order of dependence.
struct FieldSurfaces {
  using Report = std::function<void(double fraction, const std::string& stage)>;
  /// All must outlive this. `report`: as TechniqueContext::progress.
  FieldSurfaces(Device& device, KernelScheduler& scheduler, const Scene& scene, const SceneBuffers& buffers,
                const Intersector& intersector, const Parameters& parameters, const Plan& plan, const Report& report);
  /// Measures hidden parts and accessibility of texel sides. Throws Error{interrupted} when cancelled.
  void measure(const Report& report);

  SurfaceAtlas atlas;
  TexelInterior interior;
  SideAccessibility accessibility;
  SubfieldPlan subfield;
  Patches patches;
  LayeredRaster raster;
  SideLight light;
};

}  // namespace lucarium::vlf
