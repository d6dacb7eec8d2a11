// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <filesystem>
#include <functional>
#include <set>
#include <string>
#include <vector>

#include "lucarium/compute/device/program_cache.h"

namespace lucarium {

/// What PoCL compiles lies in a folder per program below driver_folder(): program.bc from the build, and from each
/// kernel's first launch one shared object per local size, zero or other offset, small or large grid ("launch code",
/// 40-500 ms each). These functions carry both between that folder and cache entries. A program is named by its
/// folder, relative to driver_folder()->path().

/// Runs `build` and returns the program that appeared meanwhile, or the one that the same `key` had before in this
/// process; empty when neither is known.
std::string program_made_by(const Hash128& key, const std::function<void()>& build);

/// Whether there is code for launches of a kernel at offset 0, with this local size, for small or for large grids.
bool has_launch_code(const std::string& program, const std::string& kernel, const std::array<size_t, 3>& local,
                     bool is_large);

/// Writes a program's source to where other processes find it, and returns the file.
std::filesystem::path write_source(const Hash128& key, const std::string& source);

/// Paths of the present files.
std::set<std::string> list_driver_files(const std::string& program);
std::vector<DriverFile> read_driver_files(const std::set<std::string>& paths);

/// Writes the files of an entry to where PoCL will look for them. Throws when that fails, leaving no partial file.
void restore_driver_files(const Hash128& key, const CachedProgram& program);

/// Runs `take`, which asks PoCL for the program's binary, such that PoCL compiles nothing; does nothing when some
/// kernel has no launch code yet. PoCL would compile a generic variant of every kernel first, which takes as long as
/// the build and which it never uses while it has the program's intermediate code (it is in the binary). It is content
/// with any loadable file in that place, so launch code stands in meanwhile.
void without_generic_variants(const std::string& program, const std::vector<std::string>& kernels,
                              const std::function<void()>& take);

}  // namespace lucarium
