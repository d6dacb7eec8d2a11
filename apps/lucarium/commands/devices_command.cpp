// SPDX-License-Identifier: Apache-2.0
// lucarium devices: the OpenCL devices there are. Declared in commands.h.
#include "commands/commands.h"
#include "lucarium/base/json.h"
#include "lucarium/base/terminal.h"
#include "lucarium/base/text/byte_size.h"
#include "lucarium/compute/device/device.h"

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

int devices(bool json) {
  const std::vector<DeviceInfo> list = list_devices({});
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
  if (json) print_result("{}\n", ordered_json{{"schema", "lucarium-devices-1"}, {"devices", entries}}.dump(2));
  return 0;
}

}  // namespace

void add_devices_command(Command program, Action& action) {
  Command command = program.add_subcommand("devices", "list OpenCL devices");
  command.examples({"lucarium devices", "lucarium devices --json"}, "docs/devices.md");
  command.callback([&action] { action = [](const Messages& messages) { return devices(messages.json); }; });
}

}  // namespace lucarium::app
