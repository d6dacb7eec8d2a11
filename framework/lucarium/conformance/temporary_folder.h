// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <unistd.h>

#include <filesystem>
#include <string>

#include "lucarium/base/error.h"

namespace lucarium::check {

/// A fresh empty folder, removed when the object goes.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    namespace fs = std::filesystem;
    std::string pattern = (fs::temp_directory_path() / "lucarium-check-XXXXXX").string();
    if (!mkdtemp(pattern.data()))
      throw_error(ErrorClass::input, "cannot create a folder in {}", fs::temp_directory_path().string());
    path_ = pattern;
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace lucarium::check
