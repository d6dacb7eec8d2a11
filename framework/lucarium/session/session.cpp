// SPDX-License-Identifier: Apache-2.0
#include "lucarium/session/session.h"

#include <algorithm>
#include <functional>

#include "lucarium/base/error.h"
#include "lucarium/base/interrupt.h"
#include "lucarium/base/log.h"
#include "lucarium/base/processor_time.h"
#include "lucarium/base/stopwatch.h"
#include "lucarium/base/text/byte_size.h"
#include "lucarium/compute/program/program.h"
#include "lucarium/services/bvh/bvh.h"
#include "lucarium/session/film_check.h"
#include "lucarium/session/memory_needs.h"
#include "lucarium/session/saved_state.h"
#include "lucarium/session/scene_on_device.h"
#include "lucarium/session/technique_calls.h"
#include "lucarium/version.h"

namespace lucarium {
namespace {

// Of images that nobody sees [pixels]: smaller ones cost what their launches do.
constexpr uint32_t kUnseenEdge = 64;

RenderSettings at_most(RenderSettings settings, uint32_t edge) {
  settings.width = std::min(settings.width, edge);
  settings.height = std::min(settings.height, edge);
  return settings;
}

}  // namespace

struct RenderSession::State {
  // In order of construction; the technique goes first at the end, then what it refers to.
  TechniqueType type;
  std::shared_ptr<Device> device;
  std::shared_ptr<SceneOnDevice> shared;
  Scene& scene = shared->scene;
  std::unique_ptr<SceneBuffers>& buffers = shared->buffers;
  std::unique_ptr<Bvh>& bvh = shared->bvh;
  RenderSettings settings;
  KernelScheduler scheduler;
  std::unique_ptr<Technique> technique;
  std::vector<std::string> limitations;
  Clocks clocks;
  IterationResult last;
  uint64_t iterations = 0;
  OnPreparing on_preparing;
  BudgetPlan plan;
  bool light_done = false;  ///< IterationResult::light_done, also after the camera has moved

  State(std::shared_ptr<Device> d, std::shared_ptr<SceneOnDevice> s, TechniqueType t, RenderSettings r, OnPreparing p)
      : type(std::move(t)),
        device(std::move(d)),
        shared(std::move(s)),
        settings(std::move(r)),
        scheduler(device),
        on_preparing(std::move(p)) {
    if (!on_preparing) on_preparing = [](double, const std::string&) {};
    ++shared->sessions;
  }
  ~State() { --shared->sessions; }
  State(const State&) = delete;
  State& operator=(const State&) = delete;

  Bvh& built_bvh() {
    if (!type.info().capabilities.uses_bvh)
      throw_error(ErrorClass::technique, "it asks for the BVH but declares uses_bvh = false");
    if (!bvh) {
      const Stopwatch watch;
      const double compiled = device->program_seconds(), spent = working_seconds();
      bvh = std::make_unique<Bvh>(*device, scene, *buffers);
      clocks.bvh += watch.seconds() - (device->program_seconds() - compiled);
      clocks.prepare_processor += working_seconds() - spent;
    }
    return *bvh;
  }

  /// Processor time of this process without kernel compilation.
  static double working_seconds() { return processor_seconds() - program_processor_seconds(); }

  /// Runs `work` and books its wall time, less kernel compilation and BVH building, which have clocks of their own, and
  /// its processor time where it is counted.
  template <class Work>
  void timed(double& clock, Work&& work) {
    const Stopwatch watch;
    const double compiled = device->program_seconds(), built = clocks.bvh;
    const double spent = working_seconds(), spent_building = clocks.prepare_processor;
    work();
    const double processor = working_seconds() - spent - (clocks.prepare_processor - spent_building);
    if (&clock == &clocks.iterate)
      clocks.iterate_processor += processor;
    else if (&clock != &clocks.warm_up && &clock != &clocks.load)
      clocks.prepare_processor += processor;
    const double compile = device->program_seconds() - compiled;
    clocks.compile += compile;
    clock += watch.seconds() - compile - (clocks.bvh - built);
  }

  /// The scene is changed by whoever has it alone: other sessions would not follow.
  void require_own_scene() const {
    if (shared->sessions > 1) throw_error(ErrorClass::internal, "the scene is changed while sessions share it");
  }

