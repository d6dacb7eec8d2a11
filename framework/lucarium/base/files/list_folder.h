// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <system_error>
#include <vector>

namespace lucarium {

/// The entries of a folder, or, with recursive_directory_iterator, of all folders below it. Where reading fails,
/// `failure` says why and what came before is returned. (The ++ of these iterators throws, also in a range-based for.)
template <class Iterator = std::filesystem::directory_iterator>
std::vector<std::filesystem::directory_entry> list_folder(const std::filesystem::path& folder,
                                                          std::error_code& failure) {
  std::vector<std::filesystem::directory_entry> entries;
  for (Iterator entry(folder, failure), end; !failure && entry != end; entry.increment(failure)) {
    entries.push_back(*entry);
  }
  return entries;
}

}  // namespace lucarium
