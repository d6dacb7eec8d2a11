// SPDX-License-Identifier: Apache-2.0
#include "bidirectional_vpl/effort/trials.h"

#include <algorithm>
#include <cmath>
#include <limits>

const lucarium::EmbeddedSources& bidirectional_vpl_kernels();

namespace lucarium::bidirectional {

namespace {

constexpr uint32_t kSamples = 8, kTrials = 7;
// Pixels of a trial: a quarter of the image's within these.
constexpr uint32_t kMinPixels = 1024, kMaxPixels = 8192;
constexpr uint64_t kSamplesBefore = 16;  // of the image
constexpr uint32_t kSeed = 0x74726961u;  // apart from the image's own
// Fewer pixels with light decide nothing.
constexpr size_t kMinLitPixels = 64;
// Products of trials scatter by some percent; without a clear gain, nothing changes.
constexpr double kClearly = 0.9;
constexpr int kEndlessEdges = BidirectionalParameters::kMaxCameraEdges;

}  // namespace

bool can_adapt(const BidirectionalParameters& p, const Plan& plan) {
  return p.adapt && p.strategy == Strategy::all && plan.choice == VplChoice::resample && p.light_paths == 0 &&
         plan.vpl && !plan.bundles && !plan.shows_strategies && plan.two_bounce == TwoBounce::mis &&
         plan.gloss == Gloss::none && !plan.caches && plan.settings.interleave == 1 && !plan.rsm && !plan.vpl_maps &&
         !plan.direct_maps && !plan.learned && !plan.punctual_paths;
}

Trials::Trials(const PartsContext& context, const BidirectionalParameters& parameters, const RenderSettings& settings,
               const Frame& frame)
    : context_(context),
      parameters_(parameters),
      settings_(trial_settings(settings)),
      frame_(frame),
      program_(
          make_program(context.device, bidirectional_vpl_kernels(), {"bidirectional_vpl/effort/trial_moments"}, {})) {
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

uint64_t Trials::samples_before(const RenderSettings& settings) {
  const RenderSettings small = trial_settings(settings);
  const uint64_t pixels = uint64_t{settings.width} * settings.height;
  return std::max(kSamplesBefore, uint64_t{kTrials} * kSamples * small.width * small.height / pixels);
}

bool Trials::advance() {
  Effort effort;
  decided_ = decide(&effort);
  if (decided_) return true;
  const Plan plan = make_plan(parameters_, settings_, effort);
  TrialImage image;
  double work = 0;
  if (!render(plan, &image, &work)) return false;
  if (products_.empty()) {
    reference_ = image;
    weights_ = pixel_weights(reference_);
  }
  const double variance = relative_variance(image, weights_) + hidden_variance(image, reference_, weights_);
  // Without any noise there is nothing to decide by.
  products_.emplace_back(effort, variance > 0 ? variance * work : std::numeric_limits<double>::infinity());
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
  if (lit_pixels(reference_) < kMinLitPixels) return best;
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

  // Strategies.
  const Plan whole = make_plan(parameters_, settings_, best);
  Effort effort = best;
  effort.splats = false;
  if (whole.splat && !consider(effort)) return std::nullopt;
  // Camera paths alone must not be ended early: nothing else finds their light.
  effort.light_paths = false;
  effort.camera_edges = kEndlessEdges;
  if (!consider(effort)) return std::nullopt;
  if (!best.light_paths) return best;

  // Lengths of light paths, and of camera paths before roulette.
  for (uint32_t vertices = whole.light_vertices / 2; vertices >= 1; vertices /= 2) {
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

bool Trials::render(const Plan& plan, TrialImage* image, double* work) {
  const uint32_t pixels = plan.settings.pixels;
  struct SmallParts {
    EyeSums sums;
    Parts parts;
    SmallParts(const PartsContext& c, const Plan& plan, const Frame& frame)
        : sums(c.device, plan, c.owner), parts(c, plan, frame, sums) {}
  };
  const auto small = std::make_shared<SmallParts>(context_, plan, frame_);
  Parts& parts = small->parts;
  if (products_.empty()) whole_parts_ = small;
  TypedBuffer<float4> moments(context_.device, context_.owner, "moments of a trial", size_t{pixels} * 2);
  moments.fill_zero();
  ScheduleRecorder recorder = context_.scheduler.record("trial", context_.owner);
  recorder.pass("moments of samples", program_, "add_trial_moments")
      .global(pixels)
      .arg("sample", parts.eye().sample())
      .arg("pixels", pixels)
      .arg("moments", moments);
  Schedule schedule = recorder.compile();
  image->width = settings_.width;
  image->height = settings_.height;
  for (uint32_t i = 0; i < kSamples; ++i) {
    if (!parts.trace(i)) return false;
    if (context_.scheduler.run(schedule) == RunResult::cancelled) return false;
    parts.add(i + 1);
    context_.scheduler.finish();
    image->sums.push_back(moments.download(0, pixels));
  }
  image->squares = moments.download(pixels, pixels);
  *work = work_of(parts.counters());
  return true;
}

size_t Trials::estimate_bytes(const BidirectionalParameters& parameters, const Scene& scene,
                              const RenderSettings& settings) {
  if (!can_adapt(parameters, make_plan(parameters, settings))) return 0;
  const Plan trial = make_plan(parameters, trial_settings(settings));
  // Those of the whole effort are kept beside others.
  return 2 * Parts::estimate_bytes(trial, scene) + size_t{trial.settings.pixels} * 2 * sizeof(float4);
}

}  // namespace lucarium::bidirectional
