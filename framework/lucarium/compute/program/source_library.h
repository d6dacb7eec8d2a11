// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "lucarium/base/files/embedded_files.h"
#include "lucarium/base/hash.h"

namespace lucarium {

/// The folders of LUCARIUM_KERNEL_PATH. Files in them win over embedded ones of the same name. Warns about what is not
/// a folder.
std::vector<std::filesystem::path> kernel_path_roots();

/// Where kernel sources come from: embedded tables, over which the roots of LUCARIUM_KERNEL_PATH (colon-separated
/// folders that hold files by virtual name) win. The framework's own table is always included.
class SourceLibrary {
 public:
  SourceLibrary();  ///< the framework's sources and LUCARIUM_KERNEL_PATH
  void add(const EmbeddedSources& sources);

  /// Text of one file and the name that compilers show for it (the path on disk, or the virtual name).
  struct File {
    std::string text;
    std::string shown_name;
    std::string virtual_name;
  };
  /// Throws Error{device} naming the file, who includes it and the places searched.
  File find(std::string_view virtual_name, std::string_view included_from = "") const;
  bool contains(std::string_view virtual_name) const;

  /// Resolves `#include "…"` recursively (each file once) and emits `#line` so that messages name real files and
  /// lines. Knows #if only as "maybe": an include inside #if is resolved where it can be and else left to the compiler
  /// (headers shared with C++ name C++ headers there); outside #if, what cannot be resolved throws Error{device}.
  std::string preprocess(const std::vector<std::string>& entry_files) const;

  /// Of all that preprocess() may find; none where files of LUCARIUM_KERNEL_PATH may change at any time.
  std::optional<Hash128> fingerprint() const;

 private:
  std::vector<const EmbeddedSources*> tables_;
  std::vector<std::filesystem::path> roots_;
};

/// The virtual names that all libraries of this process were asked for, whether they had them or not: below a root of
/// LUCARIUM_KERNEL_PATH, no other file can change its programs.
std::vector<std::string> asked_sources();

}  // namespace lucarium
