// SPDX-License-Identifier: Apache-2.0
#include "virtual_light_field/field/field_surfaces.h"

#include <algorithm>

#include "lucarium/base/error.h"
#include "lucarium/compute/device/remedies.h"
#include "lucarium/services/bundles/bundle_view.h"
#include "lucarium/services/texel_sides/texel_extent.h"
#include "virtual_light_field/base/field_program.h"

namespace lucarium::vlf {
namespace {

SurfaceAtlasOptions atlas_options(const Plan& plan, const FieldSurfaces::Report& report) {
  SurfaceAtlasOptions options = plan.atlas;
  options.progress = [report](double fraction, const std::string& stage) {
    report(fraction, "surface atlas, " + stage);
  };
  return options;
}

/// Of subfields [m]: smaller ones would let two work-items, 16 pixels apart, add to the same texel.
double min_pixel(const SurfaceAtlas& atlas, const SceneBuffers& buffers, const Parameters& parameters) {
  const double smallest = 0.5 * static_cast<double>(parameters.pixel_size * atlas.info().texel_edge);
  return largest_texel_extent(atlas, buffers, smallest * LAYERED_TILE_ROWS) / LAYERED_TILE_ROWS;
}

/// For subfields, and for the bundles that measure accessibility.
LayeredRasterOptions raster_options(const Scene& scene, const SubfieldPlan& subfield, double safe_pixel) {
  LayeredRasterOptions options;
  options.max_width = options.max_height =
      std::max(subfield.cells << subfield.shift, bundle_side(scene.bounds(), safe_pixel));
  options.remedy = "lower cells";
  return options;
}

}  // namespace

PatchOptions patch_options(const Parameters& parameters, const SubfieldPlan& subfield) {
  PatchOptions options;
  options.tile_albedo = static_cast<double>(parameters.tile_albedo);
  options.cone = static_cast<double>(parameters.patch_cone);
  options.tile = static_cast<uint32_t>(parameters.tile);
  options.rows = parameters.store == Store::csr;
  options.cell = subfield.cell;
  options.dir_n = static_cast<uint32_t>(parameters.dir_n);
  options.levels = static_cast<uint32_t>(parameters.dir_levels);
  return options;
}

FieldSurfaces::FieldSurfaces(Device& device, KernelScheduler& scheduler, const Scene& scene,
                             const SceneBuffers& buffers, const Intersector& intersector, const Parameters& parameters,
                             const Plan& plan, const Report& report)
    : atlas(device, scheduler, scene, buffers, atlas_options(plan, report), technique_name),
      interior(device, scheduler, buffers, intersector, atlas, technique_name, remedies::lower_texels),
      accessibility(device, buffers, atlas,
                    {parameters.pixel_size, parameters.access_gap, parameters.access_rays, plan.halves}, technique_name,
                    remedies::lower_texels),
      subfield(plan_subfield(parameters, scene.bounds(), atlas.report().area,
                             static_cast<double>(atlas.info().texel_edge), min_pixel(atlas, buffers, parameters))),
      patches(make_patches(atlas, buffers, patch_options(parameters, subfield))),
      raster(scheduler, buffers, raster_options(scene, subfield, accessibility.safe_pixel()), technique_name),
      light(device, scheduler, buffers, intersector, atlas, accessibility, plan.light_kinds, technique_name,
            remedies::lower_texels) {
  accessibility.begin(device, scheduler, scene, buffers, atlas, interior, raster);
}

void FieldSurfaces::measure(const Report& report) {
  const auto check = [](bool completed) {
    if (!completed)
      throw Error(ErrorClass::interrupted,
                  "virtual_light_field: interrupted while preparing the texels; nothing was kept");
  };
  while (!interior.complete()) {
    report(interior.progress(), "hidden places");
    check(interior.advance());
  }
  while (!accessibility.complete()) {
    report(accessibility.progress(), accessibility.measured());
    check(accessibility.advance());
  }
}

}  // namespace lucarium::vlf
