// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "lucarium/base/error.h"

namespace lucarium {

/// What the line of error begins with that the program lucarium ends with.
inline constexpr std::string_view error_prefix = "lucarium: error: ";

/// How a child process ended.
struct ChildResult {
  int exit_code = -1;                   ///< of a normal end; -1 when a signal ended it
  int signal = 0;                       ///< that ended it, or 0
  std::string out;                      ///< its standard output
  std::vector<std::string> last_words;  ///< last lines of its standard error, at most 20
  double seconds = 0;                   ///< wall time
  size_t peak_memory_bytes = 0;         ///< resident set, from getrusage
};

/// Runs a program to its end. Its standard input is a file that holds `input`. Lines of its standard error are handed
/// to `on_error_line` as they come; when that throws, the child is killed. An interrupt of this process is passed on to
/// it once, and so is `stop_requested` when it becomes true. Throws Error{input} when it cannot be started or listened
/// to. Any number of threads may call this at once; the child is interrupted when the thread ends.
ChildResult run_child(const std::vector<std::string>& arguments,
                      const std::function<void(std::string_view)>& on_error_line = {}, std::string_view input = {},
                      const std::function<bool()>& stop_requested = {});

/// In a program that run_child() started: asks to be interrupted when the parent ends, however it ends, so that nothing
/// goes on rendering in vain. Call it after install_interrupt_handler().
void end_with_parent();

/// Of the program lucarium that failed: the class that its exit code names, or that of a technique, which may crash it.
ErrorClass class_of_end(const ChildResult& result);

/// Of the program lucarium that failed: its own line of error, else how it ended and its last line.
std::string reason_of_end(const ChildResult& result);

/// "killed by signal 9 (Killed)" or "exit code 4".
std::string describe_end(const ChildResult& result);

}  // namespace lucarium
