// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "lucarium/base/files/json_lines.h"

namespace lucarium {

/// A JSON file that people write. Places in it are JSON pointers ("/scenes/0/camera"). All complaints are Error{input}
/// that names file, line and key.
class JsonFile {
 public:
  explicit JsonFile(std::filesystem::path path) : path_(std::move(path)), document_(read_json_with_lines(path_)) {}

  const std::filesystem::path& path() const { return path_; }
  const nlohmann::json& root() const { return document_.value; }

  [[noreturn]] void fail(const std::string& pointer, const std::string& what) const;
  /// It is an object, and has no other keys.
  void check_keys(const nlohmann::json& object, const std::string& pointer,
                  const std::vector<std::string>& allowed) const;
  double number(const nlohmann::json& value, const std::string& pointer) const;
  uint64_t count(const nlohmann::json& value, const std::string& pointer) const;  ///< a whole number from 0
  const std::string& text(const nlohmann::json& value, const std::string& pointer) const;

 private:
  std::filesystem::path path_;
  JsonWithLines document_;
};

/// The file says that it is of that form: its member "schema".
void check_schema(const JsonFile& file, const std::string& schema);

}  // namespace lucarium
