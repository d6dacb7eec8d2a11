// SPDX-License-Identifier: Apache-2.0
// One execution of a compiled schedule: internal to compute/.
#pragma once
#include <functional>
#include <utility>
#include <vector>

#include "lucarium/compute/schedule/schedule_state.h"
#include "lucarium/compute/schedule/scheduler.h"

namespace lucarium {

/// Record of a run, readable when it has ended on the device.
struct RunRecord {
  struct StepEvent {
    size_t step = 0;
    bool first = true;  ///< of the step's slices
    double moved_bytes = 0;
    ClEvent event;
  };
  struct HostTime {
    size_t step = 0;
    double seconds = 0;
  };
  std::vector<StepEvent> events;
  std::vector<HostTime> host_times;
  ClEvent end;  ///< complete when everything of the run is; null: nothing was enqueued
};

/// Enqueues the steps in order. On an in-order queue that order is all; on the out-of-order queue every command waits
/// for the events of its predecessors in the reduced graph, and barriers tie the run into the device's in-order queue,
/// so that work outside of the schedule keeps its place.
class ScheduleRun {
 public:
  struct Options {
    bool overlap = false;
    bool warm_up = false;  ///< warm-up: no host steps, no read-backs, nothing left out
    const std::function<bool()>* cancelled = nullptr;
  };
  ScheduleRun(Schedule::State& state, const Options& options, ApiCalls& calls);

  /// Throws Error, naming the step. After `cancelled` or an error the caller waits for the device.
  RunResult execute();
  RunRecord take_record() { return std::move(record_); }

 private:
  void begin();
  void end();
  void start_lives(const CompiledStep& step);
  void update_variables();
  void rebind(int life);
  void collect_waits(size_t step);
  bool enqueue_kernel(size_t index);
  bool wait_for_launch_code(size_t index, const std::array<size_t, 3>& global);
  bool enqueue_slices(size_t index, std::array<size_t, 3> global);
  void enqueue_piece(size_t index, const std::array<size_t, 3>& global, bool first);
  void enqueue_fill(size_t index);
  void enqueue_read_back(size_t index);
  void enqueue_counter_read(size_t index);
  void run_host_step(size_t index);
  void check_guards(const CompiledStep& step);
  void add_event(size_t index, bool first, cl_event event, size_t bytes);
  double expected_seconds(size_t step) const;
  void limit_queued_work(size_t step);
  void wait_for_oldest();
  void wait(const std::vector<cl_event>& events, const std::string& about);
  void set_argument(CompiledStep& step, cl_uint position, size_t bytes, const void* value);
  std::array<size_t, 3> global_size(const CompiledStep& step) const;
  [[noreturn]] void launch_failed(const CompiledStep& step, cl_int code, const std::array<size_t, 3>& global) const;
  cl_uint wait_count() const { return options_.overlap ? static_cast<cl_uint>(waits_.size()) : 0; }
  const cl_event* wait_list() const { return wait_count() ? waits_.data() : nullptr; }
  CompiledStep& step(size_t index) { return state_.steps[index]; }
  bool cancelled() const { return options_.cancelled && *options_.cancelled && (*options_.cancelled)(); }

  Schedule::State& state_;
  Device& device_;
  Options options_;
  ApiCalls& calls_;
  cl_command_queue queue_;
  RunRecord record_;
  ClEvent start_;                                   ///< overlap: everything before this run on the in-order queue
  std::vector<cl_event> waits_;                     ///< of the step at hand
  std::vector<cl_event> done_;                      ///< events after which a step is done, all steps'
  std::vector<std::pair<size_t, size_t>> done_of_;  ///< each step's part of done_
  std::vector<cl_event> counter_events_;
  size_t first_queued_ = 0;    ///< events before this one are known to have ended
  double queued_seconds_ = 0;  ///< expected of the others
};

}  // namespace lucarium
