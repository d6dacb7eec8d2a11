// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <optional>
#include <string>
#include <vector>

namespace lucarium {

/// A word of "device_arguments" that is not allowed.
struct DeviceArgumentMistake {
  size_t index = 0;  ///< of the word
  std::string what;
};

/// The words of a comparison file are passed to every run. Files come from others, so that they may choose the device
/// and its limits only: --device, --threads, --memory-limit and --allocation-limit, each with a value of its form.
/// Returns the first mistake.
std::optional<DeviceArgumentMistake> check_device_arguments(const std::vector<std::string>& words);

}  // namespace lucarium
