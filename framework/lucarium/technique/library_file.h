// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <string>

namespace lucarium {

/// Why dlopen() must not be given a file: it would wait for ever at a pipe, and a library that is cut off ends the
/// process with SIGBUS when a page behind its end is touched. Empty where nothing of that is found; what is no ELF file
/// at all is left to dlopen(), which has words for it.
std::string library_damage(const std::filesystem::path& file);

}  // namespace lucarium
