// SPDX-License-Identifier: Apache-2.0
#include "lucarium/compute/device/kernel_compilers.h"

#include <dlfcn.h>

#include <algorithm>
#include <utility>

#include "lucarium/base/error.h"
#include "lucarium/base/json.h"
#include "lucarium/base/log.h"
#include "lucarium/compute/device/host_memory.h"
#include "lucarium/compute/device/pocl_folder.h"

namespace lucarium {
namespace fs = std::filesystem;
namespace {

constexpr size_t most_useful = 4;                   // one long kernel takes as long as all others together
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
    : platform_(device.platform), device_(device.name), most_processes_(processes) {}

KernelCompilers::~KernelCompilers() {
  {
    const std::lock_guard lock(mutex_);
    ending_ = true;
  }
  changed_.notify_all();
  for (const auto& process : processes_) process->kill();
  for (std::thread& thread : threads_) thread.join();
}

void KernelCompilers::start_processes() {
  try {
    while (threads_.size() < most_processes_) {
      processes_.push_back(std::make_unique<ChildConversation>(
          std::vector<std::string>{compiler_program().string(), platform_, device_}));
      ++living_;
      threads_.emplace_back([this, process = processes_.back().get()] { serve(*process); });
    }
  } catch (const std::exception& error) {
    log_debug("kernels are compiled by {} other processes: {}", threads_.size(), error.what());
    most_processes_ = threads_.size();
  }
}

void KernelCompilers::want(LaunchCode code) {
  const std::lock_guard lock(mutex_);
  if (most_processes_ == 0 || !wanted_.insert(code.id).second) return;
  start_processes();
  unfinished_.insert(code.id);
  waiting_.push_back(std::move(code));
  changed_.notify_one();
}

void KernelCompilers::wait_for(const std::string& id) {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [&] { return living_ == 0 || !unfinished_.contains(id); });
}

void KernelCompilers::serve(ChildConversation& process) {
  for (;;) {
    LaunchCode code;
    {
      std::unique_lock lock(mutex_);
      changed_.wait(lock, [&] { return ending_ || !waiting_.empty(); });
      if (ending_) return;
      const auto longest = std::max_element(waiting_.begin(), waiting_.end(), takes_less_time);
      code = std::move(*longest);
      waiting_.erase(longest);
    }
    std::string answer;
    const bool is_there = process.ask(request(code), answer);
    {
      const std::lock_guard lock(mutex_);
      unfinished_.erase(code.id);
      if (!is_there) --living_;
    }
    changed_.notify_all();
    if (is_there) continue;
    log_debug("a process that compiles kernels has ended at kernel {}", code.kernel);
    return;
  }
}

std::unique_ptr<KernelCompilers> make_kernel_compilers(const DeviceInfo& device, const DeviceOptions& options) {
  const size_t processors =
      options.threads > 0 ? static_cast<size_t>(options.threads) : std::max(std::thread::hardware_concurrency(), 1u);
  const bool useful = device.is_pocl && device.type == DeviceType::cpu && driver_folder() && processors > 1;
  if (!useful || compiler_program().empty()) return nullptr;
  const size_t possible = std::min({processors, most_useful, available_host_memory() / bytes_of_one});
  return possible > 0 ? std::make_unique<KernelCompilers>(device, possible) : nullptr;
}

}  // namespace lucarium
