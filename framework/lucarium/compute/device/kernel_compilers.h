// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <condition_variable>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "lucarium/base/child_conversation.h"
#include "lucarium/compute/device/device.h"

namespace lucarium {

/// The launch code of one kernel, for one work-group size and class of grid.
struct LaunchCode {
  std::string id;                ///< two of the same id are the same code
  std::filesystem::path source;  ///< holds the program's whole source
  std::string options;           ///< of clBuildProgram
  std::string kernel;
  std::array<size_t, 3> global = {1, 1, 1}, local = {1, 1, 1};
  struct Argument {
    enum class Kind { buffer, value, local } kind = Kind::buffer;
    size_t bytes = 0;  ///< of a value or of local memory
  };
  std::vector<Argument> arguments;
};

/// Other processes that compile launch code into the driver's folder, side by side. PoCL compiles one thing at a time
/// in a process (docs/measurements/building.md), and a first start waits for little else.
///
/// Nothing depends on them: what they have not compiled, PoCL compiles at the launch, as it does without them.
class KernelCompilers {
 public:
  /// `processes` of them at the most, which end when there is nothing to do.
  KernelCompilers(const DeviceInfo& device, size_t processes);
  ~KernelCompilers();
  KernelCompilers(const KernelCompilers&) = delete;
  KernelCompilers& operator=(const KernelCompilers&) = delete;

  /// Has it compiled, unless that was asked before.
  void want(LaunchCode code);
  /// Whether it was asked and is not yet there.
  bool compiles(const std::string& id);
  /// Waits until it is compiled, if that was asked and there is a process to do so; begins it next. False: cancelled.
  bool wait_for(const std::string& id, const std::function<bool()>& cancelled = {});

 private:
  struct Listed;
  void serve();
  bool compile_waiting(ChildConversation& process);

  std::string platform_, device_;
  std::mutex mutex_;  // of all below
  std::condition_variable changed_;
  size_t max_processes_;
  std::vector<LaunchCode> waiting_;
  std::set<std::string> wanted_, unfinished_;
  std::string awaited_;  // the id that somebody waits for
  std::set<const ChildConversation*> processes_;
  size_t serving_ = 0;  // threads that have not ended
  bool ending_ = false;
  std::vector<std::thread> threads_;  // one for each process that there was
};

/// One for each processor that may be used, 4 at the most, fewer where memory is short; null where they would be of no
/// use.
std::unique_ptr<KernelCompilers> make_kernel_compilers(const DeviceInfo& device, const DeviceOptions& options);

}  // namespace lucarium
