// SPDX-License-Identifier: Apache-2.0
// lucarium devices: the OpenCL devices there are.
#include <nlohmann/json.hpp>

#include "commands.h"
#include "lucarium/base/byte_size.h"
#include "lucarium/base/terminal.h"
#include "options.h"

namespace lucarium::app {
using nlohmann::ordered_json;

namespace {

const char* type_name(DeviceType type) {
  switch (type) {
    case DeviceType::cpu: return "cpu";
    case DeviceType::gpu: return "gpu";
    case DeviceType::accelerator: return "accelerator";
    case DeviceType::other: break;
  }
  return "other";
}

int devices(const DeviceArguments& arguments, bool json) {
  const std::vector<DeviceInfo> list = list_devices(arguments.resolved());
  ordered_json entries = ordered_json::array();
  for (const DeviceInfo& device : list) {
    entries.push_back({{"index", device.index},
                       {"name", device.name},
                       {"type", type_name(device.type)},
                       {"vendor", device.vendor},
                       {"platform", device.platform},
                       {"driver", device.driver_version},
                       {"opencl", device.opencl_version},
                       {"compute_units", device.compute_units},
                       {"global_memory_bytes", device.global_memory_bytes},
                       {"max_allocation_bytes", device.max_allocation_bytes},
                       {"local_memory_bytes", device.local_memory_bytes}});
    if (json) continue;
    print_result("{}  {}  ({}, {} compute units, {} of memory, {} per buffer)\n   {}, {}, driver {}\n", device.index,
                 device.name, type_name(device.type), device.compute_units, format_bytes(device.global_memory_bytes),
                 format_bytes(device.max_allocation_bytes), device.platform, device.opencl_version,
                 device.driver_version);
  }
  if (json) print_result("{}\n", entries.dump(2));
  return 0;
}

}  // namespace

void add_devices_command(Command program, Action& action) {
  auto arguments = std::make_shared<std::pair<DeviceArguments, bool>>();
  Command command = program.add_subcommand("devices", "list OpenCL devices");
  arguments->first.add_to(command);
  command.add_flag("--json", arguments->second, "print JSON");
  command.callback(
      [arguments, &action] { action = [arguments] { return devices(arguments->first, arguments->second); }; });
}

}  // namespace lucarium::app
