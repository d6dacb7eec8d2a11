// SPDX-License-Identifier: Apache-2.0
#include "lucarium/compare/request/device_arguments.h"

#include <charconv>

#include "lucarium/base/byte_size.h"
#include "lucarium/base/error.h"

namespace lucarium {
namespace {

constexpr int most_threads = 4096;

/// What is wrong with the value of an option; empty where nothing is.
std::string value_mistake(const std::string& option, const std::string& value) {
  if (option == "--device") {
    return value.empty() || value.front() == '-' ? fmt::format("'{}' names no device", value) : "";
  }
  if (option == "--threads") {
    int threads = -1;
    const auto [end, failure] = std::from_chars(value.data(), value.data() + value.size(), threads);
    const bool whole = failure == std::errc() && end == value.data() + value.size();
    return whole && threads >= 0 && threads <= most_threads
               ? ""
               : fmt::format("'{}' is not a number of threads from 0 to {}", value, most_threads);
  }
  try {
    parse_bytes(value, option);
    return "";
  } catch (const Error& error) {
    return error.what();
  }
}

}  // namespace

std::optional<DeviceArgumentMistake> check_device_arguments(const std::vector<std::string>& words) {
  for (size_t i = 0; i < words.size(); ++i) {
    const size_t equals = words[i].find('=');
    const std::string option = words[i].substr(0, equals);
    if (option != "--device" && option != "--threads" && option != "--memory-limit" && option != "--allocation-limit") {
      return DeviceArgumentMistake{i, fmt::format("'{}' is not allowed here; --device, --threads, --memory-limit and "
                                                  "--allocation-limit are, each with a value",
                                                  words[i])};
    }
    if (equals == std::string::npos && ++i == words.size()) {
      return DeviceArgumentMistake{i - 1, fmt::format("{} needs a value", option)};
    }
    const std::string value = equals == std::string::npos ? words[i] : words[i].substr(equals + 1);
    if (const std::string what = value_mistake(option, value); !what.empty()) return DeviceArgumentMistake{i, what};
  }
  return std::nullopt;
}

}  // namespace lucarium
