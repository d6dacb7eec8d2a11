// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <CL/cl.h>

#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "lucarium/base/embedded_files.h"
#include "lucarium/compute/device/device.h"

namespace lucarium {

/// Where kernel sources come from: embedded tables, over which the roots of LUCARIUM_KERNEL_PATH (colon-separated
/// folders that hold files by virtual name) win. The framework's own table is always included.
class SourceLibrary {
 public:
  SourceLibrary();  ///< the framework's sources and LUCARIUM_KERNEL_PATH
  void add(const EmbeddedSources& sources);

  /// Text of one file and the name compilers shall show for it (the path on disk, or the virtual name).
  struct File {
    std::string text;
    std::string shown_name;
    std::string virtual_name;
  };
  /// Throws Error{device} naming the file, who includes it and the places searched.
  File find(std::string_view virtual_name, std::string_view included_from = "") const;
  bool contains(std::string_view virtual_name) const;

  /// Resolves `#include "…"` recursively (each file once) and emits `#line` so that messages name real files and
  /// lines. Knows #if only as "maybe": an include inside #if is resolved where it can be and else left to the compiler
  /// (headers shared with C++ name C++ headers there); outside #if, what cannot be resolved throws Error{device}.
  std::string preprocess(const std::vector<std::string>& entry_files) const;

 private:
  std::vector<const EmbeddedSources*> tables_;
  std::vector<std::filesystem::path> roots_;
};

/// What to compile. One program per stage: several related kernels, not one each and not all in one.
struct ProgramSpec {
  std::string name;                            ///< for messages and profiles: "path_tracing/integrator"
  std::vector<std::string> files;              ///< virtual names of the .cl entry files
  std::map<std::string, std::string> defines;  ///< -D name=value (empty value: -D name)
  bool mad_enable = true;                      ///< -cl-mad-enable; off where bitwise agreement with host code matters
};

enum class ArgumentAccess { value, read, read_write, local };

/// One kernel argument as the compiler reports it (-cl-kernel-arg-info).
struct KernelArgument {
  std::string name;
  std::string type;  ///< OpenCL type name without qualifiers: "float4*", "uint", "Camera"
  ArgumentAccess access = ArgumentAccess::value;
};

class Program;

/// Signature of one kernel; obtained from Program::kernel(). Every pass creates its own cl_kernel from it, because
/// argument values live in the kernel object.
struct KernelSignature {
  std::string name;
  std::vector<KernelArgument> arguments;
  size_t required_work_group_size[3] = {0, 0, 0};  ///< 0: none
};

/// A built program. Copies share it.
class Program {
 public:
  Program() = default;
  /// Compiles or takes from the device's cache. Throws Error{device} whose first line is the compiler's first error
  /// with file and line; the whole log is in details().
  Program(Device& device, const SourceLibrary& library, const ProgramSpec& spec);

  explicit operator bool() const { return state_ != nullptr; }
  const std::string& name() const;
  Device& device() const;
  cl_program handle() const;
  bool from_cache() const;       ///< whether it came from disk, uncompiled
  double build_seconds() const;  ///< wall time of compiling or loading
  /// Throws Error{device} with the nearest name when the program has no such kernel.
  const KernelSignature& signature(std::string_view kernel) const;
  std::vector<std::string> kernel_names() const;

 private:
  friend void keep_launch_code(const Device& device) noexcept;
  struct State;
  std::shared_ptr<State> state_;
};

/// Adds what the driver compiled at first launches (PoCL: 40-500 ms per kernel and local size) to the cache entries of
/// all programs of a device. Called after warm-up, so that a killed process does not lose it; a program that goes does
/// it too.
void keep_launch_code(const Device& device) noexcept;

}  // namespace lucarium
