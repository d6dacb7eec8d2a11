// SPDX-License-Identifier: Apache-2.0
#include "lucarium/base/files/missing_file.h"

#include <fmt/format.h>

#include <vector>

#include "lucarium/base/files/list_folder.h"
#include "lucarium/base/text/nearest_name.h"

namespace lucarium {
namespace fs = std::filesystem;

std::string advice_for_missing(const fs::path& file) {
  const fs::path folder = file.has_parent_path() ? file.parent_path() : fs::path(".");
  std::error_code failure;
  if (!fs::is_directory(folder, failure)) return fmt::format("; there is no folder '{}'", folder.string());
  std::vector<std::string> names;
  for (const fs::directory_entry& entry : list_folder(folder, failure))
    names.push_back(entry.path().filename().string());
  const std::string near = nearest_name(file.filename().string(), names);
  return near.empty() ? "" : fmt::format("; did you mean '{}'?", near);
}

}  // namespace lucarium
