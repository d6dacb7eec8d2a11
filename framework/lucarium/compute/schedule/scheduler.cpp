// SPDX-License-Identifier: Apache-2.0
#include "lucarium/compute/schedule/scheduler.h"

#include <chrono>
#include <exception>

#include "lucarium/base/error.h"
#include "lucarium/base/interrupt.h"
#include "lucarium/base/log.h"
#include "lucarium/compute/schedule/run_log.h"

namespace lucarium {
namespace {

using Clock = std::chrono::steady_clock;

/// Maximum number of runs in flight.
constexpr size_t runs_in_flight = 2;

double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

/// Puts copies in the place of the callers' buffers that the schedule writes, for as long as it lives. Where a copy
/// cannot be bound, the callers' buffers are bound again before the error leaves.
class ScratchCopies {
 public:
  explicit ScratchCopies(Schedule::State& state) : state_(state) {
    std::vector<bool> written(state.resources.size(), false);
    for (const CompiledStep& step : state.steps) {
      for (const int resource : step.written) written[static_cast<size_t>(resource)] = true;
    }
    std::vector<Buffer> copies(state.resources.size());
    for (size_t i = 0; i < copies.size(); ++i) {
      const Buffer& original = state.resources[i].buffer;
      if (!written[i] || !original) continue;
      copies[i] = Buffer(*state.device, state.owner, "warm-up copy of " + original.name(), original.bytes());
      if (original.bytes() == 0) continue;
      check_opencl(clEnqueueCopyBuffer(state.device->queue(), original.handle(), copies[i].handle(), 0, 0,
                                       original.bytes(), 0, nullptr, nullptr),
                   "clEnqueueCopyBuffer", original.name(), *state.device);
    }
    state.device->finish();
    state.scratch_copies = std::move(copies);
    try {
      bind();
    } catch (...) {
      restore();
      throw;
    }
  }
  ~ScratchCopies() { restore(); }
  ScratchCopies(const ScratchCopies&) = delete;
  ScratchCopies& operator=(const ScratchCopies&) = delete;

 private:
  void bind() {
    for (CompiledStep& step : state_.steps) {
      for (const BoundBuffer& bound : step.buffers) {
        if (bound.memory.life >= 0) continue;
        const cl_mem handle = state_.handle(bound.memory);
        check_opencl(clSetKernelArg(step.kernel.get(), bound.position, sizeof(cl_mem), &handle), "clSetKernelArg",
                     state_.where(step), *state_.device);
      }
    }
  }

  /// Binds the callers' buffers. Where that fails the schedule may not run again: it would write to the copies.
  void restore() noexcept {
    try {
      state_.device->finish();
      state_.scratch_copies.clear();
      bind();
    } catch (const std::exception& error) {
      state_.facts->failure = error.what();
    }
  }

  Schedule::State& state_;
};

}  // namespace

struct KernelScheduler::State {
  std::shared_ptr<Device> device;
  SchedulerOptions options;
  std::function<bool()> cancelled = interrupt_requested;
  RunLog log;
  ApiCalls calls;
  uint64_t cancelled_runs = 0;

  bool overlaps(const Schedule::State& schedule) const {
    if (!device->overlap_queue() || schedule.memory->debug()) return false;
    if (options.queue == QueueMode::automatic) return schedule.overlap_pays;
    return options.queue == QueueMode::overlap;
  }

  Schedule::State& check_runnable(Schedule& schedule) const {
    if (!schedule) throw_error(ErrorClass::internal, "an empty schedule was given to the scheduler");
    Schedule::State& state = schedule.state();
    if (state.device != device) {
      throw_error(ErrorClass::device, "schedule '{}' was recorded for another device", schedule.name());
    }
    if (!state.facts->failure.empty()) {
      throw_error(ErrorClass::device, "schedule '{}' failed before and cannot run again: {}", schedule.name(),
                  state.facts->failure);
    }
    return state;
  }

