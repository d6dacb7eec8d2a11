// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "lucarium/compute/device/device.h"

namespace lucarium {

/// A word of "device_arguments" that is not allowed.
struct DeviceArgumentMistake {
  size_t index = 0;  ///< of the word
  std::string what;
};

/// Sets what the words of a comparison file's "device_arguments" say about the device of every run. Files come from
/// others, so that they may choose the device and its limits only: --device, --threads, --memory-limit and
/// --allocation-limit, each with a value of its form. Returns the first mistake, after which `device` is of no use.
std::optional<DeviceArgumentMistake> read_device_arguments(const std::vector<std::string>& words,
                                                           DeviceOptions& device);

/// The words that say so; limits as people write them ("2G"). What is 0 or empty is left out.
std::vector<std::string> write_device_arguments(const std::string& name, int threads, const std::string& memory_limit,
                                                const std::string& allocation_limit);

}  // namespace lucarium
