// SPDX-License-Identifier: Apache-2.0
#include "virtual_light_field/base/plan.h"

#include <algorithm>
#include <cmath>

#include "lucarium/base/error.h"
#include "lucarium/compute/device/remedies.h"
#include "lucarium/services/direct_light/direct_light.h"
#include "lucarium/services/texel_sides/side_halves.h"
#include "lucarium/shared/layered_raster.h"
#include "lucarium/shared/texel_sides.h"
#include "virtual_light_field/directions/direction_grid.h"

namespace lucarium::vlf {
namespace {

constexpr double kCellShare =
    0.37;  // of δ times the mean chord (Mortensen et al. 2007, section 6: a ratio that could be computed)
constexpr uint32_t kMinAutomatic = 64, kMaxAutomatic = 256;
constexpr double kBorder = 2;  // cells around the bounding sphere: shift and interpolation

bool has_specular_lobes(const Scene& scene) {
  return std::any_of(scene.materials.begin(), scene.materials.end(),
                     [](const SceneMaterial& m) { return m.has_specular_lobes(); });
}

}  // namespace

Plan make_plan(const Parameters& parameters, const Scene& scene, const RenderSettings& settings) {
  Plan plan;
  plan.atlas.samples = SIDE_POINTS;
  plan.atlas.remedy = remedies::lower_texels;
  plan.atlas.texel_count = parameters.texels > 0
                               ? static_cast<uint64_t>(parameters.texels)
                               : suitable_texels(uint64_t{settings.width} * settings.height, scene.triangle_count());
  const bool samples = parameters.eye_direct == EyeDirect::samples, punctual = !scene.lights.empty();
  plan.max_bounces = settings.max_bounces;
  const bool surfaces = SurfaceAtlas::estimate_edge(scene, plan.atlas) > 0;
  plan.field = surfaces && (settings.max_bounces != 0 || !samples || parameters.eye_glossy == EyeLobes::vlf ||
                            parameters.eye_specular == EyeLobes::vlf);
  plan.lobes = has_specular_lobes(scene);
  plan.first_surface = plan.lobes && parameters.eye_specular == EyeLobes::vlf;
  plan.halves = SideHalves::per_side(scene, parameters.access_gap);
  plan.fold = parameters.weak_lobes == WeakLobes::fold;
  plan.traced = plan.lobes && parameters.eye_glossy == EyeLobes::trace;
  plan.sampled = parameters.direct_mode == DirectMode::nee;
  plan.light_kinds = plan.sampled ? DirectLight::kAllLights : punctual ? DirectLight::kPunctualLights : 0;
  plan.eye_kinds = samples ? DirectLight::kAllLights : 0;
  return plan;
}

SubfieldPlan plan_subfield(const Parameters& parameters, const Bounds& bounds, double area, double texel_edge,
                           double min_pixel) {
  const double diameter = std::max(2.0 * static_cast<double>(bounds.radius()), 1e-6);
  SubfieldPlan plan;
  plan.cells = kMinAutomatic;
  if (parameters.cells > 0) {
    plan.cells = static_cast<uint32_t>(parameters.cells);
  } else if (!bounds.empty() && area > 0) {
    const glm::dvec3 size = glm::dvec3(bounds.max) - glm::dvec3(bounds.min);
    const double chord = 4 * size.x * size.y * size.z / area;
    const double cell = kCellShare * DirectionGrid::spacing(static_cast<uint32_t>(parameters.dir_n)) * chord;
    if (cell > 0)
      plan.cells = static_cast<uint32_t>(
          std::clamp(std::ceil(diameter / cell) + kBorder, double{kMinAutomatic}, double{kMaxAutomatic}));
  }
  const uint32_t max_shift =
      parameters.supersample == Supersample::automatic
          ? 3
          : static_cast<uint32_t>(parameters.supersample) - static_cast<uint32_t>(Supersample::one);
  if (parameters.supersample != Supersample::automatic && (plan.cells << max_shift) > LAYERED_MAX_EDGE)
    throw_error(
        ErrorClass::usage,
        "virtual_light_field: cells={} with supersample={} makes subfields of {} pixels, more than {}; lower one",
        plan.cells, 1u << max_shift, plan.cells << max_shift, LAYERED_MAX_EDGE);
  // Cells must not be smaller than the pixels that keep work-items apart at texels.
  const auto cell_of = [&](uint32_t subfield) { return diameter / (subfield - kBorder); };
  while (plan.cells > kMinSubfield && cell_of(plan.cells) < min_pixel) --plan.cells;
  plan.cell = std::max(cell_of(plan.cells), min_pixel);
  const double wanted =
      parameters.supersample == Supersample::automatic ? static_cast<double>(parameters.pixel_size) * texel_edge : 0;
  while (plan.shift < max_shift && plan.pixel() > wanted && plan.pixel() / 2 >= min_pixel &&
         (plan.cells << (plan.shift + 1)) <= LAYERED_MAX_EDGE)
    ++plan.shift;
  return plan;
}

}  // namespace lucarium::vlf
