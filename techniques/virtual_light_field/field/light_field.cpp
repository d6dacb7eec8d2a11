// SPDX-License-Identifier: Apache-2.0
#include "virtual_light_field/field/light_field.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "lucarium/base/numbers.h"
#include "lucarium/compute/device/remedies.h"
#include "virtual_light_field/base/field_program.h"

namespace lucarium::vlf {
namespace {

constexpr double kCellWork = 4, kSideWork = 2;  // of a cell that is scattered; of a texel side at the end of a sweep
constexpr uint32_t kMaxSweeps = 256;
constexpr double kMaxPeak = 1e5;  // of highlights, over diffuse light

uint32_t divide_up(uint32_t a, uint32_t b) { return (a + b - 1) / b; }

double brightest(const glm::vec3& c) { return static_cast<double>(std::max(c.x, std::max(c.y, c.z))); }

/// What texel sides reflect diffusely in propagation. `facets`: those with cells as if they scattered diffusely.
std::vector<float4> transport_albedo(const std::vector<AtlasMaterial>& materials, const Patches& patches, bool fold,
                                     bool facets) {
  std::vector<float4> result;
  for (size_t side = 0; side < materials.size(); ++side) {
    glm::vec3 albedo = materials[side].diffuse.xyz();
    if (patches.side_facet[side] == LUCARIUM_NONE ? fold : facets) albedo += patches.side_albedo[side].xyz();
    result.emplace_back(albedo, 0.f);
  }
  return result;
}

/// Of all texel sides [m²].
double area_of_sides(const SurfaceAtlas& atlas) {
  double sum = 0;
  for (const AtlasTexel& texel : atlas.texels().download()) sum += static_cast<double>(texel.area);
  return sum;
}

}  // namespace

LightField::LightField(Device& device, KernelScheduler& scheduler, const Scene& host_scene, const SceneBuffers& scene,
                       const Intersector& intersector, const SurfaceAtlas& atlas, const Patches& patches,
                       const LayeredRaster& raster, const TexelInterior& interior,
                       const SideAccessibility& accessibility, const TypedBuffer<float4>& light_samples,
                       const Options& options)
    : scheduler_(&scheduler),
      host_scene_(&host_scene),
      atlas_(&atlas),
      patches_(&patches),
      options_(options),
      grid_(options.dir_n, options.seed),
      maps_(device, scheduler, host_scene, scene, grid_, patches,
            {options.subfield.cells, options.subfield.cell, atlas.info().texel_edge, options.seed, options.rows}),
      tiled_(maps_.cells() > 0),
      halves_(accessibility.side_halves()),
      light_samples_(light_samples),
      albedo_(device, technique_name, "albedo of texel sides",
              transport_albedo(atlas.materials().download(), patches, options.fold, false), remedies::lower_texels),
      records_(device, technique_name, "records of texel sides", 2 * size_t{halves_.count}, remedies::lower_texels),
      direct_(device, technique_name, "direct light of texel sides", halves_.count, remedies::lower_texels),
      indirect_(device, technique_name, "indirect light of texel sides", halves_.count, remedies::lower_texels),
      last_(device, technique_name, "light of the last sweep", halves_.count, remedies::lower_texels),
      shown_direct_(device, technique_name, "displayed direct light", halves_.count, remedies::lower_texels),
      shown_(device, technique_name, "displayed indirect light", halves_.count, remedies::lower_texels),
      held_(device, technique_name, "light that rays look up", halves_.count, remedies::lower_texels),
      shares_(accessibility.shares()),
      side_norms_(device, technique_name, "norms of texel sides",
                  size_t{FIELD_NORMS} * divide_up(halves_.count, FIELD_NORM_CHUNK), remedies::lower_texels),
      norms_(device, technique_name, "norms", FIELD_NORMS),
      cells_(device, maps_.cells(), options.split, !options.loaded),
      side_program_(make_field_program(device, "scatter/fold_sides")) {
  if (options.loaded) {
    end_propagation();
    return;
  }
  record_sides();
  SubfieldRuns::Options subfields;
  subfields.subfield = options.subfield;
  subfields.perturb = options.perturb;
  subfields.cellwise = options.cellwise;
  subfields.seed = options.seed;
  subfields.blend_seed = options.line_seed;
  if (options.max_bounces < 0 || options.max_bounces >= kKeptBounces)
    subfields.cache =
        std::min(options.cache, KeptRows::estimate_bytes(estimate_ends(
                                    options.dir_n, options.perturb, options.subfield.pixel(), area_of_sides(atlas))));
  subfields_ = std::make_unique<SubfieldRuns>(device, scheduler, host_scene, scene, grid_, maps_, atlas, raster,
                                              interior, accessibility, cells_, records_, subfields);
  if (!tiled_) return;
  scatter_ = std::make_unique<CellScatter>(
      device, scheduler, host_scene, scene, intersector, atlas, maps_, cells_, subfields_->host_subfields(),
      side_program_, norms_, CellScatter::Options{options.split, options.scatter, options.perturb, options.line_seed});
}

// ---- schedules

void LightField::record_sides() {
  ScheduleRecorder emit = scheduler_->record("begin propagation", technique_name);
  PassBuilder first = emit.pass("emit", side_program_, "emit_sides");
  atlas_->bind(first);
  maps_.bind(first);
  first.global(halves_.count).arg("sides", halves_.sides).arg("half_count", halves_.count).arg("records", records_);
  emit_ = emit.compile();

  const std::vector<AtlasMaterial> materials = atlas_->materials().download();
  const bool emits = std::any_of(materials.begin(), materials.end(),
                                 [](const AtlasMaterial& m) { return brightest(m.emission.xyz()) > 0; });
  const uint32_t chunks = divide_up(halves_.count, FIELD_NORM_CHUNK);
  ScheduleRecorder fold = scheduler_->record("end of a sweep", technique_name);
  fold_sweep_ = fold.variable("sweep", 0u);
  PassBuilder sides = fold.pass("fold texel sides", side_program_, "fold_sides");
  atlas_->bind(sides);
  sides.global(chunks)
      .arg("sides", halves_.sides)
      .arg("half_count", halves_.count)
      .arg("sweep", fold_sweep_)
      .arg("sampled", options_.sampled ? 1u : 0u)
      .arg("exchanged", host_scene_->environment || emits ? 1u : 0u)
      .arg("albedo", albedo_)
      .arg("shares", shares_)
      .arg("light_samples", light_samples_)
      .arg("records", records_)
      .arg("direct", direct_)
      .arg("indirect", indirect_)
      .arg("last", last_)
      .arg("norms", side_norms_);
  fold.pass("sum norms", side_program_, "sum_norms")
      .global(FIELD_NORMS)
      .arg("chunks", chunks)
      .arg("partial", side_norms_)
      .arg("norms", norms_);
  fold_ = fold.compile();

  ScheduleRecorder show = scheduler_->record("show texel sides", technique_name);
  show_tail_ = show.variable("tail", float4{});
  show_hold_ = show.variable("hold", 0u);
  show.pass("show texel sides", side_program_, "show_sides")
      .global(halves_.count)
      .arg("half_count", halves_.count)
      .arg("tail", show_tail_)
      .arg("hold", show_hold_)
      .arg("shares", shares_)
      .arg("direct", direct_)
      .arg("indirect", indirect_)
      .arg("last", last_)
      .arg("shown_direct", shown_direct_)
      .arg("shown", shown_)
      .arg("held", held_);
  show_ = show.compile();
}

// ---- propagation

void LightField::begin() {
  find_scale();
  scheduler_->run_to_end(emit_);
  scheduler_->finish();
  if (scatter_) scatter_->begin();
  choose_preview_lines();
  if (!preview_subfields_.empty() && tiled_) set_albedo(true);
  stage_ = preview_subfields_.empty() ? stage_after_preview() : Stage::preview;
  next_subfield_ = sweep_ = shown_sweeps_ = preview_sweep_ = 0;
  begun_ = true;
}

void LightField::set_albedo(bool facets) {
  scheduler_->finish();
  albedo_.upload(transport_albedo(atlas_->materials().download(), *patches_, options_.fold, facets));
}

LightField::Stage LightField::stage_after_preview() const {
  return subfields_->keeps() ? Stage::keep : tiled_ ? Stage::survey : Stage::transport;
}

/// A power of two that takes the brightest sender to the middle of what cells can hold.
void LightField::find_scale() {
  scheduler_->finish();
  double largest = 0;
  const std::vector<AtlasMaterial> materials = atlas_->materials().download();
  const std::vector<float4> samples = light_samples_.download();
  for (const AtlasMaterial& material : materials) largest = std::max(largest, brightest(material.emission.xyz()));
  for (size_t i = 0; i < samples.size(); ++i) {
    if (!(samples[i].w > 0)) continue;
    // Of a punctual light, rough metal sends as much as its lobe is narrow, D(n) = 1 / (pi alpha^2).
    const auto alpha = static_cast<double>(materials[i % halves_.sides].diffuse.w);
    const double peak =
        !scatter_ || !scatter_->has_lights() || alpha == 0 ? 1 : std::clamp(1 / (alpha * alpha), 1., kMaxPeak);
    largest = std::max(largest, peak * brightest(samples[i].xyz()) / static_cast<double>(samples[i].w) / pi);
  }
  if (const auto& sky = host_scene_->environment) {
    double value = sky->radiance.empty() ? 1 : 0;
    for (const glm::vec3& texel : sky->radiance) value = std::max(value, brightest(texel));
    largest = std::max(largest, value * brightest(sky->factor));
  }
  scale_ = largest > 0 && std::isfinite(largest)
               ? static_cast<float>(std::exp2(std::floor(std::log2(kMaxStored / largest))))
               : 1;
  scale_ = std::clamp(scale_, 1 / kMaxScale, kMaxScale);
}

bool LightField::advance(double subfield_pixels) {
  if (!begun_) begin();
  while (scatter_ && !scatter_->sees_all())
    if (!scatter_->see_light()) return false;
  if (!(work_left_ > 0)) work_left_ = subfield_pixels;
  while (work_left_ > 0 && !done()) {
    if (stage_ == Stage::scatter) {
      work_left_ -= kCellWork * scatter_tiles();
      continue;
    }
    if (next_subfield_ < subfields_of_stage()) {
      if (!run_subfield()) return false;
      ++next_subfield_;
      work_left_ -= subfields_->pixels();
      continue;
    }
    work_left_ -= kSideWork * halves_.count;
    end_subfields();
  }
  work_left_ = 0;
  return true;
}

uint32_t LightField::subfields_of_stage() const {
  // Sampled direct light needs no first sweep, unless facets reflect emitters and sky.
  if (stage_ == Stage::transport && sweep_ == 0 && options_.sampled && !tiled_) return 0;
  if (stage_ == Stage::preview) return preview_sweep_ == 0 ? 0 : static_cast<uint32_t>(preview_subfields_.size());
  return stage_ == Stage::survey ? subfields_->lines() : subfields_->subfields();
}

bool LightField::run_subfield() {
  switch (stage_) {
    case Stage::preview: return subfields_->exchange(preview_subfields_[next_subfield_], false, scale_);
    case Stage::survey: return subfields_->survey(next_subfield_);
    case Stage::keep: return subfields_->keep(next_subfield_);
    default: return subfields_->exchange(next_subfield_, sweep_ == 0, scale_);
  }
}

/// All subfields have been run through.
void LightField::end_subfields() {
  next_subfield_ = 0;
  if (stage_ == Stage::preview || stage_ == Stage::transport) subfields_->average_coarse();
  switch (stage_) {
    case Stage::preview: return end_preview_sweep();
    case Stage::transport: return end_sweep();
    case Stage::keep:
      subfields_->end_keeping();
      stage_ = tiled_ ? Stage::survey : Stage::transport;
      return;
    default: stage_ = Stage::transport;
  }
}

bool LightField::is_last() const {
  return options_.max_bounces >= 0 && sweep_ >= static_cast<uint32_t>(options_.max_bounces);
}

void LightField::end_sweep() {
  fold_.set(fold_sweep_, sweep_);
  scheduler_->run_to_end(fold_);
  side_sums_ = take_norms();
  if (tiled_ && (!is_last() || options_.scatter_last))
    stage_ = Stage::scatter;
  else
    finish_sweep(side_sums_);
}

double LightField::scatter_tiles() {
  const double cells = scatter_->scatter(sweep_, scale_);
  if (!scatter_->complete()) return cells;
  Norms sums = side_sums_;
  const Norms added = take_norms();
  for (size_t k = 0; k < sums.size(); ++k)
    sums[k] = float4(sums[k].x + added[k].x, sums[k].y + added[k].y, sums[k].z + added[k].z, sums[k].w + added[k].w);
  finish_sweep(sums);
  return cells;
}

Norms LightField::take_norms() const {
  scheduler_->finish();
  const std::vector<float4> values = norms_.download();
  Norms result;
  std::copy(values.begin(), values.end(), result.begin());
  return result;
}

void LightField::finish_sweep(const Norms& norms) {
  const bool unlimited = options_.max_bounces < 0;
  if (sweep_ > 0) tail_ = find_tail(norms);
  // Nothing is sent any more: all is known.
  const bool dark = !(norms[0].x > 0 || norms[0].y > 0 || norms[0].z > 0);
  const double error = options_.tail ? tail_.error : tail_.without;
  const bool accurate = sweep_ > 1 && options_.residual > 0 && error < options_.residual;
  const bool last = is_last() || (unlimited && (dark || accurate || sweep_ + 1 >= kMaxSweeps));
  if (last) {
    why_done_ = !unlimited ? fmt::format("all {} bounces are propagated", options_.max_bounces)
                : dark     ? fmt::format("no light is left after {} sweep{}", sweep_ + 1, sweep_ > 0 ? "s" : "")
                : accurate ? fmt::format("the relative error is below {:.2g}, residual", error)
                           : fmt::format("all {} sweeps are done", kMaxSweeps);
  }
  float4 factor{};
  if (last && unlimited && options_.tail && std::isfinite(tail_.error)) factor = tail_.factor;
  // What is missing is λ / (1 - λ) times the last sweep's irradiance, and as much of what cells send next, which is
  // known.
  const bool shows = last || sweep_ >= preview_bounces();
  if (shows) show(factor, is_last());
  if (stage_ == Stage::scatter) scatter_->add(sweep_, factor);
  ++sweep_;
  if (shows || tiled_) ++shown_sweeps_;
  stage_ = last ? Stage::done : Stage::transport;
  if (last) end_propagation();
}

/// `hold`: rays of pixels do not look up the last sweep.
void LightField::show(const float4& tail, bool hold) {
  show_.set(show_tail_, tail);
  show_.set(show_hold_, hold ? 1u : 0u);
  scheduler_->run_to_end(show_);
}

/// What only propagation needs goes: a walk keeps totals.
void LightField::end_propagation() {
  scheduler_->finish();
  counts_ = counts();
  subfields_.reset();
  scatter_.reset();
  cells_.end_propagation();
  maps_.end_propagation();
  records_ = direct_ = indirect_ = last_ = side_norms_ = {};
  emit_ = Schedule();
  fold_ = Schedule();
  show_ = Schedule();
}

void LightField::warm_up() {
  if (!subfields_) return;
  scheduler_->warm_up(emit_);
  subfields_->warm_up();
  scheduler_->warm_up(fold_);
  scheduler_->warm_up(show_);
  if (scatter_) scatter_->warm_up();
}

LightField::Options field_options(const Plan& plan, const Parameters& parameters) {
  LightField::Options options;
  options.dir_n = static_cast<uint32_t>(parameters.dir_n);
  options.perturb = static_cast<uint32_t>(parameters.perturb);
  options.cellwise = parameters.send_interp == SendInterpolation::cell;
  options.cache = static_cast<size_t>(parameters.cache_visibility) << 20;
  options.rows = parameters.store == Store::csr;
  options.scatter = parameters.scatter;
  options.max_bounces = plan.max_bounces;
  options.sampled = plan.sampled;
  options.scatter_last = parameters.eye_glossy == EyeLobes::vlf || (plan.first_surface && plan.max_bounces < 0);
  options.split = parameters.split_layers;
  options.fold = plan.fold;
  options.tail = parameters.tail;
  options.preview = parameters.preview;
  options.residual = static_cast<double>(parameters.residual);
  return options;
}

size_t LightField::estimate_bytes(size_t sides, uint32_t halves) {
  return sides * ((8 * halves + 2) * sizeof(float4) + 2 * sizeof(uint32_t));
}

double LightField::estimate_ends(uint32_t dir_n, uint32_t perturb, double pixel, double area) {
  const double subfields = (2. * dir_n * dir_n + 1) * perturb;
  return subfields * area / (2 * pixel * pixel);  // the mean projection of a surface is half of it
}

}  // namespace lucarium::vlf