  /// Refuses a change that the technique does not declare.
  void require_change(const SceneChange& change) const {
    const std::vector<ChangeKind>& can = type.info().capabilities.changes;
    const auto require = [&](bool happens, ChangeKind kind) {
      if (!happens || std::find(can.begin(), can.end(), kind) != can.end()) return;
      throw_error(ErrorClass::technique, "cannot follow a change of {} (supported: {}); render single times with --at",
                  name_of(kind), fmt::join(names_of(can), ", "));
    };
    require(change.camera, ChangeKind::camera);
    require(!change.moved_instances.empty(), ChangeKind::transforms);
    require(!change.deformed_instances.empty(), ChangeKind::deformation);
    require(!change.materials.empty(), ChangeKind::materials);
    require(change.lights || change.environment, ChangeKind::lights);
    require(change.topology, ChangeKind::topology);
  }

  /// Moves the scene to a time of its animation, in place: a sequence of frames must not copy meshes and images. Where
  /// the technique cannot follow, the scene goes back to its old time.
  SceneChange evaluate_at(double seconds) {
    require_own_scene();
    const double before = scene.time;
    SceneChange change = evaluate(scene, seconds, scene.animation);
    try {
      require_change(change);
    } catch (const Error&) {
      evaluate(scene, before, scene.animation);
      throw;
    }
    return change;
  }

  /// Edits a copy, which replaces the scene when the technique can follow.
  SceneChange edit_scene(const std::function<SceneChange(Scene&)>& edit) {
    require_own_scene();
    Scene edited = scene;
    SceneChange change = edit(edited);
    require_change(change);
    if (change.camera && edited.cameras.empty())
      throw_error(ErrorClass::technique, "the change left the scene without a camera; keep at least one");
    scene = std::move(edited);
    return change;
  }

  /// After a change of the scene that was accepted. Without any, rendering restarts if it had begun.
  void follow_scene(const SceneChange& change) {
    if (change.camera) settings.camera = scene.cameras.front();
    if (change.any() || iterations > 0) apply(change);
  }

  void look(const RenderSettings& seen) {
    SceneChange change;
    change.camera = true;
    change.time = scene.time;
    require_change(change);
    settings = seen;
    apply(change);
  }

  bool view_independent() const { return type.info().capabilities.view_independent; }

  /// Brings everything up to date and restarts; clocks and counts then are those of the new state. A view-independent
  /// technique restarts its camera alone where nothing has changed.
  void apply(SceneChange change) {
    clocks = {};
    last = {};
    iterations = 0;
    if (!change.any() && !view_independent()) {
      technique->reset(settings.seed);
      return;
    }
    if (!change.any()) change.camera = true;
    if (!change.only_camera()) light_done = false;
    timed(clocks.upload, [&] { buffers->update(scene, change); });
    // Materials too: traversal is compiled for whether any is MASK or BLEND.
    if (bvh && (change.geometry() || !change.materials.empty()))
      timed(clocks.bvh, [&] { bvh->update(scene, *buffers, change); });
    timed(clocks.prepare, [&] { technique->update(change); });
  }

