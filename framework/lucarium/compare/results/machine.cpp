// SPDX-License-Identifier: Apache-2.0
#include "lucarium/compare/results/machine.h"

#include <sys/sysinfo.h>
#include <sys/utsname.h>

#include <cstdlib>
#include <fstream>
#include <thread>

#include "lucarium/base/error.h"
#include "lucarium/base/json.h"

namespace lucarium {
using nlohmann::ordered_json;
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

PieceMachine describe_piece_machine() {
  PieceMachine here;
  here.machine = describe_machine();
  ::getloadavg(&here.load, 1);
  return here;
}

ordered_json machine_json(const Machine& machine) {
  return {{"cpu", machine.cpu},
          {"logical_cores", machine.logical_cores},
          {"memory_bytes", machine.memory_bytes},
          {"system", machine.system}};
}

ordered_json piece_machine_json(const PieceMachine& machine) {
  ordered_json json = machine_json(machine.machine);
  if (!machine.device_index.empty()) json["device_index"] = machine.device_index;
  json["load"] = machine.load;
  if (machine.other_jobs) json["other_jobs"] = *machine.other_jobs;
  return json;
}

PieceMachine read_piece_machine(const nlohmann::json& json) {
  PieceMachine machine;
  machine.machine = {json.at("cpu"), json.at("system"), json.at("logical_cores"), json.at("memory_bytes")};
  machine.device_index = json.value("device_index", "");
  machine.load = json.at("load");
  if (json.contains("other_jobs")) machine.other_jobs = json["other_jobs"].get<unsigned>();
  return machine;
}

}  // namespace lucarium
