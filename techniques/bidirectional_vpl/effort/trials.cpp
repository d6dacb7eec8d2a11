// SPDX-License-Identifier: Apache-2.0
#include "bidirectional_vpl/effort/trials.h"

#include <algorithm>
#include <cmath>

const lucarium::EmbeddedSources& bidirectional_vpl_kernels();

namespace lucarium::bidirectional {

namespace {

constexpr uint32_t kSamples = 8;
// Pixels of a trial: a quarter of the image's, so that small images are not held up; so many suffice.
constexpr uint32_t kMinPixels = 1024, kMaxPixels = 8192;
constexpr uint32_t kSeed = 0x74726961u;  // apart from the image's own
// Products of trials scatter by some percent; without a clear gain, nothing changes.
constexpr double kClearly = 0.9;
constexpr int kEndlessEdges = 64;

}  // namespace

bool can_adapt(const BidirectionalParameters& p, const Plan& plan) {
  return p.adapt && p.strategy == Strategy::all && plan.choice == VplChoice::resample && plan.vpl && !plan.bundles &&
         !plan.shows_strategies && plan.two_bounce == TwoBounce::mis && plan.gloss == Gloss::none && !plan.caches &&
         plan.settings.interleave == 1 && !plan.rsm && !plan.vpl_maps && !plan.direct_maps && !plan.learned &&
         !plan.punctual_paths;
}

Trials::Trials(const PartsContext& context, const BidirectionalParameters& parameters, const RenderSettings& settings,
               const Frame& frame)
    : context_(context),
      parameters_(parameters),
      settings_(trial_settings(settings)),
      frame_(frame),
      program_(
          make_program(context.device, bidirectional_vpl_kernels(), {"bidirectional_vpl/effort/trial_moments"}, {})),
      best_(whole_effort(parameters)) {
  frame_.width = settings_.width;
  frame_.height = settings_.height;
  frame_.seed ^= kSeed;
  const double share = static_cast<double>(settings_.width) * settings_.height / settings.width / settings.height;
  if (parameters_.light_paths > 0)
    parameters_.light_paths = std::max(1, static_cast<int>(std::lround(parameters_.light_paths * share)));
}

RenderSettings Trials::trial_settings(const RenderSettings& settings) {
  RenderSettings small = settings;
  const uint32_t pixels = settings.width * settings.height;
  const uint32_t wanted = std::clamp(pixels / 4, kMinPixels, kMaxPixels);
  const double scale = std::min(1.0, std::sqrt(static_cast<double>(wanted) / pixels));
  const auto scaled = [scale](uint32_t size) { return std::max(1u, static_cast<uint32_t>(std::lround(size * scale))); };
  small.width = scaled(settings.width);
  small.height = scaled(settings.height);
  return small;
}

std::optional<Effort> Trials::best() {
  double work = 0;
  const Plan plan = make_plan(parameters_, settings_, best_);
  std::optional<TrialImage> image = render(plan, &work);
  if (!image) return std::nullopt;
  reference_ = std::move(*image);
  least_ = relative_variance(reference_, reference_) * work;

  // Strategies.
  Effort effort = best_;
  effort.splats = false;
  if (plan.splat && !try_effort(effort)) return std::nullopt;
  // Camera paths alone must not be ended early: nothing else finds their light.
  effort.light_paths = false;
  effort.camera_edges = kEndlessEdges;
  if (!try_effort(effort)) return std::nullopt;

  // Lengths of light paths, and of camera paths before roulette.
  for (int vertices = best_.light_vertices / 2; best_.light_paths && vertices >= 1; vertices /= 2) {
    effort = best_;
    effort.light_vertices = vertices;
    if (!try_effort(effort)) return std::nullopt;
    if (best_.light_vertices != vertices) break;
  }
  if (!best_.light_paths) return best_;
  const int edges = best_.camera_edges;
  for (const int other : {2 * edges, edges / 2, kEndlessEdges}) {
    if (other < 1 || other > kEndlessEdges || other == best_.camera_edges) continue;
    effort = best_;
    effort.camera_edges = other;
    if (!try_effort(effort)) return std::nullopt;
  }
  return best_;
}

bool Trials::try_effort(const Effort& effort) {
  double work = 0;
  const std::optional<TrialImage> image = render(make_plan(parameters_, settings_, effort), &work);
  if (!image) return false;
  const double product = relative_variance(*image, reference_) * work;
  if (product < kClearly * least_) {
    best_ = effort;
    least_ = product;
  }
  return true;
}

std::optional<TrialImage> Trials::render(const Plan& plan, double* work) const {
  const uint32_t pixels = plan.settings.pixels;
  EyeSums sums(context_.device, plan, context_.owner);
  Parts parts(context_, plan, frame_, sums);
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
  for (uint32_t i = 0; i < kSamples; ++i) {
    if (!parts.trace(i)) return std::nullopt;
    if (context_.scheduler.run(schedule) == RunResult::cancelled) return std::nullopt;
    parts.add(i + 1);
  }
  context_.scheduler.finish();
  *work = work_of(parts.counters(), plan.settings.candidates);
  return TrialImage{kSamples, moments.download(0, pixels), moments.download(pixels, pixels)};
}

size_t Trials::estimate_bytes(const BidirectionalParameters& parameters, const Scene& scene,
                              const RenderSettings& settings) {
  const Plan plan = make_plan(parameters, settings);
  if (!can_adapt(parameters, plan)) return 0;
  const RenderSettings small = trial_settings(settings);
  const Plan trial = make_plan(parameters, small);
  return Parts::estimate_bytes(trial, scene) + size_t{trial.settings.pixels} * 2 * sizeof(float4);
}

}  // namespace lucarium::bidirectional
