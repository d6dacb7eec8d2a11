// SPDX-License-Identifier: Apache-2.0
#include "lucarium/compute/schedule/schedule_run.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "lucarium/base/error.h"
#include "lucarium/base/stopwatch.h"
#include "lucarium/compute/device/kernel_compilers.h"
#include "lucarium/compute/schedule/launch_code.h"

namespace lucarium {
namespace {

/// Work enqueued ahead of the device is limited to this, because what is enqueued cannot be cancelled.
constexpr double queued_seconds_limit = 0.05;
/// Slices of a pass that are enqueued at once, whatever was measured of them before: with a counter that was zero they
/// took no time. Two, so that the device need not wait.
constexpr size_t queued_slices = 2;
/// Expected of a step that was never measured.
constexpr double unknown_step_seconds = 0.005;
constexpr size_t large_fill = 1u << 18;  // bytes: 10 µs or more, several times what a launch takes
constexpr size_t fill_step = 4096;       // parts of fills begin at multiples of it

std::string size_text(const std::array<size_t, 3>& size) { return fmt::format("{}x{}x{}", size[0], size[1], size[2]); }

}  // namespace

ScheduleRun::ScheduleRun(Schedule::State& state, const Options& options, ApiCalls& calls)
    : state_(state),
      device_(*state.device),
      options_(options),
      calls_(calls),
      queue_(options.overlap ? device_.overlap_queue() : device_.queue()) {
  done_of_.reserve(state.steps.size());
  done_.reserve(state.steps.size());
  record_.events.reserve(state.steps.size());
}

RunResult ScheduleRun::execute() {
  state_.in_flight = true;
  begin();
  for (size_t i = 0; i < state_.steps.size(); ++i) {
    limit_queued_work(i);
    if (cancelled()) return RunResult::cancelled;
    collect_waits(i);
    start_lives(step(i));
    const size_t first_done = done_.size();
    bool completed = true;
    switch (step(i).kind) {
      case StepKind::kernel: completed = enqueue_kernel(i); break;
      case StepKind::fill_zero: enqueue_fill(i); break;
      case StepKind::read_back: enqueue_read_back(i); break;
      case StepKind::counter_read: enqueue_counter_read(i); break;
      case StepKind::host: run_host_step(i); break;
    }
    if (!completed) return RunResult::cancelled;
    // A step that was left out is done when its predecessors are.
    if (done_.size() == first_done) done_.insert(done_.end(), waits_.begin(), waits_.end());
    done_of_.push_back({first_done, done_.size()});
    if (state_.memory->debug()) check_guards(step(i));
  }
  end();
  return RunResult::done;
}

void ScheduleRun::begin() {
  update_variables();
  if (!options_.overlap) return;
  cl_event event = nullptr;
  check_opencl(clEnqueueBarrierWithWaitList(device_.queue(), 0, nullptr, &event), "clEnqueueBarrierWithWaitList",
               state_.name, device_);
  start_ = ClEvent(event);
  ++calls_.enqueues;
  check_opencl(clFlush(device_.queue()), "clFlush", state_.name, device_);
  ++calls_.flushes;
}

void ScheduleRun::end() {
  cl_event event = nullptr;
  if (options_.overlap) {
    waits_.clear();
    for (const int last : state_.last_steps) {
      const auto [first, behind] = done_of_[static_cast<size_t>(last)];
      waits_.insert(waits_.end(), done_.begin() + static_cast<std::ptrdiff_t>(first),
                    done_.begin() + static_cast<std::ptrdiff_t>(behind));
    }
    check_opencl(clFlush(queue_), "clFlush", state_.name, device_);
    check_opencl(clEnqueueBarrierWithWaitList(device_.queue(), wait_count(), wait_list(), &event),
                 "clEnqueueBarrierWithWaitList", state_.name, device_);
    ++calls_.enqueues;
  } else {
    if (!record_.events.empty()) event = record_.events.back().event.get();
    if (event) clRetainEvent(event);
    check_opencl(clFlush(queue_), "clFlush", state_.name, device_);
  }
  ++calls_.flushes;
  record_.end = ClEvent(event);
}

void ScheduleRun::update_variables() {
  for (VariableValue& variable : state_.variables) {
    if (!variable.changed) continue;
    for (const auto& [user, position] : variable.uses) {
      set_argument(step(user), position, variable.value.size(), variable.value.data());
    }
    variable.changed = false;
  }
}

void ScheduleRun::set_argument(CompiledStep& of, cl_uint position, size_t bytes, const void* value) {
  check_opencl(clSetKernelArg(of.kernel.get(), position, bytes, value), "clSetKernelArg", state_.where(of), device_);
  ++calls_.set_arguments;
}

void ScheduleRun::start_lives(const CompiledStep& of) {
  for (const int life : of.begins) {
    const int counter = state_.counter_of_life[static_cast<size_t>(life)];
    if (counter >= 0) {
      const RecordedResource& sized =
          state_.resources[static_cast<size_t>(state_.memory->lives()[static_cast<size_t>(life)].transient)];
      const size_t bytes = sized.bytes() * state_.counters[static_cast<size_t>(counter)].value;
      if (state_.memory->resize(life, bytes)) rebind(life);
    }
    if (state_.memory->debug()) state_.memory->arm(life);
  }
}

/// Sets the arguments that use a slot whose memory has changed.
void ScheduleRun::rebind(int life) {
  const cl_mem handle = state_.memory->handle(life);
  for (CompiledStep& user : state_.steps) {
    for (const BoundBuffer& bound : user.buffers) {
      if (bound.memory.life < 0 || !state_.memory->same_slot(bound.memory.life, life)) continue;
      set_argument(user, bound.position, sizeof(cl_mem), &handle);
    }
  }
}

void ScheduleRun::collect_waits(size_t index) {
  waits_.clear();
  if (!options_.overlap && step(index).kind != StepKind::host) return;  // the queue keeps the order
  for (const int predecessor : state_.graph.predecessors(static_cast<int>(index))) {
    const auto [first, behind] = done_of_[static_cast<size_t>(predecessor)];
    waits_.insert(waits_.end(), done_.begin() + static_cast<std::ptrdiff_t>(first),
                  done_.begin() + static_cast<std::ptrdiff_t>(behind));
  }
  if (waits_.empty() && start_) waits_.push_back(start_.get());
}

std::array<size_t, 3> ScheduleRun::global_size(const CompiledStep& of) const {
  std::array<size_t, 3> global = of.global;
  if (of.counter >= 0) {
    const double count = state_.counters[static_cast<size_t>(of.counter)].value;
    global[0] = static_cast<size_t>(std::ceil(count * of.items_per_count));
  }
  if (options_.warm_up) {
    for (size_t& items : global) items = std::max<size_t>(items, 1);
  }
  return whole_groups(global, of.local);
}

bool ScheduleRun::enqueue_kernel(size_t index) {
  const std::array<size_t, 3> global = global_size(step(index));
  if (global[0] * global[1] * global[2] == 0) return true;
  if (options_.warm_up) {
    while (first_queued_ < record_.events.size()) wait_for_oldest();  // drivers may compile behind the enqueueing
    device_.compile_progress().launching(step(index).launch);
  }
  if (!wait_for_launch_code(index, global)) return false;
  if (step(index).slice_items > 0) return enqueue_slices(index, global);
  const bool of_any_class = options_.warm_up && device_.info().is_pocl && step(index).counter >= 0;
  const bool as_small = !of_any_class || !large_code_serves_small_grids(device_.info());
  if (as_small) enqueue_piece(index, global, true);
  if (of_any_class) enqueue_piece(index, large_grid(step(index)), !as_small);
  return true;
}

/// What other processes compile of a step's first launch; the wait counts as compiling. False: cancelled.
bool ScheduleRun::wait_for_launch_code(size_t index, const std::array<size_t, 3>& global) {
  KernelCompilers* compilers = device_.kernel_compilers();
  if (!compilers || step(index).has_launch_code) return true;
  for (const std::array<size_t, 3>& size : {launched_grid(step(index), global), large_grid(step(index))}) {
    const std::string id = launch_code_id(step(index), size);
    if (!compilers->compiles(id)) continue;
    while (first_queued_ < record_.events.size()) wait_for_oldest();
    device_.finish();  // earlier runs, too: their time is not compiling
    const Stopwatch watch;
    const bool goes_on = compilers->wait_for(id, [this] { return cancelled(); });
    device_.add_program_seconds(watch.seconds());
    if (!goes_on) return false;
  }
  step(index).has_launch_code = true;
  return true;
}

/// The slices of a pass run one after the other, so that the last one's event stands for all. False: cancelled.
bool ScheduleRun::enqueue_slices(size_t index, std::array<size_t, 3> global) {
  CompiledStep& sliced = step(index);
  const size_t items = global[0], first_event = record_.events.size();
  if (items - 1 > std::numeric_limits<cl_uint>::max()) {
    throw_error(ErrorClass::device, "{}: a sliced pass has at most 2^32 work-items along x, not {}; use several passes",
                state_.where(sliced), items);
  }
  for (size_t base = 0; base < items; base += sliced.slice_items) {
    if (base > 0) {
      limit_queued_work(index);
      while (record_.events.size() - std::max(first_queued_, first_event) >= queued_slices) wait_for_oldest();
      if (cancelled()) return false;
    }
    const cl_uint slice_base = static_cast<cl_uint>(base);
    if (sliced.slice_base != slice_base) {
      sliced.slice_base = slice_base;
      set_argument(sliced, static_cast<cl_uint>(sliced.slice_base_position), sizeof(slice_base), &slice_base);
    }
    global[0] = std::min(sliced.slice_items, items - base);
    if (base > 0) {
      waits_.assign(1, done_.back());
      done_.pop_back();
    }
    enqueue_piece(index, global, base == 0);
  }
  return true;
}

void ScheduleRun::enqueue_piece(size_t index, const std::array<size_t, 3>& global, bool first) {
  const CompiledStep& launched = step(index);
  const cl_uint dimensions = global[2] > 1 || launched.local[2] > 1   ? 3
                             : global[1] > 1 || launched.local[1] > 1 ? 2
                                                                      : 1;
  cl_event event = nullptr;
  const cl_int code = clEnqueueNDRangeKernel(queue_, launched.kernel.get(), dimensions, nullptr, global.data(),
                                             launched.local.data(), wait_count(), wait_list(), &event);
  if (code != CL_SUCCESS) launch_failed(launched, code, global);
  add_event(index, first, event, first ? launched.moved_bytes : 0);
}

void ScheduleRun::launch_failed(const CompiledStep& of, cl_int code, const std::array<size_t, 3>& global) const {
  std::string hint;
  if (code == CL_INVALID_WORK_GROUP_SIZE || code == CL_INVALID_WORK_ITEM_SIZE) {
    hint = fmt::format("; the device takes at most {} work-items per group", device_.info().max_work_group_size);
  }
  throw_error(
      ErrorClass::device, "{}: launch of {} work-items in groups of {} failed on {}: clEnqueueNDRangeKernel: {}{}",
      state_.where(of), size_text(global), size_text(of.local), device_.info().name, opencl_error_name(code), hint);
}

/// Drivers of processors fill with one thread: where passes may run at once, each thread fills a part of what is large.
void ScheduleRun::enqueue_fill(size_t index) {
  const CompiledStep& fill = step(index);
  const size_t bytes = state_.bytes(fill.target);
  const cl_uint zeros[4] = {0, 0, 0, 0};
  const bool in_parts = options_.overlap && bytes >= large_fill && device_.info().type == DeviceType::cpu;
  const size_t parts = in_parts ? std::max(1u, device_.info().compute_units) : 1;
  const size_t part = (bytes + parts * fill_step - 1) / (parts * fill_step) * fill_step;
  for (size_t begin = 0; begin < bytes; begin += part) {
    const size_t filled = std::min(part, bytes - begin);
    const size_t pattern_bytes = filled % 16 == 0 ? 16 : filled % 4 == 0 ? 4 : 1;
    cl_event event = nullptr;
    check_opencl(clEnqueueFillBuffer(queue_, state_.handle(fill.target), zeros, pattern_bytes, begin, filled,
                                     wait_count(), wait_list(), &event),
                 "clEnqueueFillBuffer", state_.where(fill), device_);
    add_event(index, begin == 0, event, filled);
  }
}

void ScheduleRun::enqueue_read_back(size_t index) {
  if (options_.warm_up) return;
  CompiledStep& copy = step(index);
  const size_t bytes = state_.bytes(copy.target);
  copy.staging.resize(bytes);
  if (bytes == 0) return;
  cl_event event = nullptr;
  check_opencl(clEnqueueReadBuffer(queue_, state_.handle(copy.target), CL_FALSE, 0, bytes, copy.staging.data(),
                                   wait_count(), wait_list(), &event),
               "clEnqueueReadBuffer", state_.where(copy), device_);
  add_event(index, true, event, bytes);
}

/// Counter reads that follow each other share one wait.
void ScheduleRun::enqueue_counter_read(size_t index) {
  const CompiledStep& read = step(index);
  CounterValue& counter = state_.counters[static_cast<size_t>(read.counter)];
  const size_t offset = counter.index * sizeof(cl_uint);
  if (offset + sizeof(cl_uint) > state_.bytes(read.target)) {
    throw_error(ErrorClass::device, "{}: the counter lies outside of the buffer's {} bytes", state_.where(read),
                state_.bytes(read.target));
  }
  cl_event event = nullptr;
  check_opencl(clEnqueueReadBuffer(queue_, state_.handle(read.target), CL_FALSE, offset, sizeof(cl_uint),
                                   &counter.value, wait_count(), wait_list(), &event),
               "clEnqueueReadBuffer", state_.where(read), device_);
  add_event(index, true, event, sizeof(cl_uint));
  counter_events_.push_back(event);
  const bool more = index + 1 < state_.steps.size() && step(index + 1).kind == StepKind::counter_read;
  if (more) return;
  wait(counter_events_, state_.where(read));
  counter_events_.clear();
}

void ScheduleRun::run_host_step(size_t index) {
  if (options_.warm_up) return;
  if (waits_.empty()) {  // an earlier run may still use what the step touches
    check_opencl(clFinish(queue_), "clFinish", state_.where(step(index)), device_);
    ++calls_.waits;
  } else {
    wait(waits_, state_.where(step(index)));
  }
  const Stopwatch watch;
  if (step(index).work) step(index).work();
  record_.host_times.push_back({index, watch.seconds()});
}

void ScheduleRun::check_guards(const CompiledStep& of) {
  check_opencl(clFinish(queue_), "clFinish", state_.where(of), device_);
  ++calls_.waits;
  for (const int life : of.lives) state_.memory->check_guards(life, of.name);
}

void ScheduleRun::add_event(size_t index, bool first, cl_event event, size_t bytes) {
  ++calls_.enqueues;
  record_.events.push_back({index, first, static_cast<double>(bytes), ClEvent(event)});
  done_.push_back(event);
  queued_seconds_ += expected_seconds(index);
}

double ScheduleRun::expected_seconds(size_t index) const {
  const double seconds = state_.facts->seconds[index];
  return seconds < 0 ? unknown_step_seconds : seconds;
}

void ScheduleRun::limit_queued_work(size_t index) {
  const double next = expected_seconds(index);
  while (first_queued_ < record_.events.size() && queued_seconds_ + next > queued_seconds_limit) wait_for_oldest();
}

/// Waits for the oldest step that is enqueued and not waited for yet.
void ScheduleRun::wait_for_oldest() {
  const RunRecord::StepEvent& oldest = record_.events[first_queued_++];
  wait({oldest.event.get()}, state_.where(step(oldest.step)));
  queued_seconds_ -= expected_seconds(oldest.step);
}

void ScheduleRun::wait(const std::vector<cl_event>& events, const std::string& about) {
  check_opencl(clWaitForEvents(static_cast<cl_uint>(events.size()), events.data()), "clWaitForEvents", about, device_);
  ++calls_.waits;
}

}  // namespace lucarium
