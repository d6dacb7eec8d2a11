// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <CL/cl.h>

#include <array>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "lucarium/base/files/embedded_files.h"
#include "lucarium/compute/device/device.h"
#include "lucarium/compute/device/kernel_signature.h"
#include "lucarium/compute/program/source_library.h"

namespace lucarium {

/// What to compile. One program per stage: several related kernels, not one each and not all in one.
struct ProgramSpec {
  std::string name;                            ///< for messages and profiles: "path_tracing/integrator"
  std::vector<std::string> files;              ///< virtual names of the .cl entry files
  std::map<std::string, std::string> defines;  ///< -D name=value (empty value: -D name)
  bool mad_enable = true;                      ///< -cl-mad-enable; off where bitwise agreement with host code matters
};

/// A program as another process can build it.
struct ProgramSource {
  std::filesystem::path file;  ///< holds the whole source
  std::string options;         ///< of clBuildProgram
};

/// A built program. Copies share it.
class Program {
 public:
  Program() = default;
  /// Shares one of the same source, takes one that the device has kept (KeptPrograms) or has in its cache, or compiles.
  /// Throws Error{device}, first the compiler's first error with file and line; the whole log is in details().
  Program(Device& device, const SourceLibrary& library, const ProgramSpec& spec);

  explicit operator bool() const { return state_ != nullptr; }
  const std::string& name() const;
  Device& device() const;
  cl_program handle() const;
  bool from_cache() const;          ///< whether it came from disk, uncompiled, when it was made
  bool declares_built_ins() const;  ///< whether it was built by declarations of its own (built_ins.h)
  double build_seconds() const;     ///< wall time of compiling or loading; next to 0 for a kept one
  /// Whether the driver has no code yet for such launches, which other processes could compile.
  bool lacks_launch_code(const std::string& kernel, const std::array<size_t, 3>& local, bool is_large) const;
  /// For those processes; the first call writes the file. Only where lacks_launch_code().
  const ProgramSource& source() const;
  /// Throws Error{device} with the nearest name when the program has no such kernel.
  const KernelSignature& signature(std::string_view kernel) const;
  std::vector<std::string> kernel_names() const;

 private:
  friend void cache_specialized_kernels(const Device& device) noexcept;
  struct State;
  std::shared_ptr<State> state_;
};

/// The program of some kernel files of a plug-in, named without ".cl": make_program(device, my_technique_kernels(),
/// {"my_technique/add_light"}). It is called as its first file.
Program make_program(Device& device, const EmbeddedSources& sources, std::vector<std::string> files,
                     std::map<std::string, std::string> defines = {});

/// Adds what the driver compiled at first launches (PoCL: 40-500 ms per kernel and local size) to the cache entries of
/// all programs of a device. Called after warm-up, so that a killed process does not lose it; a program that goes does
/// it too.
void cache_specialized_kernels(const Device& device) noexcept;

/// Processor time of this process that went into making programs, until now [s].
double program_processor_seconds();

}  // namespace lucarium
