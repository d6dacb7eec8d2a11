// SPDX-License-Identifier: Apache-2.0
#include "bidirectional_vpl/effort/trials.h"

#include <algorithm>
#include <cmath>
#include <limits>

const lucarium::EmbeddedSources& bidirectional_vpl_kernels();

namespace lucarium::bidirectional {

namespace {

constexpr uint32_t kSamples = 8;
// Pixels of a trial: a quarter of the image's within these.
constexpr uint32_t kMinPixels = 1024, kMaxPixels = 8192;
constexpr uint64_t kSamplesBefore = 16;  // of the image
constexpr uint32_t kSeed = 0x74726961u;  // apart from the image's own
// Fewer pixels with light decide nothing.
constexpr size_t kMinLitPixels = 64;
// Products of trials scatter by some percent; without a clear gain, nothing changes.
constexpr double kClearly = 0.9;
constexpr int kEndlessEdges = BidirectionalParameters::kMaxCameraEdges;

/// Camera paths alone. They must not be ended early: nothing else finds their light.
Effort camera_effort(const BidirectionalParameters& parameters) {
  Effort effort = whole_effort(parameters);
  effort.light_paths = effort.splats = false;
  effort.camera_edges = kEndlessEdges;
  return effort;
}

/// The whole, no splats, camera paths alone, three lengths of camera paths, and those of light paths.
uint32_t max_trials(const BidirectionalParameters& parameters) {
  uint32_t trials = 6;
  for (int vertices = parameters.light_vertices / 2; vertices >= 1; vertices /= 2) ++trials;
  return trials;
}

}  // namespace

bool can_adapt(const BidirectionalParameters& p, const Plan& plan) {
  return p.adapt && p.strategy == Strategy::all && plan.choice == VplChoice::resample && p.light_paths == 0 &&
         plan.vpl && !plan.bundles && !plan.shows_strategies && plan.two_bounce == TwoBounce::mis &&
         plan.gloss == Gloss::none && !plan.caches && plan.settings.interleave == 1 && !plan.rsm && !plan.vpl_maps &&
         !plan.direct_maps && !plan.learned && !plan.punctual_paths;
}

Trials::Trials(const PartsContext& context, const BidirectionalParameters& parameters, const RenderSettings& settings,
               const Frame& frame, KeptParts& kept)
    : context_(context),
      parameters_(parameters),
      settings_(trial_settings(settings)),
      frame_(frame),
      program_(
          make_program(context.device, bidirectional_vpl_kernels(), {"bidirectional_vpl/effort/trial_moments"}, {})),
      kept_(kept) {
  frame_.width = settings_.width;
  frame_.height = settings_.height;
  frame_.seed ^= kSeed;
  // A trial's pixel shows more of the scene than the image's; what varies within it is no noise.
  if (settings_.width < settings.width) frame_.pixel_sampling = LUCARIUM_PIXEL_CENTRE;
}

RenderSettings Trials::trial_settings(const RenderSettings& settings) {
  RenderSettings small = settings;
  const double pixels = static_cast<double>(settings.width) * settings.height;
  const double scale = std::sqrt(std::clamp(pixels / 4, double{kMinPixels}, double{kMaxPixels}) / pixels);
  const auto scaled = [scale](uint32_t size) {
    return std::clamp(static_cast<uint32_t>(std::lround(size * scale)), 1u, kMaxPixels);
  };
  small.width = scaled(settings.width);
  small.height = scaled(settings.height);
  return small;
}

uint64_t Trials::samples_before(const BidirectionalParameters& parameters, const RenderSettings& settings) {
  const RenderSettings small = trial_settings(settings);
  const uint64_t pixels = uint64_t{settings.width} * settings.height;
  return std::max(kSamplesBefore, uint64_t{max_trials(parameters)} * kSamples * small.width * small.height / pixels);
}

std::shared_ptr<SmallParts> Trials::small_parts(const Effort& effort) const {
  if (std::shared_ptr<SmallParts> kept = kept_.find(effort)) return kept;
  auto parts = std::make_shared<SmallParts>(context_, make_plan(parameters_, settings_, effort), frame_);
  if (effort == whole_effort(parameters_) || effort == camera_effort(parameters_)) kept_.keep(effort, parts);
  return parts;
}

std::vector<std::shared_ptr<SmallParts>> Trials::certain_parts() const {
  return {small_parts(whole_effort(parameters_)), small_parts(camera_effort(parameters_))};
}

bool Trials::advance() {
  Effort effort;
  decided_ = decide(&effort);
  if (decided_) return true;
  if (!render(effort)) return false;
  decided_ = decide(&effort);
  return true;
}

std::optional<double> Trials::product(const Effort& effort) const {
  for (const auto& [tried, product] : products_)
    if (tried == effort) return product;
  return std::nullopt;
}

std::optional<Effort> Trials::decide(Effort* missing) const {
  Effort best = whole_effort(parameters_);
  *missing = best;
  std::optional<double> least = product(best);
  if (!least) return std::nullopt;
  // Without noise, or with hardly any light, there is nothing to decide by.
  if (lit_pixels(reference_) < kMinLitPixels || *least == 0) return best;
  // False where the trial is missing.
  const auto consider = [&](const Effort& effort) {
    *missing = effort;
    const std::optional<double> found = product(effort);
    if (found && *found < kClearly * *least) {
      best = effort;
      least = found;
    }
    return found.has_value();
  };

  // Strategies. What takes too little of the work cannot pay; of light paths halving saves a half at most.
  const Plan whole = make_plan(parameters_, settings_, best);
  const double work = work_of(counters_);
  const double splats = work_of({{"splat_rays", counters_.at("splat_rays")}}) / work;
  const double light_paths = work_of({{"light_path_rays", counters_.at("light_path_rays")}}) / work + splats;
  Effort effort = best;
  effort.splats = false;
  if (whole.splat && splats > 1 - kClearly && !consider(effort)) return std::nullopt;
  const bool needs_light_paths = context_.guide && context_.guide->needs_light_paths();
  if (!needs_light_paths && !consider(camera_effort(parameters_))) return std::nullopt;
  if (!best.light_paths) return best;

  // Lengths of light paths, and of camera paths before roulette.
  for (uint32_t vertices = whole.light_vertices / 2; vertices >= (needs_light_paths ? 2u : 1u); vertices /= 2) {
    if (light_paths / 2 <= 1 - kClearly) break;
    effort = best;
    effort.light_vertices = static_cast<int>(vertices);
    if (!consider(effort)) return std::nullopt;
    if (best != effort) break;
  }
  const int edges = best.camera_edges;
  for (const int other : {2 * edges, edges / 2, kEndlessEdges}) {
    if (other < 1 || other > kEndlessEdges || other == best.camera_edges) continue;
    effort = best;
    effort.camera_edges = other;
    if (!consider(effort)) return std::nullopt;
  }
  return best;
}

bool Trials::render(const Effort& effort) {
  const uint32_t pixels = settings_.width * settings_.height;
  const std::shared_ptr<SmallParts> small = small_parts(effort);
  Parts& parts = small->parts();
  parts.restart(frame_, false);
  TypedBuffer<float4> moments(context_.device, context_.owner, "moments of a trial", size_t{pixels} * 2);
  moments.fill_zero();
  ScheduleRecorder recorder = context_.scheduler.record("trial", context_.owner);
  recorder.pass("moments of samples", program_, "add_trial_moments")
      .global(pixels)
      .arg("sample", parts.eye().sample())
      .arg("pixels", pixels)
      .arg("moments", moments);
  Schedule schedule = recorder.compile();
  TrialImage image;
  image.width = settings_.width;
  image.height = settings_.height;
  for (uint32_t i = 0; i < kSamples; ++i) {
    if (!parts.trace(i)) return false;
    if (context_.scheduler.run(schedule) == RunResult::cancelled) return false;
    parts.add(i + 1);
    context_.scheduler.finish();
    image.sums.push_back(moments.download(0, pixels));
  }
  image.squares = moments.download(pixels, pixels);
  const std::map<std::string, double> counters = parts.counters();
  counted_["trials"] += 1;
  for (const auto& [name, count] : counters) {
    if (name == "paths") counted_["trial_paths"] += count;
    if (name.ends_with("_rays")) counted_["trial_rays"] += count;
  }
  if (products_.empty()) {
    reference_ = image;
    weights_ = pixel_weights(reference_);
    counters_ = counters;
  }
  const double variance = relative_variance(image, weights_) + hidden_variance(image, reference_, weights_);
  // A trial without noise has found nothing.
  const bool found = variance > 0 || products_.empty();
  products_.emplace_back(effort, found ? variance * work_of(counters) : std::numeric_limits<double>::infinity());
  return true;
}

size_t Trials::estimate_bytes(const BidirectionalParameters& parameters, const Scene& scene,
                              const RenderSettings& settings) {
  if (!can_adapt(parameters, make_plan(parameters, settings))) return 0;
  const Plan trial = make_plan(parameters, trial_settings(settings));
  // Those of the whole effort and of camera paths alone are kept beside others.
  return 3 * Parts::estimate_bytes(trial, scene) + size_t{trial.settings.pixels} * 2 * sizeof(float4);
}

}  // namespace lucarium::bidirectional
