// SPDX-License-Identifier: Apache-2.0
#include "lucarium/technique/session.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "lucarium/base/error.h"
#include "lucarium/base/interrupt.h"
#include "lucarium/services/bvh.h"
#include "lucarium/version.h"

namespace lucarium {
namespace {

class Stopwatch {
 public:
  double seconds() const { return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count(); }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

void check_settings(const TechniqueInfo& info, const RenderSettings& settings) {
  const Capabilities& can = info.capabilities;
  if (settings.width == 0 || settings.height == 0 || uint64_t{settings.width} * settings.height > (uint64_t{1} << 28)) {
    throw_error(ErrorClass::usage, "--size {}x{} is not an image size this program renders", settings.width, settings.height);
  }
  if (can.max_bounces >= 0 && (settings.max_bounces < 0 || settings.max_bounces > can.max_bounces)) {
    throw_error(ErrorClass::technique, "{} computes at most {} bounces; give --max-bounces {} or fewer", info.name,
                can.max_bounces, can.max_bounces);
  }
  if (std::find(can.pixel_sampling.begin(), can.pixel_sampling.end(), settings.pixel_sampling) == can.pixel_sampling.end()) {
    throw_error(ErrorClass::technique, "{} cannot sample pixels in mode {} (0 jitter, 1 centre, n grid); it knows {}",
                info.name, settings.pixel_sampling, fmt::join(can.pixel_sampling, ", "));
  }
}

}  // namespace

struct RenderSession::State {
  // In order of construction; the technique goes first at the end, then what it refers to.
  TechniqueType type;
  std::shared_ptr<Device> device;
  Scene scene;
  RenderSettings settings;
  KernelScheduler scheduler;
  std::unique_ptr<SceneBuffers> buffers;
  std::unique_ptr<Bvh> bvh;
  std::unique_ptr<Technique> technique;
  std::vector<std::string> limitations;
  Clocks clocks;
  Stopwatch since_start;
  IterationResult last;
  uint64_t iterations = 0;

  State(std::shared_ptr<Device> d, Scene s, TechniqueType t, RenderSettings r)
      : type(std::move(t)), device(std::move(d)), scene(std::move(s)), settings(std::move(r)), scheduler(device) {}

  Bvh& built_bvh() {
    if (!bvh) {
      const Stopwatch watch;
      bvh = std::make_unique<Bvh>(*device, scene, *buffers);
      clocks.bvh += watch.seconds();
    }
    return *bvh;
  }

  /// Runs `work` and books its wall time, less kernel compilation and BVH building, which have clocks of their own.
  template <class Work>
  void timed(double& clock, Work&& work) {
    const Stopwatch watch;
    const double compiled = device->program_seconds(), built = clocks.bvh;
    work();
    const double compile = device->program_seconds() - compiled;
    clocks.compile += compile;
    clock += watch.seconds() - compile - (clocks.bvh - built);
  }

