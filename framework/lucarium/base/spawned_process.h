// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <sys/resource.h>
#include <sys/types.h>

#include <string>
#include <utility>
#include <vector>

namespace lucarium {

/// Names the process that started this one, in its environment.
inline constexpr const char* parent_variable = "LUCARIUM_PARENT_PROCESS";

/// A child process that is killed unless it was waited for.
class SpawnedProcess {
 public:
  /// Starts a program, found in PATH unless its name has a slash, with these descriptors as its standard streams and
  /// another one that it holds while it lives (-1: none). Throws Error{input} when it cannot be started.
  SpawnedProcess(std::vector<std::string> arguments, int in, int out, int error, int held = -1);
  ~SpawnedProcess();
  SpawnedProcess(const SpawnedProcess&) = delete;
  SpawnedProcess& operator=(const SpawnedProcess&) = delete;

  void signal(int number) const;
  /// Its status and resource usage.
  std::pair<int, rusage> wait();

 private:
  pid_t id_ = -1;
};

}  // namespace lucarium
