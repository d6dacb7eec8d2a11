// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "lucarium/compute/schedule/profile.h"
#include "lucarium/compute/schedule/schedule.h"

namespace lucarium {

struct SchedulerOptions {
  QueueMode queue = QueueMode::automatic;
  bool profile = true;
  /// Debug mode, for schedules recorded through KernelScheduler::record(): transients do not share memory, are filled
  /// with a poison pattern before first use and lie between guard zones that are checked after every pass
  /// (Error{internal} names pass and transient). Passes run one at a time.
  bool debug_memory = false;
};

/// How long to go on; whichever ends first. Checked between runs, and between long passes for cancellation.
struct Budget {
  double seconds = 0;       ///< 0: no limit
  uint64_t iterations = 0;  ///< 0: no limit
};

enum class RunResult { done, cancelled };

/// OpenCL calls made by runs.
struct ApiCalls {
  uint64_t enqueues = 0;       ///< kernels, fills, copies, and the barriers between queues
  uint64_t set_arguments = 0;  ///< clSetKernelArg
  uint64_t waits = 0;          ///< clWaitForEvents, clFinish
  uint64_t flushes = 0;
};

/// Executes schedules on one device. Not thread-safe.
class KernelScheduler {
 public:
  explicit KernelScheduler(std::shared_ptr<Device> device, SchedulerOptions options = {});
  ~KernelScheduler();

  Device& device() const;
  /// `owner` pays for the schedule's transients.
  ScheduleRecorder record(std::string name, std::string owner) const;

  /// One replay. Returns `cancelled` when `cancel_requested` fired between passes (the run's results are then partial
  /// and must be discarded). A failing kernel drains the queue, marks the schedule failed and throws Error{device}
  /// that names pass, kernel and device; exceptions of host steps are passed on unchanged. A failed schedule refuses
  /// further runs. Returns before the device is finished only if there is nothing to read back; at most two such runs
  /// are in flight. Passes that are known to be long are enqueued a few at a time, so that cancellation is felt.
  RunResult run(Schedule& schedule);

  /// The same to its end, whatever set_cancel() says: for resolving the samples so far after Ctrl-C.
  void run_to_end(Schedule& schedule);

  /// Replays until the budget is used up or cancelled; returns the number of completed iterations.
  uint64_t run(Schedule& schedule, const Budget& budget);

  /// Waits until everything enqueued has run, and consumes read-backs and profile events.
  void finish();

  /// Runs the schedule once outside the clocks on copies of the callers' buffers that it writes, without host steps
  /// and read-backs, so that drivers compile what they compile at first launch (PoCL: every kernel, per local size and
  /// grid class). Touches no caller's buffer. A pass that a counter would leave out is launched with one group. Where
  /// memory does not suffice for the copies it warns and does nothing.
  void warm_up(Schedule& schedule);

  /// Asked between passes and runs; default: lucarium::interrupt_requested.
  void set_cancel(std::function<bool()> cancel_requested);

  const Profile& profile() const;
  void reset_profile();
  /// Made so far (tests count them): a replay sets arguments only where a variable or a slice changed.
  const ApiCalls& api_calls() const;
  /// Runs that ended with RunResult::cancelled so far.
  uint64_t cancelled_runs() const;

 private:
  RunResult replay(Schedule& schedule, bool cancellable);
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace lucarium