  void apply(const SceneChange& change) {
    if (!change.any()) return;
    buffers->update(scene, change);
    if (bvh && change.geometry()) bvh->update(scene, *buffers, change);
    technique->update(change);
    last = {};
    iterations = 0;
  }
};

RenderSession::RenderSession(std::shared_ptr<Device> device, Scene scene, const TechniqueType& type, RenderSettings settings,
                             const std::vector<std::pair<std::string, std::string>>& parameters) {
  check_settings(type.info(), settings);
  state_ = std::make_unique<State>(std::move(device), std::move(scene), type, std::move(settings));
  State& s = *state_;
  s.technique = type.create();
  try {
    for (const auto& [name, value] : parameters) s.technique->parameters().set(name, value);
    s.limitations = s.technique->limitations(s.scene, s.settings);
    s.device->memory().require("scene, bvh and " + type.info().name, "all buffers",
                               SceneBuffers::estimate_bytes(s.scene) + Bvh::estimate_bytes(s.scene) +
                                   s.technique->estimate_bytes(s.scene, s.settings),
                               "lower --size or --texture-size");
    s.timed(s.clocks.upload, [&] { s.buffers = std::make_unique<SceneBuffers>(*s.device, s.scene); });
    const TechniqueContext context{s.device, s.scheduler, s.scene, *s.buffers, [&s]() -> Bvh& { return s.built_bvh(); },
                                   s.settings};
    s.timed(s.clocks.prepare, [&] { s.technique->prepare(context); });
    s.timed(s.clocks.warm_up, [&] { s.technique->warm_up(); });
    s.scheduler.reset_profile();
  } catch (const Error& error) {
    throw error.with_context(type.info().name);
  }
}

RenderSession::~RenderSession() = default;

Technique& RenderSession::technique() { return *state_->technique; }
const Scene& RenderSession::scene() const { return state_->scene; }
const RenderSettings& RenderSession::settings() const { return state_->settings; }
KernelScheduler& RenderSession::scheduler() { return state_->scheduler; }
const RenderSession::Clocks& RenderSession::clocks() const { return state_->clocks; }
const std::vector<std::string>& RenderSession::limitations() const { return state_->limitations; }
uint64_t RenderSession::iterations() const { return state_->iterations; }
IterationResult RenderSession::last() const { return state_->last; }

IterationResult RenderSession::iterate() {
  State& s = *state_;
  try {
    s.timed(s.clocks.iterate, [&] { s.last = s.technique->iterate(); });
  } catch (const Error& error) {
    throw error.with_context(s.type.info().name);
  }
  ++s.iterations;
  return s.last;
}

bool RenderSession::run(const RenderBudget& budget, const std::function<void(const IterationResult&)>& on_progress) {
  const double spent = state_->clocks.iterate;
  const uint64_t done = state_->iterations;
  while (!state_->last.converged) {
    if (interrupt_requested()) return true;
    if (budget.iterations > 0 && state_->iterations - done >= budget.iterations) break;
    if (budget.seconds > 0 && state_->clocks.iterate - spent >= budget.seconds) break;
    if (budget.samples > 0 && state_->last.samples >= budget.samples) break;
    iterate();
    if (on_progress) on_progress(state_->last);
  }
  return interrupt_requested();
}

void RenderSession::set_time(double seconds, int animation) {
  const SceneChange change = evaluate(state_->scene, seconds, animation);
  if (change.camera) state_->settings.camera = state_->scene.cameras.front();
  state_->apply(change);
}

void RenderSession::set_camera(const SceneCamera& camera) {
  state_->settings.camera = camera;
  SceneChange change;
  change.camera = true;
  state_->apply(change);
}

Film RenderSession::resolve() {
  State& s = *state_;
  Film film(s.settings.width, s.settings.height);
  s.technique->resolve(film);
  const DeviceInfo& device = s.device->info();
  film.metadata = {{"technique", s.type.info().name},
                   {"parameters", s.technique->parameters().to_string()},
                   {"path_set", s.technique->path_set(s.scene, s.settings).to_string()},
                   {"scene", s.scene.source},
                   {"scene_hash", s.scene.hash().hex()},
                   {"samples", std::to_string(s.last.samples)},
                   {"iterations", std::to_string(s.iterations)},
                   {"seconds", fmt::format("{:.3f}", s.clocks.iterate)},
                   {"seed", std::to_string(s.settings.seed)},
                   {"device", device.name},
                   {"driver", device.driver_version},
                   {"version", LUCARIUM_VERSION}};
  const BadPixels bad = film.count_bad_pixels();
  if (bad.nan + bad.infinite > 0) {
    throw_error(ErrorClass::technique,
                "{} gave {} non-finite values, the first in layer {} at pixel ({}, {}); nothing was written",
                s.type.info().name, bad.nan + bad.infinite, bad.first_layer, bad.first_x, bad.first_y);
  }
  return film;
}

}  // namespace lucarium
