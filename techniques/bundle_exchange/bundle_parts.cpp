// SPDX-License-Identifier: Apache-2.0
#include "bundle_exchange/bundle_parts.h"

#include <algorithm>
#include <cmath>

#include "bundle_exchange/base/bundle_program.h"
#include "bundle_exchange/base/name.h"
#include "lucarium/base/error.h"
#include "lucarium/compute/device/remedies.h"
#include "lucarium/services/bvh/bvh.h"
#include "lucarium/services/surface_atlas/inspect.h"

namespace lucarium::bundle {
namespace {

std::unique_ptr<SurfaceAtlas> make_atlas(const TechniqueContext& c, SurfaceAtlasOptions options) {
  options.progress = [report = c.progress](double fraction, const std::string& stage) {
    report(fraction, "surface atlas, " + stage);
  };
  return std::make_unique<SurfaceAtlas>(*c.device, c.scheduler, c.scene, c.scene_buffers, options, technique_name);
}

}  // namespace

BundleParts::BundleParts(const TechniqueContext& c, const Parameters& p, const BundlePlan& plan, Kept kept)
    : atlas(kept.atlas ? std::move(kept.atlas) : make_atlas(c, plan.atlas)),
      program(make_technique_program(*c.device, plan.channels.defines())),
      interior(kept.interior ? std::move(kept.interior)
                             : std::make_unique<TexelInterior>(*c.device, c.scheduler, c.scene_buffers, c.bvh(), *atlas,
                                                               technique_name, remedies::lower_texels)),
      accessibility(kept.accessibility
                        ? std::move(kept.accessibility)
                        : std::make_unique<SideAccessibility>(
                              *c.device, c.scene_buffers, *atlas,
                              SideAccessibility::Options{p.pixel_size, p.access_gap, p.access_rays, plan.halves},
                              technique_name, remedies::lower_texels)),
      side_light(*c.device, c.scheduler, c.scene_buffers, c.bvh(), *atlas, *accessibility, plan.light_kinds,
                 technique_name, remedies::lower_texels, true),
      means(*c.device, c.scheduler, program, *atlas, *accessibility, side_light.light_samples(), plan.channels, p),
      preview(plan.preview ? std::make_unique<SidePreview>(*c.device, c.scheduler, program, *atlas, means) : nullptr),
      plan_(plan),
      // Of bundles that carry emitted light too nobody knows what share of direct light they bring.
      measures_(p.eye_share < 0 && !plan.channels.exchanged()) {
  make_camera(c);
  make_transfer(c, p);
  if (!accessibility->complete())
    accessibility->begin(*c.device, c.scheduler, c.scene, c.scene_buffers, *atlas, *interior, transfer->raster());
  if (plan.reflects)
    specular =
        std::make_unique<SideSpecular>(*c.device, c.scheduler, program, c.scene_buffers, c.bvh(), *atlas, means, p,
                                       !c.scene.lights.empty(), c.settings.max_bounces, p.transfer == Transfer::ray);
  if (!plan.camera.debug) return;
  if (plan.exchanges)
    side_state = std::make_unique<SideState>(*c.device, c.scheduler, means, accessibility->shares(), specular.get());
  make_debug(c);
}

void BundleParts::make_camera(const TechniqueContext& c) {
  camera = std::make_unique<CameraLight>(*c.device, c.scheduler, program, c.scene_buffers, c.bvh(), *atlas, means,
                                         preview.get(), make_frame(c.settings), plan_.camera);
}

void BundleParts::make_transfer(const TechniqueContext& c, const Parameters& p) {
  transfer = std::make_unique<BundleTransfer>(
      *c.device, c.scheduler, c.scene, c.scene_buffers, *atlas, means.records(), *interior, *accessibility,
      plan_.channels, BundleTransfer::Options{p.pixel_size, p.transfer, camera->pixel_gather()});
}

void BundleParts::make_debug(const TechniqueContext& c) {
  debug =
      std::make_unique<DebugLayers>(*c.device, c.scheduler, *atlas, means, preview.get(), side_state.get(), *camera);
}

bool BundleParts::set_frame(const TechniqueContext& c, const Parameters& p, uint32_t seed) {
  const Frame frame = make_frame(c.settings);
  const bool remake = !camera->fits(frame), with_transfer = remake && gathers();
  if (with_transfer && !accessibility->complete()) return false;  // it draws with the raster of the transfer
  if (remake) {
    debug.reset();  // their memory first
    if (with_transfer) transfer.reset();
    camera.reset();
    make_camera(c);
    if (with_transfer) make_transfer(c, p);
    if (plan_.camera.debug) make_debug(c);
    camera->reset(seed);
  } else {
    camera->set_frame(frame);
  }
  if (debug) debug->clear();
  return true;
}

void BundleParts::commit_sample(bool atlas_known) {
  camera->commit(atlas_known, measures_ && std::isfinite(means.direction_variance()));
  seen_directions_ = means.directions();
  if (debug) debug->commit();
}

WorkUnits BundleParts::work_units(const Scene& scene) const {
  return bundle::work_units(atlas->info().texel_count, side_light.run_length(), scene.triangle_count(),
                            camera->pixels(), camera->rays_per_sample());
}

EyeShare BundleParts::eye_share(const Parameters& parameters, const WorkUnits& units) const {
  constexpr double least = 0.05, largest = 0.9;  // neither part starves, whatever was measured
  if (parameters.eye_share >= 0) return {static_cast<double>(parameters.eye_share)};
  if (camera->spread().samples() == 0) return {};
  const LayerSpread& pixels = camera->spread();
  const double direction = means.direction_variance() * pixels.indirect_share();
  const double share = share_of_work(pixels.variance(), units.eye_sample, direction, units.direction);
  // A picture is a mean over what texels knew when pixels were sampled.
  constexpr double due = 1.25;  // times as many directions as then
  return {std::clamp(share, least, largest), true,
          static_cast<double>(means.directions()) > due * static_cast<double>(seen_directions_)};
}

void BundleParts::reset(uint32_t seed) {
  seen_directions_ = 0;
  if (specular) specular->reset();
  side_light.reset(seed);
  means.reset();
  if (side_state) side_state->reset();
  camera->reset(seed);
  if (debug) debug->clear();
}

bool BundleParts::gather_along(const DirectionSequence& sequence, uint64_t index, uint32_t seed, bool first) {
  const BundleDirection direction = sequence.at(index);
  if (specular) {
    specular->begin_batch(sequence, index, 1);
    if (!specular->send(direction, 0, seed, means.sends_direct())) return false;
  }
  transfer->gather(direction, seed, first);
  return true;
}

BundleParts::Kept BundleParts::release_surfaces() {
  return {std::move(atlas), std::move(interior), std::move(accessibility)};
}

InspectedValues BundleParts::inspect(const SeenPoint& point) const {
  const uint32_t side = side_at(*atlas, point.triangle, point.b1, point.b2, point.front);
  InspectedValues rows = describe_side(*atlas, side, means.shown(), "exchanged irradiance");
  rows.emplace_back("directions so far", std::to_string(means.directions()));
  return rows;
}

std::map<std::string, double> BundleParts::counters(uint64_t directions) const {
  std::map<std::string, double> result{{"directions", static_cast<double>(directions)}};
  result["indirect_directions"] = static_cast<double>(means.reflecting(directions));
  result["sides"] = atlas->info().texel_count;
  result["bundle_pixels"] = transfer->mean_image();
  result["chain_rays"] = static_cast<double>((specular ? specular->rays() : 0) + camera->rays());
  if (std::isfinite(means.relative_error())) result["relative_error"] = means.relative_error();
  return result;
}

void BundleParts::write(Film& film, bool smoothed) const {
  camera->resolve(film, smoothed);
  if (debug) debug->write(film, smoothed);
}

void BundleParts::measure_accessibility(const std::function<void(double, const std::string&)>& report) {
  const auto check = [](bool done) {
    if (!done)
      throw Error(ErrorClass::interrupted, "bundle_exchange: interrupted while preparing the texels; nothing was kept");
  };
  for (; !interior->complete(); report(interior->progress(), "hidden places")) check(interior->advance());
  for (; !accessibility->complete(); report(accessibility->progress(), accessibility->measured()))
    check(accessibility->advance());
  means.copy_materials();
}

void BundleParts::warm_up() {
  side_light.warm_up();
  means.warm_up();
  if (preview) preview->warm_up();
  if (specular) specular->warm_up();
  transfer->warm_up();
  camera->warm_up();
  if (side_state) side_state->warm_up();
  if (debug) debug->warm_up();
}

}  // namespace lucarium::bundle
