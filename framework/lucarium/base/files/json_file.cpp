// SPDX-License-Identifier: Apache-2.0
#include "lucarium/base/files/json_file.h"

#include <algorithm>

#include "lucarium/base/error.h"
#include "lucarium/base/text/nearest_name.h"

namespace lucarium {

using nlohmann::json;

void JsonFile::fail(const std::string& pointer, const std::string& what) const {
  throw_error(ErrorClass::input, "{}:{}: {}: {}", path_.string(), document_.line(pointer),
              pointer.empty() ? "the file" : pointer.substr(1), what);
}

void JsonFile::check_keys(const json& object, const std::string& pointer,
                          const std::vector<std::string>& allowed) const {
  if (!object.is_object()) fail(pointer, "must be an object");
  for (const auto& [key, value] : object.items()) {
    if (std::find(allowed.begin(), allowed.end(), key) != allowed.end()) continue;
    fail(pointer + "/" + key, "unknown key" + suggest_name(key, allowed));
  }
}

double JsonFile::number(const json& value, const std::string& pointer) const {
  if (!value.is_number()) fail(pointer, "must be a number");
  return value.get<double>();
}

uint64_t JsonFile::count(const json& value, const std::string& pointer) const {
  if (!value.is_number_unsigned()) fail(pointer, "must be a whole number from 0");
  return value.get<uint64_t>();
}

const std::string& JsonFile::text(const json& value, const std::string& pointer) const {
  if (!value.is_string()) fail(pointer, "must be a string");
  return value.get_ref<const std::string&>();
}

void check_schema(const JsonFile& file, const std::string& schema) {
  const json& root = file.root();
  if (!root.is_object() || !root.contains("schema") || root["schema"] != schema) {
    file.fail("/schema", fmt::format("must be \"{}\"", schema));
  }
}

}  // namespace lucarium
