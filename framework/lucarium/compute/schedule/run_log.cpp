// SPDX-License-Identifier: Apache-2.0
#include "lucarium/compute/schedule/run_log.h"

#include <algorithm>
#include <atomic>
#include <iterator>

#include "lucarium/base/error.h"

namespace lucarium {
namespace {

constexpr size_t event_limit = 100000;

uint64_t new_profile_id() {
  static std::atomic<uint64_t> last{0};
  return ++last;
}

std::string kernel_label(const CompiledStep& step) {
  switch (step.kind) {
    case StepKind::kernel: return step.kernel_name;
    case StepKind::fill_zero: return "(fill)";
    case StepKind::read_back: return "(read-back)";
    case StepKind::counter_read: return "(counter)";
    case StepKind::host: return "(host)";
  }
  return "";
}

uint64_t timestamp(cl_event event, cl_profiling_info which) {
  cl_ulong value = 0;
  clGetEventProfilingInfo(event, which, sizeof(value), &value, nullptr);
  return value;
}

}  // namespace

RunLog::RunLog() : id_(new_profile_id()) {}

void RunLog::reset() {
  profile_ = Profile();
  index_.clear();
  id_ = new_profile_id();
}

void RunLog::assign_slots(Schedule::State& schedule) {
  if (schedule.profile_id == id_) return;
  auto slots = std::make_shared<std::vector<int>>();
  for (const CompiledStep& step : schedule.steps) {
    const std::string kernel = kernel_label(step);
    const auto [found, fresh] =
        index_.try_emplace({schedule.name, step.name, kernel}, static_cast<int>(profile_.passes.size()));
    if (fresh) {
      PassProfile& pass = profile_.passes.emplace_back();
      pass.schedule = schedule.name;
      pass.name = step.name;
      pass.kernel = kernel;
    }
    slots->push_back(found->second);
  }
  schedule.profile_slots = std::move(slots);
  schedule.profile_id = id_;
}

void RunLog::add(Schedule::State& schedule, RunRecord record, bool keep) {
  if (keep) {
    assign_slots(schedule);
    ++profile_.runs;
  }
  waiting_.push_back(
      {std::move(record), schedule.device, schedule.facts, keep ? schedule.profile_slots : nullptr, profile_.runs});
}

void RunLog::retire(size_t count, ApiCalls& calls) {
  while (waiting_.size() > count) {
    const Waiting run = std::move(waiting_.front());
    waiting_.pop_front();
    if (run.record.end) {
      const cl_event end = run.record.end.get();
      ++calls.waits;
      if (const cl_int code = clWaitForEvents(1, &end); code != CL_SUCCESS) report_failure(run, code);
    }
    sum_up(run);
  }
}

/// Marks the schedule failed and throws, naming the first command that the device reports as failed.
void RunLog::report_failure(const Waiting& run, cl_int code) {
  std::string where = fmt::format("a run of {}", run.facts->name);
  for (const RunRecord::StepEvent& each : run.record.events) {
    cl_int status = CL_COMPLETE;
    clGetEventInfo(each.event.get(), CL_EVENT_COMMAND_EXECUTION_STATUS, sizeof(status), &status, nullptr);
    if (status >= 0) continue;
    where = run.facts->where[each.step];
    code = status;
    break;
  }
  run.facts->failure = fmt::format("{}: failed on {}: {}", where, run.device->info().name, opencl_error_name(code));
  throw Error(ErrorClass::device, run.facts->failure);
}

void RunLog::sum_up(const Waiting& run) {
  std::vector<uint64_t> ends;  // of all commands, to separate waiting for the device from launching
  for (const RunRecord::StepEvent& each : run.record.events) {
    if (run.slots) ends.push_back(timestamp(each.event.get(), CL_PROFILING_COMMAND_END));
  }
  if (!std::is_sorted(ends.begin(), ends.end())) std::sort(ends.begin(), ends.end());
  for (const RunRecord::StepEvent& each : run.record.events) {
    const uint64_t started = timestamp(each.event.get(), CL_PROFILING_COMMAND_START);
    const uint64_t ended = timestamp(each.event.get(), CL_PROFILING_COMMAND_END);
    const double seconds = ended > started ? static_cast<double>(ended - started) * 1e-9 : 0;
    run.facts->seconds[each.step] = seconds;
    if (!run.slots) continue;
    const uint64_t queued = timestamp(each.event.get(), CL_PROFILING_COMMAND_QUEUED);
    const int slot = (*run.slots)[each.step];
    PassProfile& pass = profile_.passes[static_cast<size_t>(slot)];
    pass.device_seconds += seconds;
    pass.bytes += each.moved_bytes;
    if (each.first) {
      ++pass.count;
      const auto later_end = std::upper_bound(ends.begin(), ends.end(), started);
      const uint64_t free = later_end == ends.begin() ? queued : std::max(queued, *std::prev(later_end));
      pass.launch_seconds += started > free ? static_cast<double>(started - free) * 1e-9 : 0;
    }
    if (profile_.events.size() < event_limit) profile_.events.push_back({slot, run.run, queued, started, ended});
  }
  for (const RunRecord::HostTime& each : run.record.host_times) {
    run.facts->seconds[each.step] = 0;
    if (!run.slots) continue;
    PassProfile& pass = profile_.passes[static_cast<size_t>((*run.slots)[each.step])];
    ++pass.count;
    pass.device_seconds += each.seconds;
  }
}

}  // namespace lucarium
