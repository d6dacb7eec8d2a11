// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <fmt/format.h>

#include <stdexcept>
#include <string>
#include <vector>

namespace lucarium {

/// Class of a failure, by who can fix it; the value is the program's exit code (docs/errors.md).
enum class ErrorClass : int {
  check_failed = 1,  ///< a check or comparison failed
  usage = 2,         ///< the command line or a settings file
  input = 3,         ///< a scene, image or other input file
  device = 4,        ///< OpenCL device, driver, memory, kernel
  technique = 5,     ///< a technique or plug-in
  interrupted = 6,   ///< Ctrl-C; partial results are kept
  internal = 70,     ///< a fault of ours
};

/// The only exception that crosses module borders. The message says what failed, on which file, kernel or
/// parameter, and what to do; callers that know more add context: outermost first when printed.
class Error : public std::runtime_error {
 public:
  Error(ErrorClass error_class, const std::string& message);

  /// Returns this error with `context` put before the message ("reading scene.gltf").
  Error with_context(std::string context) const;

  ErrorClass error_class() const noexcept { return class_; }
  int exit_code() const noexcept { return static_cast<int>(class_); }

  /// Further text for `-v` only: build logs, search paths, driver messages.
  const std::string& details() const noexcept { return details_; }
  Error with_details(std::string details) const;

 private:
  ErrorClass class_;
  std::string details_;
};

/// throw_error(ErrorClass::input, "{}: index {} is outside the {} vertices", file, i, n)
template <class... Args>
[[noreturn]] void throw_error(ErrorClass error_class, fmt::format_string<Args...> format, Args&&... args) {
  throw Error(error_class, fmt::format(format, std::forward<Args>(args)...));
}

}  // namespace lucarium
