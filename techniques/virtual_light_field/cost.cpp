// SPDX-License-Identifier: Apache-2.0
#include "virtual_light_field/cost.h"

#include <algorithm>
#include <cmath>

#include "lucarium/services/texel_sides/side_light.h"
#include "lucarium/shared/texel_sides.h"
#include "virtual_light_field/field/field_surfaces.h"
#include "virtual_light_field/field/light_field.h"
#include "virtual_light_field/pixels/field_view.h"
#include "virtual_light_field/tiles/cell_estimate.h"

namespace lucarium::vlf {
namespace {

constexpr double kAtlasSeconds = 6e-6;            // a texel of the atlas, with what is hidden of it
constexpr double kChartSeconds = 3e-6;            // a triangle
constexpr double kAccessibilitySeconds = 4e-8;    // a ray of a texel that measures accessibility
constexpr double kSideLightSeconds = 1.8e-5;      // a texel's first light samples
constexpr double kFirstLightSamples = 64;         // so many
constexpr double kSubfieldPixelSeconds = 1.5e-7;  // a pixel of a subfield, in a sweep
constexpr double kKeptPixelSeconds = 3e-8;        // the same where fragments are kept
constexpr double kKeptEndSeconds = 1.4e-8;        // a kept end of a ray, in a sweep
constexpr double kTriangleSeconds = 1e-7;         // a triangle, in a line: its setup, and its pixels
constexpr double kKeepingSubfields = 1.5;         // what keeping a subfield takes, of drawing it
constexpr double kPixelSeconds = 2e-6;            // a sample of a pixel
constexpr double kSweeps = 6;                     // of unlimited bounces
constexpr double kTileBytes = 24;                 // a tile's share of norms, and its place in the list

/// Per instance, 1 where its material is likely to have tiles (patches.h).
std::vector<uint8_t> tiled_instances(const Parameters& parameters, const Scene& scene) {
  std::vector<uint8_t> tiled;
  for (const SceneMaterial& m : scene.materials)
    tiled.push_back(is_tiled(m, static_cast<double>(parameters.tile_albedo)) ? 1 : 0);
  std::vector<uint8_t> result;
  for (const SceneInstance& instance : scene.instances) result.push_back(tiled[static_cast<size_t>(instance.material)]);
  return result;
}

/// Of cells with their index [bytes].
size_t cell_bytes(const Parameters& parameters, const CellCounts& counts) {
  const double cell = LightField::kCellBytes + (parameters.split_layers ? LightField::kSplitBytes : 0);
  // Sums of the line that has most cells, about twice the mean.
  const double lines = 2. * parameters.dir_n * parameters.dir_n + 1;
  const double sums = 2 * (1 - counts.coarse_cells / std::max(counts.cells, 1.)) *
                      (parameters.perturb > 1 ? FIELD_FIXED_WORDS * sizeof(uint32_t) : sizeof(float4)) / lines;
  const double coarse = FIELD_FIXED_WORDS * sizeof(uint32_t) * counts.coarse_cells;
  return static_cast<size_t>(counts.cells * (cell + sums) + coarse + counts.tiles * kTileBytes +
                             counts.entries * sizeof(uint32_t) + counts.maps * sizeof(FieldMap));
}

double area_of(const Plan& plan, const Scene& scene) {
  const double edge = SurfaceAtlas::estimate_edge(scene, plan.atlas);
  return edge * edge * static_cast<double>(plan.atlas.texel_count);
}

SubfieldPlan expected_subfield(const Plan& plan, const Parameters& parameters, const Scene& scene) {
  return plan_subfield(parameters, scene.bounds(), area_of(plan, scene), SurfaceAtlas::estimate_edge(scene, plan.atlas),
                       0);
}

/// For all ends of rays, whether or not that many may be kept [bytes].
size_t kept_bytes(const Parameters& parameters, const SubfieldPlan& subfield, double area) {
  return KeptRows::estimate_bytes(LightField::estimate_ends(
      static_cast<uint32_t>(parameters.dir_n), static_cast<uint32_t>(parameters.perturb), subfield.pixel(), area));
}

/// What rays through so many triangles cost over those through a few dozen: they go down the hierarchy's levels.
double ray_depth(double triangles) { return std::max(1., (std::log2(std::max(triangles, 1.)) - 4) / 2); }

/// Whether subfields are drawn once, and fragments kept for later sweeps where there is room.
bool keeps_any(const Plan& plan, const Scene& scene) {
  return (plan.max_bounces < 0 || plan.max_bounces >= LightField::kKeptBounces) && SubfieldRuns::can_keep(scene);
}

}  // namespace

double estimate_seconds(const Plan& plan, const Parameters& parameters, const Scene& scene,
                        const RenderSettings& settings, const ComputePower& power) {
  const auto texels = static_cast<double>(plan.atlas.texel_count),
             triangles = static_cast<double>(scene.triangle_count());
  double device = double{1} * settings.width * settings.height * kPixelSeconds;
  double host = 0;
  if (plan.field) {
    host = texels * kAtlasSeconds + triangles * kChartSeconds;
    const SubfieldPlan subfield = expected_subfield(plan, parameters, scene);
    const double lines = 2. * parameters.dir_n * parameters.dir_n + 1,
                 edge = std::ldexp(subfield.cells, static_cast<int>(subfield.shift));
    const double sweeps = plan.max_bounces >= 0 ? plan.max_bounces + 1. : kSweeps;
    const double drawn = edge * edge * kSubfieldPixelSeconds + triangles * kTriangleSeconds,
                 kept = kKeptEndSeconds *
                        LightField::estimate_ends(static_cast<uint32_t>(parameters.dir_n), 1, subfield.pixel(),
                                                  SurfaceAtlas::side_area(scene)) /
                        lines;
    const bool keeps = keeps_any(plan, scene) && kept_bytes(parameters, subfield, SurfaceAtlas::side_area(scene)) <=
                                                     static_cast<size_t>(parameters.cache_visibility) << 20;
    const double subfield_seconds = keeps ? kKeepingSubfields * drawn + sweeps * kept : (sweeps + 1) * drawn;
    const double previews =
        parameters.preview ? LightField::estimate_preview_subfields(field_options(plan, parameters)) : 0;
    device += texels * (parameters.access_rays * kAccessibilitySeconds +
                        (plan.sampled ? kSideLightSeconds * ray_depth(triangles) : 0)) +
              parameters.perturb * lines * subfield_seconds + previews * drawn;
  }
  return host / power.host + device / power.device;
}

double light_seconds(uint32_t samples) { return samples * kSideLightSeconds / kFirstLightSamples; }
double subfield_seconds(double subfield_pixels, double drawn) {
  return subfield_pixels * (drawn * kSubfieldPixelSeconds + (1 - drawn) * kKeptPixelSeconds);
}
double eye_seconds(uint32_t pixels) { return pixels * kPixelSeconds; }

std::vector<ParameterSaving> savings() {
  return {{"access_rays", {"128"}},
          {"dir_n", {"12", "8"}},
          {"texels", {"131072", "65536", "32768", "16384", "8192"}},
          {"dir_n", {"6"}, true}};
}

size_t estimate_bytes(const Plan& plan, const Parameters& parameters, const Scene& scene,
                      const RenderSettings& settings) {
  const FieldView::Options seen = FieldView::make_options(plan, parameters);
  size_t view = FieldView::estimate_bytes(settings.width, settings.height, seen);
  if (!plan.field) return view;
  const size_t sides = SurfaceAtlas::expected_sides(scene, plan.atlas);
  if (seen.walks())
    view += WalkTables::estimate_bytes(static_cast<size_t>(scene.triangle_count()), scene.materials.size(),
                                       sides * plan.halves);
  const size_t always =
      SurfaceAtlas::estimate_bytes(scene, plan.atlas, sides) + SideLight::estimate_bytes(sides, plan.halves);
  const SubfieldPlan subfield = expected_subfield(plan, parameters, scene);
  const auto raster = [&](size_t schedules) {
    LayeredRasterOptions options;
    options.max_width = options.max_height = std::min(subfield.cells << subfield.shift, LAYERED_MAX_EDGE);
    return LayeredRaster::estimate_bytes(static_cast<size_t>(scene.triangle_count()), options, std::nullopt, schedules);
  };
  const size_t measuring =
      TexelInterior::estimate_bytes(sides, SIDE_POINTS) + SideAccessibility::estimate_bytes(sides, plan.halves);
  const std::vector<uint8_t> tiled = tiled_instances(parameters, scene);
  const bool has_cells = std::find(tiled.begin(), tiled.end(), 1) != tiled.end(),
             keeps = keeps_any(plan, scene) && parameters.cache_visibility > 0;
  size_t field = view + TexelInterior::held_bytes(sides) + SideAccessibility::held_bytes(sides, plan.halves) +
                 LightField::estimate_bytes(sides, plan.halves) + raster(1 + (has_cells ? 1 : 0) + (keeps ? 1 : 0));
  if (keeps)
    field += std::min(static_cast<size_t>(parameters.cache_visibility) << 20,
                      kept_bytes(parameters, subfield, SurfaceAtlas::side_area(scene)));
  if (has_cells) {
    field += cell_bytes(parameters, expect_cells(scene, tiled, patch_options(parameters, subfield),
                                                 SurfaceAtlas::estimate_edge(scene, plan.atlas), subfield.cells,
                                                 static_cast<uint32_t>(parameters.dir_n)));
    field += CellScatter::estimate_bytes(sides, !scene.lights.empty());
  }
  return always + std::max(measuring + raster(1), field);
}

}  // namespace lucarium::vlf
