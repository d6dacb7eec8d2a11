// SPDX-License-Identifier: Apache-2.0
#include "lucarium/compare/execute/local_executor.h"

#include <atomic>
#include <condition_variable>
#include <deque>
#include <exception>
#include <mutex>
#include <optional>
#include <thread>

#include "lucarium/base/error.h"
#include "lucarium/base/files/file_lock.h"
#include "lucarium/base/interrupt.h"
#include "lucarium/compare/execute/device_shares.h"
#include "lucarium/job/job_file.h"
#include "lucarium/job/run_job.h"

namespace lucarium {
namespace fs = std::filesystem;
namespace {

/// How it ended and its last line; empty: well.
std::string failure_of(const ChildResult& child) {
  if (child.exit_code == 0) return "";
  return fmt::format("{}: {}", describe_end(child), child.last_words.empty() ? "no message" : child.last_words.back());
}

/// On this machine's device; empty: the job's own.
PieceEnd perform_task(const fs::path& program, const PieceTask& task, const std::string& device,
                      const std::function<void(std::string_view)>& on_line,
                      const std::function<bool()>& stop_requested = {}) {
  Job job = task.job;
  if (!device.empty()) job.device.selector = device;
  PieceEnd end = perform_job(program, job_json(job), task.lock, on_line, stop_requested);
  end.machine.device_index = device;
  return end;
}

/// Runs a list with one thread per device; what happens is reported in the thread that calls run().
class SharedRun {
 public:
  SharedRun(const fs::path& program, const std::vector<std::string>& devices, const std::vector<PieceTask>& tasks,
            const PieceEvents& events)
      : program_(program), devices_(devices), tasks_(tasks), events_(events), shares_(likes(tasks), devices.size()) {}

  void run() {
    working_ = devices_.size();
    std::vector<std::thread> threads;
    for (size_t device = 0; device < devices_.size(); ++device) threads.emplace_back([this, device] { work(device); });
    report_events();
    for (std::thread& thread : threads) thread.join();
    if (error_) std::rethrow_exception(error_);
  }

 private:
  static std::vector<std::string> likes(const std::vector<PieceTask>& tasks) {
    std::vector<std::string> texts;
    for (const PieceTask& task : tasks) texts.push_back(task.like);
    return texts;
  }

  bool stopped() const { return stop_ || interrupt_requested(); }

  void report(std::function<void()> event) {
    const std::lock_guard lock(mutex_);
    reported_.push_back(std::move(event));
    changed_.notify_all();
  }

  /// Until the last thread has ended. After a failure the rest is not reported.
  void report_events() {
    std::unique_lock lock(mutex_);
    while (working_ > 0 || !reported_.empty()) {
      if (reported_.empty()) {
        changed_.wait(lock);
        continue;
      }
      const std::function<void()> event = std::move(reported_.front());
      reported_.pop_front();
      const bool failed = error_ != nullptr;
      lock.unlock();
      if (!failed) {
        try {
          event();
        } catch (...) {
          fail();
        }
      }
      lock.lock();
    }
  }

  void fail() {
    const std::lock_guard lock(mutex_);
    if (!error_) error_ = std::current_exception();
    stop_ = true;
    changed_.notify_all();
  }

  /// The next task for a device; waits while another device may still hand one back.
  std::optional<size_t> next(size_t device, size_t& beside) {
    std::unique_lock lock(mutex_);
    while (!stopped() && !shares_.all_done()) {
      beside = shares_.running();
      if (const std::optional<size_t> task = shares_.take(device)) return task;
      changed_.wait_for(lock, std::chrono::milliseconds(200));
    }
    return std::nullopt;
  }

  void perform(size_t device, size_t task, size_t beside) {
    report([this, task] { events_.on_start(task); });
    PieceEnd end = perform_task(
        program_, tasks_[task], devices_[device],
        [&](std::string_view line) { report([this, task, text = std::string(line)] { events_.on_line(task, text); }); },
        [this] { return stop_.load(); });
    end.machine.other_jobs = static_cast<unsigned>(beside);
    const bool failed = !end.failure.empty();
    std::unique_lock lock(mutex_);
    bool again = false;
    std::string line;
    if (!stopped() && failed) {
      again = shares_.fail(task, device);
      if (again)
        line = fmt::format("{}: device {}: {}; trying another", tasks_[task].name, devices_[device], end.failure);
    } else if (!stopped()) {
      for (const size_t idle : shares_.finish(task))
        line = fmt::format("device {} gets nothing more: {} failures there were none elsewhere", devices_[idle],
                           DeviceShares::patience);
    }
    lock.unlock();
    if (!line.empty()) report([this, line] { events_.say(line); });
    if (!again) report([this, task, end = std::move(end)] { events_.on_end(task, end); });
  }

  void work(size_t device) {
    size_t beside = 0;
    try {
      while (const std::optional<size_t> task = next(device, beside)) perform(device, *task, beside);
    } catch (...) {
      fail();
    }
    const std::lock_guard lock(mutex_);
    --working_;
    changed_.notify_all();
  }

  const fs::path& program_;
  const std::vector<std::string>& devices_;
  const std::vector<PieceTask>& tasks_;
  const PieceEvents& events_;

  std::mutex mutex_;  // of all below
  std::condition_variable changed_;
  DeviceShares shares_;
  std::deque<std::function<void()>> reported_;
  size_t working_ = 0;  ///< threads
  std::exception_ptr error_;
  std::atomic<bool> stop_ = false;
};

}  // namespace

PieceEnd perform_job(const fs::path& program, const std::string& job, const fs::path& lock_file,
                     const std::function<void(std::string_view)>& on_line,
                     const std::function<bool()>& stop_requested) {
  std::optional<FileLock> lock;
  if (!lock_file.empty()) {
    std::error_code ignored;
    fs::create_directories(lock_file.parent_path(), ignored);
    lock.emplace(lock_file, [&] { on_line("waiting for another run that renders the same"); });
  }
  PieceEnd end;
  end.machine = describe_piece_machine();
  end.child = run_child({program.string(), job_command, "/dev/stdin"}, on_line, job, stop_requested);
  end.failure = failure_of(end.child);
  return end;
}

LocalExecutor::LocalExecutor(fs::path program, std::vector<std::string> devices)
    : program_(std::move(program)), devices_(std::move(devices)) {}

void LocalExecutor::run(const std::vector<PieceTask>& tasks, const PieceEvents& events) {
  if (devices_.size() > 1) {
    SharedRun(program_, devices_, tasks, events).run();
    return;
  }
  const std::string device = devices_.empty() ? "" : devices_.front();
  for (size_t task = 0; task < tasks.size() && !interrupt_requested(); ++task) {
    events.on_start(task);
    PieceEnd end =
        perform_task(program_, tasks[task], device, [&](std::string_view line) { events.on_line(task, line); });
    end.machine.other_jobs = 0;
    events.on_end(task, std::move(end));
  }
}

}  // namespace lucarium
