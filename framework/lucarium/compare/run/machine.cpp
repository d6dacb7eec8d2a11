// SPDX-License-Identifier: Apache-2.0
// Processor, memory and drivers that a comparison ran on; nothing that identifies the machine. Declared in
// comparison_result.h.
#include <sys/sysinfo.h>
#include <sys/utsname.h>

#include <fstream>
#include <thread>

#include "lucarium/base/error.h"
#include "lucarium/compare/results/comparison_result.h"

namespace lucarium {
namespace {

/// Value of the first line "key : value" of a file.
std::string find_value(const char* file, const std::string& key, char separator) {
  std::ifstream in(file);
  for (std::string line; std::getline(in, line);) {
    const size_t at = line.find(separator);
    if (!line.starts_with(key) || at == std::string::npos) continue;
    std::string value = line.substr(at + 1);
    const size_t first = value.find_first_not_of(" \t\"");
    if (first == std::string::npos) return "";
    return value.substr(first, value.find_last_not_of(" \t\"") - first + 1);
  }
  return "";
}

}  // namespace

Machine describe_machine() {
  Machine machine;
  machine.cpu = find_value("/proc/cpuinfo", "model name", ':');
  machine.logical_cores = std::thread::hardware_concurrency();
  struct sysinfo info {};
  if (::sysinfo(&info) == 0) machine.memory_bytes = uint64_t{info.totalram} * info.mem_unit;
  struct utsname name {};
  if (::uname(&name) == 0) machine.system = fmt::format("{} {} {}", name.sysname, name.release, name.machine);
  const std::string distribution = find_value("/etc/os-release", "PRETTY_NAME", '=');
  if (!distribution.empty()) machine.system = distribution + ", " + machine.system;
  return machine;
}

}  // namespace lucarium
