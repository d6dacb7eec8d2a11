// SPDX-License-Identifier: Apache-2.0
#include "lucarium/compare/request/device_arguments.h"

#include <algorithm>
#include <array>
#include <charconv>

#include "lucarium/base/error.h"
#include "lucarium/base/request_limits.h"
#include "lucarium/base/text/byte_size.h"

namespace lucarium {
namespace {

/// A word of the file's form; `set` throws Error{usage} for a value that it does not take.
struct Word {
  const char* name;
  void (*set)(DeviceOptions& device, const char* name, const std::string& value);
};

void set_name(DeviceOptions& device, const char*, const std::string& value) {
  if (value.empty() || value.front() == '-') throw_error(ErrorClass::usage, "'{}' names no device", value);
  device.selector = value;
}

void set_threads(DeviceOptions& device, const char*, const std::string& value) {
  int threads = -1;
  const auto [end, failure] = std::from_chars(value.data(), value.data() + value.size(), threads);
  const bool whole = failure == std::errc() && end == value.data() + value.size();
  if (!whole || threads < 0 || threads > max_threads)
    throw_error(ErrorClass::usage, "'{}' is not a number of threads from 0 to {}", value, max_threads);
  device.threads = threads;
}

void set_memory(DeviceOptions& device, const char* name, const std::string& value) {
  device.memory_limit_bytes = parse_bytes(value, name);
}

void set_allocation(DeviceOptions& device, const char* name, const std::string& value) {
  device.allocation_limit_bytes = parse_bytes(value, name);
}

// The form of comparison files, whatever the program's options are called.
constexpr Word name_word{"--device", set_name}, threads_word{"--threads", set_threads},
    memory_word{"--memory-limit", set_memory}, allocation_word{"--allocation-limit", set_allocation};
constexpr std::array words_of_files = {name_word, threads_word, memory_word, allocation_word};

}  // namespace

std::optional<DeviceArgumentMistake> read_device_arguments(const std::vector<std::string>& words,
                                                           DeviceOptions& device) {
  for (size_t i = 0; i < words.size(); ++i) {
    const size_t equals = words[i].find('=');
    const std::string name = words[i].substr(0, equals);
    const auto word =
        std::find_if(words_of_files.begin(), words_of_files.end(), [&](const Word& w) { return w.name == name; });
    if (word == words_of_files.end()) {
      return DeviceArgumentMistake{
          i, fmt::format("'{}' is not allowed here; {}, {}, {} and {} are, each with a value", words[i], name_word.name,
                         threads_word.name, memory_word.name, allocation_word.name)};
    }
    if (equals == std::string::npos && ++i == words.size())
      return DeviceArgumentMistake{i - 1, fmt::format("{} needs a value", name)};
    try {
      word->set(device, word->name, equals == std::string::npos ? words[i] : words[i].substr(equals + 1));
    } catch (const Error& error) {
      return DeviceArgumentMistake{i, error.what()};
    }
  }
  return std::nullopt;
}

std::vector<std::string> write_device_arguments(const std::string& name, int threads, const std::string& memory_limit,
                                                const std::string& allocation_limit) {
  std::vector<std::string> words;
  const auto add = [&words](const Word& word, const std::string& value) {
    words.insert(words.end(), {word.name, value});
  };
  if (!name.empty()) add(name_word, name);
  if (threads > 0) add(threads_word, std::to_string(threads));
  if (!memory_limit.empty()) add(memory_word, memory_limit);
  if (!allocation_limit.empty()) add(allocation_word, allocation_limit);
  return words;
}

}  // namespace lucarium
