// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "lucarium/base/hash.h"
#include "lucarium/compute/device/cl_handle.h"
#include "lucarium/compute/device/device.h"
#include "lucarium/compute/program/program.h"

namespace lucarium {

/// A whole program as it is given to the driver.
struct ProgramText {
  std::string source, options;
};

/// What `spec` gives to the driver: its defines and its preprocessed `sources`.
ProgramText program_text(const ProgramSpec& spec, const std::string& sources);

/// A program that the driver has built, and what is known of it. It does not hold the device, which may keep it when
/// nobody has it any more (Device::kept_programs).
struct BuiltProgram {
  std::string name;
  ClProgram program;
  std::map<std::string, KernelSignature, std::less<>> signatures;
  bool from_cache = false, declares_built_ins = false;

  std::optional<Hash128> request;    // of sources and specification; none where sources may change
  ProgramText text;                  // until it is made; where others can compile launch code, until it is written
  Hash128 key;                       // of the text
  std::string driver_program;        // see pocl_files.h; empty where there is none to keep
  std::set<std::string> kept_files;  // of the driver, in the cache entry
  ProgramSource source;

  /// Compiles it or takes it from the cache. What does not compile in the faster way is compiled as it is, and the
  /// driver's messages are of that. Throws Error{device}.
  void make(Device& device, const ProgramSpec& spec, const ProgramText& whole);
  /// Adds to the cache entry what the driver has compiled at first launches.
  void cache_specialized_kernels(Device& device) noexcept;
  std::vector<std::string> kernel_names() const;

 private:
  void use(Device& device, const ProgramText& given);
  bool load_text(Device& device, const ProgramSpec& spec, const ProgramText& given);
  /// Whether a whole entry was found and the driver took it.
  bool load(Device& device, const ProgramSpec& spec);
  void compile(Device& device, const ProgramSpec& spec);
  void set_signatures(const std::vector<KernelSignature>& list);
};

}  // namespace lucarium
