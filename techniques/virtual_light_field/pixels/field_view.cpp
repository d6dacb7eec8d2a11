// SPDX-License-Identifier: Apache-2.0
#include "virtual_light_field/pixels/field_view.h"

#include "lucarium/base/seed.h"
#include "lucarium/compute/device/remedies.h"
#include "lucarium/services/ray_ends.h"
#include "virtual_light_field/base/field_program.h"

namespace lucarium::vlf {
namespace {

constexpr uint32_t kStream = 0x77616c6b;

std::vector<std::string> layers(bool walks) {
  return walks ? std::vector<std::string>{"emission", "direct", "indirect"}
               : std::vector<std::string>{"direct", "indirect"};
}

}  // namespace

FieldView::FieldView(Device& device, KernelScheduler& scheduler, const SceneBuffers& scene,
                     const Intersector& intersector, const SurfaceAtlas* atlas, const Patches* patches,
                     const LightField* field, const Frame& frame, const Options& options)
    : scheduler_(&scheduler),
      field_(field),
      options_(options),
      frame_(frame),
      pixels_(frame.width * frame.height),
      sums_(device, technique_name, pixels_, layers(options.walks())),
      traced_(device, technique_name, "light of rays", options.traced ? 2 * size_t{pixels_} : 2, remedies::lower_size) {
  if (options.walks())
    rays_ = std::make_unique<CameraRays>(device, scheduler, intersector, frame, technique_name);
  else
    eye_ = std::make_unique<EyeLight>(device, scheduler, scene, intersector, frame, technique_name, options.eye_kinds,
                                      1, options.first_surface);
  if (!field) return;
  side_albedo_ = TypedBuffer<float4>(device, technique_name, "specular albedo of texel sides", patches->side_albedo,
                                     remedies::lower_texels);
  scale_ = TypedBuffer<float>(device, technique_name, "scale of stored radiance", 1);
  if (options.traced) make_chains(device, scene, intersector, *atlas);
  if (rays_)
    tables_ = std::make_unique<WalkTables>(device, scheduler, scene, *atlas, *field, side_albedo_, options.fold);
  record_field(scene, *atlas);
  if (options.inspect_line < 0) return;
  const SubfieldView::Options line = {
      static_cast<uint32_t>(options.inspect_line), frame.width, frame.height, options.reach, frame.seed, options.fold};
  subfield_ =
      std::make_unique<SubfieldView>(device, scheduler, scene, intersector, *atlas, side_albedo_, scale_, *field, line);
}

FieldView::Options FieldView::make_options(const Plan& plan, const Parameters& parameters) {
  Options options;
  options.eye_kinds = plan.eye_kinds;
  options.lobes = parameters.eye_glossy == EyeLobes::vlf;
  options.first_surface = plan.field && (plan.first_surface || !plan.lobes);
  options.traced = plan.traced && plan.field;
  options.nearest = parameters.eye_interp == EyeInterpolation::nearest;
  options.fold = plan.fold;
  options.max_bounces = plan.max_bounces;
  options.inspect_line = plan.field ? parameters.inspect_line : -1;
  return options;
}

size_t FieldView::estimate_bytes(uint32_t width, uint32_t height, const Options& options) {
  const size_t pixels = size_t{width} * height;
  size_t bytes = LayerSums::estimate_bytes(pixels, layers(options.walks()).size());
  bytes += options.walks() ? CameraRays::estimate_bytes(width, height) : EyeLight::estimate_bytes(width, height);
  if (options.inspect_line >= 0) bytes += SubfieldView::estimate_bytes(pixels);
  if (options.traced) bytes += 2 * pixels * sizeof(float4) + SpecularChains::estimate_bytes(pixels);
  return bytes;
}

void FieldView::bind_lookups(PassBuilder& pass, const SurfaceAtlas& atlas) const {
  atlas.bind(pass);
  field_->maps().bind(pass);
  field_->halves().bind(pass);
  pass.arg("nearest", options_.nearest ? 1u : 0u)
      .arg("split", field_->split() ? 1u : 0u)
      .arg("fold", options_.fold ? 1u : 0u)
      .arg("side_albedo", side_albedo_)
      .arg("direct", field_->direct())
      .arg("total", field_->total());
}

void FieldView::make_chains(Device& device, const SceneBuffers& scene, const Intersector& intersector,
                            const SurfaceAtlas& atlas) {
  const Program program = make_field_program(device, "pixels/trace_lobes", ray_end_defines(intersector));
  chains_ = std::make_unique<SpecularChains>(
      device, *scheduler_, scene, intersector, SpecularChains::Options{pixels_, false, technique_name, "pixels"},
      SpecularChains::Consumer{
          .program = program,
          .advance = "advance_rays",
          .add_light = "add_ray_light",
          .bind_advance =
              [this, &atlas](PassBuilder& pass) {
                bind_lookups(pass, atlas);
                pass.arg("inverse_scale", scale_).arg("held", field_->held()).arg("light", traced_);
              },
          .bind_add_light = [this](PassBuilder& pass) { pass.arg("light", traced_); }});
  ScheduleRecorder recorder = scheduler_->record("begin rays of lobes", technique_name);
  settings_ = recorder.variable("settings", ChainSettings{});
  PassBuilder begin = recorder.pass("begin rays of lobes", program, "begin_rays");
  scene.bind(begin);
  begin.global(pixels_)
      .arg("points", eye_->points())
      .arg("count", pixels_)
      .arg("settings", settings_)
      .arg("mirrors", options_.first_surface ? 1u : 0u)
      .arg("light", traced_)
      .arg("chains", chains_->chains())
      .arg("rays", chains_->first_rays())
      .arg("queue", chains_->queue())
      .arg("active", chains_->active());
  begin_ = recorder.compile();
}

void FieldView::bind_shown(PassBuilder& pass, const SurfaceAtlas& atlas) const {
  bind_lookups(pass, atlas);
  pass.arg("inverse_scale", scale_)
      .arg("lobes", options_.lobes ? 1u : 0u)
      .arg("mirrors", options_.first_surface ? 1u : 0u)
      .arg("atlas_direct", options_.eye_kinds == 0 ? 1u : 0u)
      .arg("shown_direct", field_->shown_direct())
      .arg("shown", field_->shown());
}

void FieldView::record_field(const SceneBuffers& scene, const SurfaceAtlas& atlas) {
  const std::string kernel = rays_ ? "walk_field" : "show_field";
  const Program program = make_field_program(scene.scene_triangles.device(), "pixels/" + kernel);
  ScheduleRecorder recorder = scheduler_->record("show field", technique_name);
  weight_ = recorder.variable("weight", 1.f);
  shows_ = recorder.variable("shows", 0u);
  begins_ = recorder.variable("begins", 0u);
  PassBuilder pass = recorder.pass("show field", program, kernel);
  scene.bind(pass);
  bind_shown(pass, atlas);
  pass.global(pixels_)
      .arg("count", pixels_)
      .arg("weight", weight_)
      .arg("direct_layer", sums_["direct"])
      .arg("indirect_layer", sums_["indirect"]);
  if (rays_) {
    tables_->bind(pass);
    pass.arg("rays", rays_->rays())
        .arg("hits", rays_->hits())
        .arg("shows", shows_)
        .arg("begins", begins_)
        .arg("emission", sums_["emission"]);
  } else {
    pass.arg("points", eye_->points()).arg("rays", options_.traced ? 1u : 0u).arg("traced", traced_);
  }
  show_ = recorder.compile();
}

bool FieldView::shows_field() const { return field_ && field_->shown_sweeps() > 0; }

void FieldView::keep_scale() {
  if (kept_scale_ == field_->scale()) return;
  kept_scale_ = field_->scale();
  scheduler_->finish();
  scale_.upload({1 / kept_scale_});
}

bool FieldView::sample() {
  if (rays_) return rays_->trace(samples_);
  if (!eye_->see(samples_) || !eye_->sample(samples_)) return false;
  if (!chains_ || !shows_field()) return true;
  keep_scale();
  ChainSettings settings{};
  settings.seed = stream_seed(frame_.seed, kStream, samples_);
  settings.first_light = options_.eye_kinds != 0 ? 2 : 1;  // else light samples have found the first
  settings.lit = 1;
  settings.max_vertices = 1;
  settings.limit = options_.max_bounces < 0 ? LUCARIUM_NONE : static_cast<uint32_t>(options_.max_bounces) + 1;
  begin_.set(settings_, settings);
  return scheduler_->run(begin_) == RunResult::done && chains_->follow(settings);
}

void FieldView::commit() {
  ++samples_;
  if (eye_) eye_->commit();
  const bool shows = shows_field();
  const bool grown = shows && shown_sweeps_ != field_->shown_sweeps();
  if (grown) field_samples_ = 0;
  if (shows) {
    shown_sweeps_ = field_->shown_sweeps();
    ++field_samples_;
    keep_scale();
    show_.set(weight_, 1.f / static_cast<float>(field_samples_));
  }
  if (rays_) {
    show_.set(shows_, shows ? 1u : 0u);
    show_.set(begins_, sums_.take_forgotten() ? 1u : 0u);
  }
  if (tables_ && shows) tables_->update();
  if (shows || rays_) scheduler_->run_to_end(show_);
  if (subfield_ && grown) subfield_->show();
}

void FieldView::reset(uint32_t seed) {
  frame_.seed = seed;
  if (chains_) chains_->reset_count();
  set_frame(frame_);
}

void FieldView::set_frame(const Frame& frame) {
  const uint32_t seed = frame_.seed;
  frame_ = frame;
  frame_.seed = seed;
  if (eye_) eye_->set_frame(frame_);
  if (rays_) {
    rays_->set_frame(frame_);
    scheduler_->finish();
    sums_.forget();
  } else {
    sums_.clear();
  }
  samples_ = field_samples_ = shown_sweeps_ = 0;
}

void FieldView::warm_up() {
  if (eye_) eye_->warm_up();
  if (rays_) rays_->warm_up();
  if (chains_) {
    scheduler_->warm_up(begin_);
    chains_->warm_up();
  }
  if (tables_) tables_->warm_up();
  if (field_) scheduler_->warm_up(show_);
  if (subfield_) subfield_->warm_up();
}

void FieldView::resolve(Film& film) const {
  if (eye_) eye_->write(film);
  sums_.write(film);
  if (subfield_) subfield_->write(film);
}

}  // namespace lucarium::vlf