  /// Executes once; on errors drains and marks the schedule.
  RunResult execute(Schedule::State& schedule, const ScheduleRun::Options& how, bool keep) {
    ScheduleRun run(schedule, how, calls);
    try {
      const RunResult result = run.execute();
      if (result == RunResult::cancelled) {
        ++cancelled_runs;
        device->finish();
        ++calls.waits;
        log.retire(0, calls);
        return result;
      }
      log.add(schedule, run.take_record(), keep);
      if (schedule.has_read_back || how.warm_up) log.retire(0, calls);
      return result;
    } catch (...) {
      fail(schedule, std::current_exception());
      throw;
    }
  }

  void fail(Schedule::State& schedule, const std::exception_ptr& cause) {
    try {
      device->finish();
      log.drop();
      std::rethrow_exception(cause);
    } catch (const std::exception& error) {
      schedule.facts->failure = error.what();
    } catch (...) {
      schedule.facts->failure = "an unknown exception";
    }
  }
};

KernelScheduler::KernelScheduler(std::shared_ptr<Device> device, SchedulerOptions options)
    : state_(std::make_unique<State>()) {
  state_->device = std::move(device);
  state_->options = options;
}

KernelScheduler::~KernelScheduler() {
  try {
    finish();
  } catch (const Error& error) {
    log_warning("{}", error.what());
  }
}

Device& KernelScheduler::device() const { return *state_->device; }

ScheduleRecorder KernelScheduler::record(std::string name, std::string owner) const {
  return ScheduleRecorder(*state_->device, std::move(name), std::move(owner), state_->options.debug_memory);
}

RunResult KernelScheduler::run(Schedule& schedule) { return replay(schedule, true); }

void KernelScheduler::run_to_end(Schedule& schedule) { replay(schedule, false); }

RunResult KernelScheduler::replay(Schedule& schedule, bool cancellable) {
  Schedule::State& state = state_->check_runnable(schedule);
  const auto start = Clock::now();
  if (state_->log.waiting() >= runs_in_flight) state_->log.retire(runs_in_flight - 1, state_->calls);
  ScheduleRun::Options how;
  how.overlap = state_->overlaps(state);
  how.cancelled = cancellable ? &state_->cancelled : nullptr;
  const RunResult result = state_->execute(state, how, state_->options.profile);
  state_->log.add_wall_seconds(seconds_since(start));
  if (result == RunResult::cancelled) return result;
  for (CompiledStep& step : state.steps) {
    if (step.kind == StepKind::read_back && step.consume) step.consume(step.staging);
  }
  return result;
}

uint64_t KernelScheduler::run(Schedule& schedule, const Budget& budget) {
  const auto start = Clock::now();
  uint64_t completed = 0;
  while ((budget.iterations == 0 || completed < budget.iterations) &&
         (budget.seconds <= 0 || seconds_since(start) < budget.seconds)) {
    if (run(schedule) == RunResult::cancelled) break;
    ++completed;
  }
  finish();
  return completed;
}

void KernelScheduler::finish() {
  const auto start = Clock::now();
  state_->log.retire(0, state_->calls);
  state_->log.add_wall_seconds(seconds_since(start));
}

void KernelScheduler::warm_up(Schedule& schedule) {
  Schedule::State& state = state_->check_runnable(schedule);
  finish();
  std::unique_ptr<ScratchCopies> scratch_copies;
  try {
    scratch_copies = std::make_unique<ScratchCopies>(state);
  } catch (const Error& error) {
    log_warning("no warm-up of schedule '{}': {}", schedule.name(), error.what());
    return;
  }
  ScheduleRun::Options how;
  how.warm_up = true;
  how.cancelled = &state_->cancelled;
  const ApiCalls before = state_->calls;
  state_->execute(state, how, false);
  state_->calls = before;
  cache_specialized_kernels(device());
}

void KernelScheduler::set_cancel(std::function<bool()> cancel_requested) {
  state_->cancelled = std::move(cancel_requested);
}

const Profile& KernelScheduler::profile() const { return state_->log.profile(); }

void KernelScheduler::reset_profile() {
  finish();
  state_->log.reset();
}

const ApiCalls& KernelScheduler::api_calls() const { return state_->calls; }

uint64_t KernelScheduler::cancelled_runs() const { return state_->cancelled_runs; }

}  // namespace lucarium
