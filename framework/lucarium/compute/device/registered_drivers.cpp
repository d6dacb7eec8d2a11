// SPDX-License-Identifier: Apache-2.0
#include "lucarium/compute/device/registered_drivers.h"

#include <dlfcn.h>

#include <algorithm>
#include <fstream>

namespace lucarium {

std::vector<UnloadableDriver> unloadable_drivers(const std::filesystem::path& folder) {
  std::vector<UnloadableDriver> found;
  std::error_code ignored;
  for (const std::filesystem::directory_entry& entry : std::filesystem::directory_iterator(folder, ignored)) {
    if (entry.path().extension() != ".icd") continue;
    std::ifstream file(entry.path());
    std::string library;
    if (!std::getline(file, library) || library.empty()) {
      found.push_back({entry.path().filename().string(), "it names no library"});
    } else if (void* handle = dlopen(library.c_str(), RTLD_LAZY | RTLD_LOCAL)) {
      dlclose(handle);
    } else {
      const char* reason = dlerror();
      found.push_back({entry.path().filename().string(), reason ? reason : library});
    }
  }
  std::sort(found.begin(), found.end(), [](const auto& a, const auto& b) { return a.file < b.file; });
  return found;
}

}  // namespace lucarium
