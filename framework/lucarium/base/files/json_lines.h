// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <map>
#include <string>

#include "lucarium/base/json.h"

namespace lucarium {

/// A JSON file with the line of each of its values, by JSON pointer ("/lights/0/type"), so that complaints about its
/// contents can name the line.
struct JsonWithLines {
  nlohmann::json value;
  std::map<std::string, int> lines;
  int line(const std::string& pointer) const;  ///< of the nearest known ancestor
};

/// Throws Error{input} naming file and line when it cannot be read or parsed. Comments are allowed.
JsonWithLines read_json_with_lines(const std::filesystem::path& file);

}  // namespace lucarium
