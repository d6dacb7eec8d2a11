// SPDX-License-Identifier: Apache-2.0
#include "lucarium/compute/device/kernel_compilers.h"

#include <dlfcn.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <utility>

#include "lucarium/base/error.h"
#include "lucarium/base/json.h"
#include "lucarium/base/log.h"
#include "lucarium/compute/device/host_memory.h"
#include "lucarium/compute/device/pocl_folder.h"

namespace lucarium {
namespace fs = std::filesystem;
namespace {

constexpr std::chrono::milliseconds look_up_time{100};  // between two looks at whether it was cancelled
constexpr std::chrono::milliseconds idle_time{2000};
constexpr size_t max_useful = 4;                    // one long kernel takes as long as all others together
constexpr size_t bytes_of_one = size_t{640} << 20;  // while it compiles the longest kernel

/// Beside this library, in a folder of its own (apps/kernel_compiler).
fs::path compiler_program() {
  Dl_info info{};
  std::error_code failure;
  if (!dladdr(reinterpret_cast<const void*>(&compiler_program), &info) || !info.dli_fname) return "";
  fs::path program = fs::weakly_canonical(info.dli_fname, failure).parent_path() / "lucarium/lucarium_kernel_compiler";
  return fs::exists(program, failure) ? program : "";
}

/// The longest first, so that all processes end together. How long it takes shows in how much a kernel is given.
bool takes_less_time(const LaunchCode& a, const LaunchCode& b) { return a.arguments.size() < b.arguments.size(); }

std::string request(const LaunchCode& code) {
  nlohmann::json arguments = nlohmann::json::array();
  for (const LaunchCode::Argument& argument : code.arguments) {
    const bool is_buffer = argument.kind == LaunchCode::Argument::Kind::buffer;
    const char* kind = is_buffer ? "buffer" : argument.kind == LaunchCode::Argument::Kind::value ? "value" : "local";
    arguments.push_back({{"kind", kind}, {"bytes", argument.bytes}});
  }
  return nlohmann::json({{"source", code.source.string()},
                         {"options", code.options},
                         {"kernel", code.kernel},
                         {"global", code.global},
                         {"local", code.local},
                         {"arguments", arguments}})
      .dump();
}

}  // namespace

KernelCompilers::KernelCompilers(const DeviceInfo& device, size_t processes)
    : platform_(device.platform), device_(device.name), max_processes_(processes) {}

KernelCompilers::~KernelCompilers() {
  {
    const std::lock_guard lock(mutex_);
    ending_ = true;
    for (const ChildConversation* process : processes_) process->kill();
  }
  changed_.notify_all();
  for (std::thread& thread : threads_) thread.join();
}

/// Known to the destructor while it lives.
struct KernelCompilers::Listed {
  KernelCompilers& all;
  const ChildConversation* process;
  Listed(KernelCompilers& compilers, const ChildConversation& one) : all(compilers), process(&one) {
    const std::lock_guard lock(all.mutex_);
    all.processes_.insert(process);
  }
  ~Listed() {
    const std::lock_guard lock(all.mutex_);
    all.processes_.erase(process);
  }
};

void KernelCompilers::want(LaunchCode code) {
  const std::lock_guard lock(mutex_);
  if (max_processes_ == 0 || !wanted_.insert(code.id).second) return;
  if (serving_ < std::min(max_processes_, unfinished_.size() + 1)) {
    try {
      threads_.emplace_back([this] { serve(); });
      ++serving_;
    } catch (const std::exception& error) {
      log_debug("no more processes for compiling kernels: {}", error.what());
      max_processes_ = serving_;
    }
  }
  if (serving_ == 0) return;
  unfinished_.insert(code.id);
  waiting_.push_back(std::move(code));
  changed_.notify_all();
}

bool KernelCompilers::compiles(const std::string& id) {
  const std::lock_guard lock(mutex_);
  return serving_ > 0 && unfinished_.contains(id);
}

bool KernelCompilers::wait_for(const std::string& id, const std::function<bool()>& cancelled) {
  std::unique_lock lock(mutex_);
  awaited_ = id;
  while (serving_ > 0 && unfinished_.contains(id)) {
    if (cancelled && cancelled()) return false;
    changed_.wait_for(lock, look_up_time);
  }
  return true;
}

void KernelCompilers::serve() {
  std::string problem;
  try {
    const int held = driver_folder() ? driver_folder()->lock() : -1;
    ChildConversation process({compiler_program().string(), platform_, device_}, held);
    const Listed listed(*this, process);
    if (!compile_waiting(process)) problem = "it has ended";
  } catch (const std::exception& error) {
    problem = error.what();
  }
  const std::lock_guard lock(mutex_);
  --serving_;
  if (!problem.empty()) {
    log_debug("a process that compiles kernels is of no use: {}", problem);
    --max_processes_;
  }
  changed_.notify_all();
}

/// Until there was nothing to do for a while. False when the process has ended.
bool KernelCompilers::compile_waiting(ChildConversation& process) {
  for (;;) {
    LaunchCode code;
    {
      std::unique_lock lock(mutex_);
      changed_.wait_for(lock, idle_time, [&] { return ending_ || !waiting_.empty(); });
      if (ending_ || waiting_.empty()) return true;
      auto next = std::find_if(waiting_.begin(), waiting_.end(), [&](const auto& c) { return c.id == awaited_; });
      if (next == waiting_.end()) next = std::max_element(waiting_.begin(), waiting_.end(), takes_less_time);
      code = std::move(*next);
      waiting_.erase(next);
    }
    std::string answer;
    const bool is_done = process.ask(request(code), answer) && answer == "done";
    {
      const std::lock_guard lock(mutex_);
      unfinished_.erase(code.id);
    }
    changed_.notify_all();
    if (!is_done) return false;
  }
}

std::unique_ptr<KernelCompilers> make_kernel_compilers(const DeviceInfo& device, const DeviceOptions& options) {
  const size_t processors =
      options.threads > 0 ? static_cast<size_t>(options.threads) : std::max(std::thread::hardware_concurrency(), 1u);
  const char* kept = std::getenv("POCL_KERNEL_CACHE");  // 0: each process compiles for itself
  const bool shares = driver_folder() && !(kept && std::string(kept) == "0");
  const bool useful = device.is_pocl && device.type == DeviceType::cpu && shares && processors > 1;
  if (!useful || compiler_program().empty()) return nullptr;
  const size_t possible = std::min({processors, max_useful, available_host_memory() / bytes_of_one});
  return possible > 0 ? std::make_unique<KernelCompilers>(device, possible) : nullptr;
}

}  // namespace lucarium
