// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <string>
#include <vector>

namespace lucarium {

/// A driver that a file NAME.icd names (cl_khr_icd), and why it does not load.
struct UnloadableDriver {
  std::string file;    ///< as in /etc/OpenCL/vendors
  std::string reason;  ///< of the dynamic linker, e.g. an undefined symbol of an older library
};

/// Those of the drivers registered in `folder` that the dynamic linker refuses in this process; the OpenCL loader
/// leaves them out without a word. In the order of their names; empty where the folder is not there.
std::vector<UnloadableDriver> unloadable_drivers(const std::filesystem::path& folder);

}  // namespace lucarium
