// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <functional>
#include <memory>
#include <string>

#include "lucarium/compute/profile.h"
#include "lucarium/compute/schedule.h"

namespace lucarium {

struct SchedulerOptions {
  QueueMode queue = QueueMode::automatic;
  bool profile = true;
  /// Debug mode: transients do not share memory, are filled with a poison pattern before first use and have guard
  /// zones that are checked after every run (Error{internal} names the pass).
  bool debug_memory = false;
};

/// How long to go on; whichever ends first. Checked between runs, and between long passes for cancellation.
struct Budget {
  double seconds = 0;       ///< 0: no limit
  uint64_t iterations = 0;  ///< 0: no limit
};

enum class RunResult { done, cancelled };

/// Executes schedules on one device. Not thread-safe.
class KernelScheduler {
 public:
  explicit KernelScheduler(std::shared_ptr<Device> device, SchedulerOptions options = {});
  ~KernelScheduler();

  Device& device() const;
  ScheduleRecorder record(std::string name, std::string owner) const;

  /// One replay. Returns `cancelled` when `cancel_requested` fired between passes (the run's results are then partial
  /// and must be discarded). A failing kernel drains the queue, marks the schedule failed and throws Error{device}
  /// that names pass, kernel and device. Returns before the device is finished only if there is nothing to read back.
  RunResult run(Schedule& schedule);

  /// Replays until the budget is used up or cancelled; returns the number of completed iterations.
  uint64_t run(Schedule& schedule, const Budget& budget);

  /// Waits until everything enqueued has run, and consumes read-backs and profile events.
  void finish();

  /// Launches every kernel of the schedule once with nothing to do (global size of one group, `slice_base`/counts such
  /// that kernels return at once is not guaranteed, so transients are used as targets): compiles what drivers compile
  /// at first launch, outside the clocks, and touches no caller's buffer.
  void warm_up(Schedule& schedule);

  /// Asked between passes; default: lucarium::interrupt_requested.
  void set_cancel(std::function<bool()> cancel_requested);

  const Profile& profile() const;
  void reset_profile();
  /// OpenCL enqueue, set-argument and wait calls made so far (tests count them).
  uint64_t api_calls() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace lucarium
