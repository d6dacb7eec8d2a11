// SPDX-License-Identifier: Apache-2.0
#include "lucarium/services/path_integrator/path_integrator.h"

#include <algorithm>

#include "lucarium/base/error.h"
#include "lucarium/base/seed.h"
#include "lucarium/compute/program/source_library.h"
#include "lucarium/services/direct_light/light_mixture.h"
#include "lucarium/services/path_integrator/path_integrator_state.h"
#include "lucarium/services/ray_ends.h"

namespace lucarium {
namespace {

const char* const kLowerBatchOrSize = "lower the technique's batch_paths or --size";

/// Whether a light of one of these kinds is there and wanted.
bool holds_kind(const std::vector<Light>& lights, const PathSet& set, std::initializer_list<uint32_t> kinds) {
  return std::any_of(lights.begin(), lights.end(), [&](const Light& light) {
    return includes_light(set, light.kind) && std::find(kinds.begin(), kinds.end(), light.kind) != kinds.end();
  });
}

}  // namespace

BatchPlan plan_batches(uint32_t width, uint32_t height, const PathIntegratorOptions& options) {
  BatchPlan plan;
  plan.pixels = width * height;
  plan.samples = std::max(1u, options.samples_per_iteration);
  plan.pixels_per_batch = std::min(plan.pixels, std::max(1u, options.batch_paths));
  // Whole bands of four rows: rays of pixels are traced in squares (RayBuffers::row).
  const uint32_t band = 4 * width;
  if (plan.pixels_per_batch < plan.pixels && plan.pixels_per_batch > band)
    plan.pixels_per_batch -= plan.pixels_per_batch % band;
  plan.samples_per_batch = std::clamp(options.batch_paths / plan.pixels, 1u, plan.samples);
  return plan;
}

std::vector<Buffer> PathSums::all() const {
  std::vector<Buffer> buffers = {layers, shadow_rays, counts};
  buffers.insert(buffers.end(), replicates.begin(), replicates.end());
  return buffers;
}

PathIntegrator::State::State(Device& device_, KernelScheduler& scheduler_, const SceneBuffers& scene_,
                             const Intersector& intersector_, const Frame& frame_,
                             const PathIntegratorOptions& options_, const std::string& owner_)
    : device(device_),
      scheduler(scheduler_),
      scene(scene_),
      intersector(intersector_),
      frame(frame_),
      options(options_),
      owner(owner_),
      plan(plan_batches(frame.width, frame.height, options)),
      primitives(device) {
  if (options.replicates < 1) throw Error(ErrorClass::usage, "replicates must be at least 1");
  make_light_table();
  settings = make_settings();
  std::map<std::string, std::string> defines = ray_end_defines(intersector);
  defines["LUCARIUM_JOINED"] = "";
  if (options.estimator == PathEstimator::mis_balance) defines["LUCARIUM_BALANCE_HEURISTIC"] = "";
  program = Program(
      device, SourceLibrary(),
      {"services/path_integrator",
       {"lucarium/services/path_integrator/generate_camera_paths.cl",
        "lucarium/services/path_integrator/draw_numbers.cl", "lucarium/services/path_integrator/shade_surface.cl",
        "lucarium/services/path_integrator/add_unoccluded_light.cl",
        "lucarium/services/path_integrator/advance_paths.cl",
        "lucarium/services/path_integrator/accumulate_samples.cl"},
       defines});
  allocate();
  record_generate();
  record_bounce();
  record_finish();
}

void PathIntegrator::State::make_light_table() {
  // The mixture holds what light samples are for.
  PathSet sampled = options.path_set;
  if (options.estimator == PathEstimator::bsdf_only) sampled.emissive_triangles = sampled.environment = false;
  const bool all_kinds = sampled.point_lights && sampled.spot_lights && sampled.directional_lights &&
                         sampled.emissive_triangles && sampled.environment;
  if (all_kinds && options.light_choice == LightChoice::tree) return;
  const std::vector<Light> lights = scene.scene_lights.download(0, scene.info().light_count);
  // As long as the scene's own, which stay while the number of its lights changes.
  if (!light_table) {
    light_table = TypedBuffer<AliasEntry>(device, owner, "light table", scene.scene_light_table.count());
    light_trees = TypedBuffer<uint>(device, owner, "light trees", scene.scene_light_trees.count());
  }
  light_table.upload(make_light_mixture(lights, options.light_choice, sampled));
  light_trees.upload(make_light_trees(scene.scene_light_trees.download(), options.light_choice, sampled));
}

bool PathIntegrator::State::samples_lights() const {
  return settings.flags & (LUCARIUM_PATH_SAMPLE_LIGHTS | LUCARIUM_PATH_PUNCTUAL);
}

PathSettings PathIntegrator::State::make_settings() const {
  const PathSet& set = options.path_set;
  const std::vector<Light> lights = scene.scene_lights.download(0, scene.info().light_count);
  PathSettings result{};
  const auto flag = [&result](bool on, uint32_t bit) { result.flags |= on ? bit : 0u; };
  flag(set.emission, LUCARIUM_PATH_EMISSION);
  flag(set.direct, LUCARIUM_PATH_DIRECT);
  flag(set.indirect && set.max_bounces != 0, LUCARIUM_PATH_INDIRECT);
  flag(options.estimator != PathEstimator::nee_only, LUCARIUM_PATH_HIT_LIGHTS);
  flag(holds_kind(lights, set, {LUCARIUM_LIGHT_TRIANGLE}), LUCARIUM_PATH_SEES_TRIANGLES);
  flag(holds_kind(lights, set, {LUCARIUM_LIGHT_ENVIRONMENT}), LUCARIUM_PATH_SEES_ENVIRONMENT);
  flag(holds_kind(lights, set, {LUCARIUM_LIGHT_POINT, LUCARIUM_LIGHT_SPOT, LUCARIUM_LIGHT_DIRECTIONAL}),
       LUCARIUM_PATH_PUNCTUAL);
  const bool sees_light = result.flags & (LUCARIUM_PATH_SEES_TRIANGLES | LUCARIUM_PATH_SEES_ENVIRONMENT);
  flag(sees_light && options.estimator != PathEstimator::bsdf_only, LUCARIUM_PATH_SAMPLE_LIGHTS);
  flag(set.light_delta, LUCARIUM_PATH_LIGHT_DELTA);
  flag(set.secondary_lambert_only, LUCARIUM_PATH_SECONDARY_LAMBERT);
  flag(set.geometric_normals, LUCARIUM_PATH_GEOMETRIC_NORMALS);
  flag(options.sampler == PathSampler::random, LUCARIUM_PATH_RANDOM_SAMPLER);
  flag(!set.blend, LUCARIUM_PATH_OPAQUE_BLEND);

  const uint32_t limit = set.max_bounces < 0 ? LUCARIUM_PATH_SCATTERING_CAP
                                             : std::min<uint32_t>(set.max_bounces + 1u, LUCARIUM_PATH_SCATTERING_CAP);
  result.max_scatterings = result.flags & LUCARIUM_PATH_INDIRECT ? limit : set.direct ? 1u : 0u;
  result.roulette_start = options.roulette ? static_cast<uint32_t>(options.roulette_start) : LUCARIUM_NONE;
  result.eye_roulette_start = options.roulette ? LUCARIUM_PATH_EYE_ROULETTE_START : LUCARIUM_NONE;
  result.eye_deltas = set.eye_deltas < 0
                          ? LUCARIUM_PATH_EYE_DELTA_LIMIT
                          : std::min<uint32_t>(static_cast<uint32_t>(set.eye_deltas), LUCARIUM_PATH_EYE_DELTA_LIMIT);
  result.replicates = options.replicates;
  result.indirect_clamp = static_cast<float>(set.indirect_clamp);
  return result;
}

void PathIntegrator::State::allocate() {
  device.memory().require_total(owner, "path tracing",
                                estimate_bytes(frame.width, frame.height, options, intersector.wants_ends()),
                                kLowerBatchOrSize);
  const size_t count = plan.paths();
  const auto make = [&]<class T>(TypedBuffer<T>& buffer, const char* name, size_t elements) {
    buffer = TypedBuffer<T>(device, owner, name, elements, kLowerBatchOrSize);
  };
  make(paths.rays, "rays", count);
  paths.ends = make_ray_ends(device, intersector, owner, "ends of rays", count, kLowerBatchOrSize);
  make(paths.queue, "path queue", count);
  make(paths.active, "active paths", 1);
  make(paths.throughput, "throughput", count);
  make(paths.state, "path state", count);
  make(paths.side, "path side", count);
  make(paths.radiance, "radiance", count * LUCARIUM_PATH_LAYERS);
  const auto make_sums = [&](PathSums& target) {
    make(target.layers, "layer sums", size_t{plan.pixels} * LUCARIUM_PATH_LAYERS * 2);
    make(target.shadow_rays, "shadow-ray counts", plan.pixels);
    make(target.counts, "event counts", LUCARIUM_PATH_COUNTS);
    target.replicates.resize(options.replicates > 1 ? options.replicates : 0);
    for (auto& replicate : target.replicates) make(replicate, "replicate sums", size_t{plan.pixels} * 2);
  };
  make_sums(sums);
  if (!plan.single_batch()) make_sums(backup);  // a single batch changes the sums all at once, or not at all
}

size_t PathIntegrator::estimate_bytes(uint32_t width, uint32_t height, const PathIntegratorOptions& options,
                                      bool ray_ends) {
  const BatchPlan plan = plan_batches(width, height, options);
  const size_t per_path = 2 * sizeof(Ray) + sizeof(Hit) + sizeof(PathState) +
                          (2 + LUCARIUM_PATH_LAYERS) * sizeof(float4) + sizeof(Ray) + 7 * sizeof(uint32_t) +
                          LUCARIUM_PATH_NUMBER_ROWS * sizeof(float) + (ray_ends ? 3 * sizeof(RayEnds) : 0);
  const size_t per_pixel =
      (LUCARIUM_PATH_LAYERS + (options.replicates > 1 ? options.replicates : 0)) * 2 * sizeof(float4) +
      sizeof(uint32_t);
  return plan.paths() * per_path + plan.pixels * per_pixel * (plan.single_batch() ? 1 : 2);
}

bool PathIntegrator::State::run_batch(const PathBatch& batch) {
  generate.set(generate_batch, batch);
  generate.set(generate_frame, frame);
  bounce.set(bounce_batch, batch);
  finish.set(finish_batch, batch);
  generate.set(generate_settings, settings);
  bounce.set(bounce_settings, settings);
  finish.set(finish_settings, settings);
  if (scheduler.run(generate) == RunResult::cancelled) return false;
  active = batch.pixel_count * batch.sample_count;
  while (active > 0) {
    closest_rays += active;
    if (scheduler.run(bounce) == RunResult::cancelled) return false;
  }
  scheduler.run_to_end(finish);  // cancelled between its passes it would leave sums that do not belong together
  return true;
}

bool PathIntegrator::State::run_batches() {
  for (uint32_t sample = 0; sample < plan.samples; sample += plan.samples_per_batch)
    for (uint32_t pixel = 0; pixel < plan.pixels; pixel += plan.pixels_per_batch) {
      PathBatch batch{};
      batch.first_pixel = pixel;
      batch.pixel_count = std::min(plan.pixels_per_batch, plan.pixels - pixel);
      batch.first_sample = static_cast<uint32_t>(samples) + sample;
      batch.sample_count = std::min(plan.samples_per_batch, plan.samples - sample);
      batch.seed = frame.seed;
      if (!run_batch(batch)) return false;
    }
  return true;
}

void PathIntegrator::State::copy_sums(const PathSums& from, const PathSums& to) {
  // Not a schedule: it must also run when schedules are being cancelled.
  scheduler.finish();
  const std::vector<Buffer> sources = from.all(), targets = to.all();
  for (size_t i = 0; i < sources.size(); ++i)
    check_opencl(clEnqueueCopyBuffer(device.queue(), sources[i].handle(), targets[i].handle(), 0, 0, sources[i].bytes(),
                                     0, nullptr, nullptr),
                 "clEnqueueCopyBuffer", sources[i].name(), device);
  device.finish();
}

void PathIntegrator::State::clear() {
  scheduler.finish();
  for (Buffer buffer : sums.all()) buffer.fill_zero();
  nonfinite = 0;
  samples = closest_rays = 0;
}

PathIntegrator::PathIntegrator(Device& device, KernelScheduler& scheduler, const SceneBuffers& scene,
                               const Intersector& intersector, const Frame& frame, const PathIntegratorOptions& options,
                               const std::string& owner)
    : state_(std::make_unique<State>(device, scheduler, scene, intersector, frame, options, owner)) {}

PathIntegrator::~PathIntegrator() = default;

bool PathIntegrator::iterate() {
  State& s = *state_;
  const uint64_t rays_before = s.closest_rays;
  if (s.backup.layers) s.copy_sums(s.sums, s.backup);
  if (!s.run_batches()) {
    s.closest_rays = rays_before;
    if (s.backup.layers) s.copy_sums(s.backup, s.sums);
    return false;
  }
  s.samples += s.plan.samples;
  if (s.nonfinite > 0)
    throw_error(
        ErrorClass::technique,
        "{}: {} samples are NaN, infinite or negative after {} per pixel; look for emission or light values near "
        "the limits of float in the scene",
        s.owner, s.nonfinite, s.samples);
  return true;
}

void PathIntegrator::reset(uint64_t seed) {
  state_->frame.seed = kernel_seed(seed);
  state_->clear();
}

void PathIntegrator::set_frame(const Frame& frame) {
  State& s = *state_;
  if (frame.width != s.frame.width || frame.height != s.frame.height)
    throw Error(ErrorClass::internal, "PathIntegrator::set_frame: the image size cannot change");
  const uint32_t seed = s.frame.seed;
  s.frame = frame;
  s.frame.seed = seed;
  s.clear();
}

void PathIntegrator::follow_scene() {
  State& s = *state_;
  s.scheduler.finish();
  s.make_light_table();
  const bool sampled = s.samples_lights();
  s.settings = s.make_settings();
  if (s.samples_lights() != sampled) s.record_bounce();
  s.clear();
}

void PathIntegrator::warm_up() {
  for (Schedule* schedule : {&state_->generate, &state_->bounce, &state_->finish}) state_->scheduler.warm_up(*schedule);
}

uint64_t PathIntegrator::samples() const { return state_->samples; }

std::map<std::string, double> PathIntegrator::counters() const {
  const State& s = *state_;
  s.scheduler.finish();
  double shadow_rays = 0;
  for (const uint32_t count : s.sums.shadow_rays.download()) shadow_rays += count;
  const std::vector<uint32_t> counts = s.sums.counts.download();
  return {{"paths", static_cast<double>(s.samples) * s.plan.pixels},
          {"closest_rays", static_cast<double>(s.closest_rays)},
          {"shadow_rays", shadow_rays},
          {"nonfinite", static_cast<double>(counts[LUCARIUM_PATH_COUNT_NONFINITE])},
          {"terminated_by_cap", static_cast<double>(counts[LUCARIUM_PATH_COUNT_CAPPED])},
          {"terminated_in_mirrors", static_cast<double>(counts[LUCARIUM_PATH_COUNT_EYE_DELTA])}};
}

}  // namespace lucarium