  void prepare(const std::vector<std::pair<std::string, std::string>>& parameters, const TimeBudget& time,
               const StateFile* state) {
    technique->parameters().set_all(parameters);
    if (state) require_same(*state, type.info(), *technique, scene, settings);
    plan = plan_budget(*technique, parameters, scene, settings, compute_power(device->info()), time);
    limitations = technique->limitations(scene, settings);
    size_t bytes = needed_bytes(type.info(), *technique, scene, settings);
    if (buffers) bytes -= SceneBuffers::estimate_bytes(scene);
    if (bvh && type.info().capabilities.uses_bvh) bytes -= Bvh::estimate_bytes(scene);
    const MemoryAccount& memory = device->memory();
    if (bytes > memory.total_bytes() - memory.used_bytes())
      memory.require_total("scene, BVH and technique", "all buffers", bytes, memory_hint(*technique, scene, settings));
    log_info("technique {} {} {}: {}×{} pixels, {} bounces, seed {}", type.info().name, type.info().version,
             technique->parameters().to_string(), settings.width, settings.height,
             settings.max_bounces < 0 ? "all" : std::to_string(settings.max_bounces), settings.seed);
    if (time.seconds > 0)
      log_info("plan for {:.3g} s: a whole picture in about {:.2g} s, {}", time.seconds, plan.expected_seconds,
               plan.changes.empty() ? "nothing lowered" : plan.changes_text());
    log_info("memory: {} needed, {} of {} in use", format_bytes(bytes), format_bytes(memory.used_bytes()),
             format_bytes(memory.total_bytes()));
    if (!buffers) {
      on_preparing(-1, "upload");
      timed(clocks.upload, [&] { buffers = std::make_unique<SceneBuffers>(*device, scene); });
    }
    const TechniqueContext context{device,   scheduler,    scene, *buffers, [this]() -> Bvh& { return built_bvh(); },
                                   settings, on_preparing, state};
    const ReportCompilation reporting(*device, on_preparing);
    timed(clocks.prepare, [&] { technique->prepare(context); });
    timed(clocks.warm_up, [&] { technique->warm_up(); });
    if (state) {
      on_preparing(-1, "saved state");
      timed(clocks.load, [&] { technique->load_state(*state); });
      light_done = true;
    }
    scheduler.reset_profile();
    log_info("prepared: upload {:.2f} s, hierarchy {:.2f} s, kernels {:.2f} s, technique {:.2f} s, warm-up {:.2f} s",
             clocks.upload, clocks.bvh, clocks.compile, clocks.prepare, clocks.warm_up);
  }
};

RenderSession::RenderSession(std::shared_ptr<Device> device, Scene scene, const TechniqueType& type,
                             RenderSettings settings,
                             const std::vector<std::pair<std::string, std::string>>& parameters,
                             OnPreparing on_preparing, const TimeBudget& time, const StateFile* state)
    : RenderSession(std::move(device), share_scene(std::move(scene)), type, std::move(settings), parameters,
                    std::move(on_preparing), time, state) {}

RenderSession::RenderSession(std::shared_ptr<Device> device, std::shared_ptr<SceneOnDevice> scene,
                             const TechniqueType& type, RenderSettings settings,
                             const std::vector<std::pair<std::string, std::string>>& parameters,
                             OnPreparing on_preparing, const TimeBudget& time, const StateFile* state) {
  check_settings(type.info(), settings);
  state_ =
      std::make_unique<State>(std::move(device), std::move(scene), type, std::move(settings), std::move(on_preparing));
  state_->technique = type.create();
  call_technique(type.info(), [&] { state_->prepare(parameters, time, state); });
}

RenderSession::~RenderSession() = default;

Technique& RenderSession::technique() { return *state_->technique; }
const Scene& RenderSession::scene() const { return state_->scene; }
const RenderSettings& RenderSession::settings() const { return state_->settings; }
KernelScheduler& RenderSession::scheduler() { return state_->scheduler; }
const RenderSession::Clocks& RenderSession::clocks() const { return state_->clocks; }
const std::vector<std::string>& RenderSession::limitations() const { return state_->limitations; }
const BudgetPlan& RenderSession::plan() const { return state_->plan; }
uint64_t RenderSession::iterations() const { return state_->iterations; }
IterationResult RenderSession::last() const { return state_->last; }

IterationResult RenderSession::iterate() {
  State& s = *state_;
  const uint64_t cancelled = s.scheduler.cancelled_runs();
  call_technique(s.type.info(), [&] { s.timed(s.clocks.iterate, [&] { s.last = s.technique->iterate(); }); });
  if (s.scheduler.cancelled_runs() == cancelled) ++s.iterations;  // a cancelled iteration has changed nothing
  s.light_done = s.last.light_done;
  return s.last;
}

bool RenderSession::run(const RenderBudget& budget, const std::function<bool(const IterationResult&)>& on_progress) {
  const double spent = state_->clocks.iterate;
  const uint64_t done = state_->iterations;
  while (!state_->last.converged) {
    if (interrupt_requested()) return true;
    if (budget.iterations > 0 && state_->iterations - done >= budget.iterations) break;
    if (budget.seconds > 0 && state_->clocks.iterate - spent >= budget.seconds) break;
    if (budget.samples > 0 && state_->last.samples >= budget.samples) break;
    iterate();
    if (on_progress && !on_progress(state_->last)) break;
  }
  return interrupt_requested();
}

bool RenderSession::finish_light(const std::function<void(const IterationResult&)>& on_progress) {
  State& s = *state_;
  if (!s.view_independent() || s.light_done) return false;
  const auto restart = [&](const std::function<void()>& change) {
    const Clocks spent = s.clocks;
    call_technique(s.type.info(), change);
    const Clocks restarting = s.clocks;
    s.clocks = spent;
    s.clocks.iterate += restarting.prepare;
    s.clocks.compile += restarting.compile;
  };
  // No sample of pixels is kept: where the image can be small meanwhile, they cost little.
  const RenderSettings whole = s.settings;
  const bool resizes = s.type.info().capabilities.resizes;
  bool interrupted = false;
  try {
    if (resizes) restart([&] { s.look(at_most(whole, kUnseenEdge)); });
    while (!s.light_done && !s.last.converged && !(interrupted = interrupt_requested())) {
      iterate();
      if (on_progress) on_progress(s.last);
    }
  } catch (...) {
    if (resizes) s.look(whole);
    throw;
  }
  if (resizes) restart([&] { s.look(whole); });
  if (interrupted) return true;
  if (!resizes) restart([&] { s.apply({}); });
  s.clocks.light = s.clocks.iterate;
  s.clocks.iterate = s.clocks.iterate_processor = 0;
  return false;
}

void RenderSession::hold_light() {
  call_technique(state_->type.info(), [&] { state_->technique->hold_light(); });
}

void RenderSession::save_state(const std::filesystem::path& file, bool compress) {
  State& s = *state_;
  require_state(s.type.info(), *s.technique);
  StateHeader header = state_header(s.type.info(), *s.technique, s.scene, s.settings);
  header.seconds = s.clocks.prepare + s.clocks.light + s.clocks.iterate;
  call_technique(s.type.info(), [&] {
    write_state_file(file, header, compress, [&](StateWriter& chunks) { s.technique->save_state(chunks); });
  });
}

void RenderSession::restart(uint64_t seed) {
  State& s = *state_;
  s.settings.seed = seed;
  s.last = {};
  s.iterations = 0;
  s.light_done = false;
  call_technique(s.type.info(), [&] { s.technique->reset(seed); });
}

void RenderSession::set_time(double seconds) {
  State& s = *state_;
  call_technique(s.type.info(), [&] { s.follow_scene(s.evaluate_at(seconds)); });
}

void RenderSession::set_camera(const SceneCamera& camera) {
  RenderSettings seen = state_->settings;
  seen.camera = camera;
  call_technique(state_->type.info(), [&] { state_->look(seen); });
}

void RenderSession::set_view(const SceneCamera& camera, uint32_t width, uint32_t height, bool moving) {
  State& s = *state_;
  if (!s.type.info().capabilities.resizes)
    throw_error(ErrorClass::technique, "{}: its image keeps its size; make another session", s.type.info().name);
  RenderSettings seen = s.settings;
  seen.camera = camera, seen.width = width, seen.height = height;
  check_settings(s.type.info(), seen);
  call_technique(s.type.info(), [&] {
    s.technique->rest_light(moving);
    s.light_done = false;  // iterations say whether it is
    s.look(seen);
  });
}

void RenderSession::change_scene(const std::function<SceneChange(Scene&)>& edit) {
  State& s = *state_;
  call_technique(s.type.info(), [&] { s.follow_scene(s.edit_scene(edit)); });
}

Film RenderSession::resolve() {
  State& s = *state_;
  Film film(s.settings.width, s.settings.height);
  call_technique(s.type.info(), [&] { s.technique->resolve(film); });
  check_film(film, s.type.info());
  const DeviceInfo& device = s.device->info();
  // What the technique itself says stays, but not under these names.
  std::map<std::string, std::string> metadata = {
      {"technique", s.type.info().name},
      {"parameters", s.technique->parameters().to_string()},
      {"path_set", s.technique->path_set(s.scene, s.settings).to_string()},
      {"admitted_bias", fmt::format("{:.3g}", s.type.admitted_bias(*s.technique))},
      {"scene", s.scene.source},
      {"scene_hash", s.scene.hash().hex()},
      {"scene_time_seconds", fmt::format("{}", s.scene.time)},
      {"max_bounces", std::to_string(s.settings.max_bounces)},
      {"pixel_sampling", std::to_string(s.settings.pixel_sampling)},
      {"samples", std::to_string(s.last.samples)},
      {"iterations", std::to_string(s.iterations)},
      {"seconds", fmt::format("{:.3f}", s.clocks.iterate)},
      {"seed", std::to_string(s.settings.seed)},
      {"device", device.name},
      {"driver", device.driver_version},
      {"version", LUCARIUM_VERSION}};
  if (!s.plan.changes.empty()) metadata["planned"] = s.plan.changes_text();
  metadata.merge(film.metadata);
  film.metadata = std::move(metadata);
  return film;
}

}  // namespace lucarium
